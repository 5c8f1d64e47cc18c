"""Cases: read from files or made of dictionaries, changed, checked and run."""
from __future__ import annotations

import copy
import os
import pathlib
import re
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from . import command, progress, toml
from .result import Result


class Case:
    """A case of calor.

    `case`: a file, or a dictionary with the keys of a case file. `changes` and keyword arguments change keys: nested
    dictionaries leave the other keys of their sections as they are, a dotted key takes its value as a whole. `variant`
    takes a variant of the file. Files that a dictionary names are looked for in the current folder.

        Case("weld.toml", method="mlpg")
        Case("weld.toml", {"cloud.spacing": "2 mm"}, time={"end": "20 s"})
        Case({"title": "Plate", "method": "sph", "cloud": {...}, ...})
    """

    def __init__(self, case: str | os.PathLike[str] | Mapping[str, Any], changes: Mapping[str, Any] | None = None, *,
                 variant: str | None = None, **keys: Any) -> None:
        self.path = None if isinstance(case, Mapping) else pathlib.Path(case)
        self._written = copy.deepcopy(dict(case)) if isinstance(case, Mapping) else None
        self._changes = dict(toml.leaves({**(changes or {}), **keys}))
        self.variant = variant
        if self._written is not None and variant:
            raise command.CommandError("a case made of a dictionary has no variants: give the changes instead")

    @property
    def name(self) -> str:
        """What the result folder is called by default."""
        if self.path:
            return self.path.stem
        return re.sub(r"\W+", "-", str(self.to_dict().get("title", "case")).lower()).strip("-") or "case"

    def to_dict(self) -> dict[str, Any]:
        """The case as a dictionary, with the changes but without the variant and without defaults. Raises FileError and
        CaseError for a file that is none."""
        if self.path is None:
            case = copy.deepcopy(self._written)
        else:
            try:
                case = tomllib.loads(self.path.read_text())
            except OSError as error:
                raise command.FileError(f"{self.path}: the case cannot be read: {error.strerror}") from None
            except tomllib.TOMLDecodeError as error:
                at = re.search(r"line (\d+), column (\d+)", str(error))
                line, column = (int(at[1]), int(at[2])) if at else (None, None)
                raise command.CaseError(f"{self.path}: {error}", str(self.path), line, column, None) from None
        assert case is not None
        toml.merge(case, self._changes)
        return case

    def changed(self, changes: Mapping[str, Any] | None = None, **keys: Any) -> Case:
        """A copy with more changes."""
        case = copy.copy(self)
        case._changes = {**self._changes, **dict(toml.leaves({**(changes or {}), **keys}))}
        return case

    @contextmanager
    def _words(self) -> Iterator[list[str]]:
        """The case on the command line. A dictionary is in a file beside the files it names for that long."""
        if self.path is not None:
            words = [str(self.path), *(f"{key}={toml.value_text(value)}" for key, value in self._changes.items())]
            yield words + ([f"variant={self.variant}"] if self.variant else [])
            return
        handle, path = tempfile.mkstemp(prefix=f".{self.name}-", suffix=".toml", dir=".")
        try:
            with open(handle, "w") as file:
                file.write(toml.write(self.to_dict()))
            yield [os.path.basename(path)]
        finally:
            os.unlink(path)

    def check(self) -> str:
        """Builds everything and runs nothing: what `calor check` says of sizes, step and memory. Raises CalorError."""
        with self._words() as words:
            return command.run(["check", *words])[1]

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
        changes = ", ".join(f"{key}={value!r}" for key, value in self._changes.items())
        return f"<Case {what}{': ' + changes if changes else ''}>"

    def _repr_html_(self) -> str:
        from html import escape
        return f"<pre>{escape(toml.write(self.to_dict()))}</pre>"
