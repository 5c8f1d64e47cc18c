"""Cases: read from files or made of dictionaries, changed, checked and run."""
from __future__ import annotations

import contextlib
import copy
import os
import pathlib
import re
import shutil
import tempfile
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from . import command, progress, toml
from .result import Result, split_unit


Changes = Mapping[str, Any] | Sequence[str]
"""Of a case: values by key, or words as on the command line, such as "time.end=20 s" and "variant=fine"."""


def words_of(changes: Changes | None, keys: Mapping[str, Any]) -> list[str]:
    """Changes as words of the command line. Raises TypeError for values that a case cannot hold."""
    by_key = dict(keys) if changes is None or not isinstance(changes, Mapping) else {**changes, **keys}
    words = [] if changes is None or isinstance(changes, Mapping) else list(changes)
    return words + [f"{key}={toml.value_text(value)}" for key, value in by_key.items()]


def files_of(case: Any, folder: pathlib.Path) -> list[str]:
    """Names of the files that a case, or a part of it, names, relative to a folder; of a result that of its report.json."""
    names = []
    for text in dict.fromkeys(toml.texts(case)):
        for name in (text, f"{text}/report.json"):
            with contextlib.suppress(OSError, ValueError):  # texts need not be fit for a name
                if (folder / name).is_file():
                    names.append(name)
    return names


class Case:
    """A case of calor.

    `case`: a file, or a dictionary with the keys of a case file. `changes` and keyword arguments change keys, as key=value
    does on the command line: tables leave the other keys of their sections as they are. `variant` takes a variant. Files that
    a dictionary names are looked for in the current folder.

        Case("weld.toml", method="mlpg")
        Case("weld.toml", {"cloud.spacing": "2 mm"}, time={"end": "20 s"})
        Case({"title": "Plate", "method": "sph", "cloud": {...}, ...})
    """

    def __init__(self, case: str | os.PathLike[str] | Mapping[str, Any], changes: Changes | None = None, *,
                 variant: str | None = None, **keys: Any) -> None:
        self.path = None if isinstance(case, Mapping) else pathlib.Path(case)
        self._written = copy.deepcopy(dict(case)) if isinstance(case, Mapping) else {}
        self._changes = words_of(changes, keys) + ([f"variant={variant}"] if variant else [])

    @property
    def name(self) -> str:
        """What the result folder is called by default."""
        if self.path:
            return self.path.stem
        titles = [self._written.get("title", "case"), *(value for key, value in map(toml.change, self._changes) if key == "title")]
        return re.sub(r"\W+", "-", str(titles[-1]).lower()).strip("-") or "case"

    @property
    def folder(self) -> pathlib.Path:
        """Where the files are that the case names."""
        return self.path.parent if self.path else pathlib.Path(".")

    def to_toml(self) -> str:
        """The case as a run sees it, with its variant and changes and without defaults, as a file. Raises CalorError."""
        with self._words() as words:
            return command.run(["show", *words])[1]

    def to_dict(self) -> dict[str, Any]:
        """The same as a dictionary."""
        return tomllib.loads(self.to_toml())

    def write(self, path: pathlib.Path) -> None:
        """Writes the case as a run sees it, and beside it the files that it names beside itself. Raises CalorError."""
        text = self.to_toml()
        path.write_text(text)
        for name in files_of(tomllib.loads(text), self.folder):
            source, target = self.folder / name, path.parent / name
            is_beside = not pathlib.Path(name).is_absolute() and ".." not in pathlib.Path(name).parts
            if is_beside and source.resolve() != target.resolve():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, target)

    def changed(self, changes: Changes | None = None, **keys: Any) -> Case:
        """A copy with more changes."""
        case = copy.copy(self)
        case._changes = self._changes + words_of(changes, keys)
        return case

    @contextlib.contextmanager
    def _words(self) -> Iterator[list[str]]:
        """The case on the command line. A dictionary is in a file beside the files it names for that long."""
        if self.path is not None:
            yield [str(self.path), *self._changes]
            return
        handle, path = tempfile.mkstemp(prefix=f".{self.name}-", suffix=".toml", dir=".")
        try:
            with open(handle, "w") as file:
                file.write(toml.write(self._written))
            yield [os.path.basename(path), *self._changes]
        finally:
            os.unlink(path)

    def check(self) -> str:
        """Builds everything and runs nothing: what `calor check` says of sizes, step and memory. Raises CalorError."""
        with self._words() as words:
            return command.run(["check", *words])[1]

    def numbers(self) -> dict[str, str]:
        """The numbers that report.json of a run has, with their SI units, "" of counts and ratios. Builds everything and runs nothing. Raises CalorError."""
        with self._words() as words:
            return dict(map(split_unit, command.run(["check", *words, "--numbers"])[1].splitlines()))

    def run(self, folder: str | os.PathLike[str] | None = None, *, j: int = 1, show_progress: bool | None = None) -> Result:
        """Runs the case on `j` processes, into `folder` (default: results/NAME). A failed [[expect]] is no error: see
        Result.passed. `show_progress`: a bar in notebooks and on terminals; None: where there is one to see it.
        Raises CaseError, FileError or NumbersError."""
        into = pathlib.Path(folder) if folder is not None else pathlib.Path("results") / self.name
        with self._words() as words, progress.bar(show_progress) as show:
            quiet = [] if show else ["--quiet"]
            command.run(["run", *words, "-o", str(into), "-j", str(j), *quiet], show)
        return Result(into)

    def __repr__(self) -> str:
        what = str(self.path) if self.path else self.name
        return f"<Case {what}{': ' + ', '.join(self._changes) if self._changes else ''}>"

    def _repr_html_(self) -> str:
        from html import escape
        return f"<pre>{escape(self.to_toml())}</pre>"
