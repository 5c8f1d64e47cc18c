"""The command calor: where it is, how it is run, and its errors as exceptions."""
from __future__ import annotations

import contextlib
import functools
import hashlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Out = TypeVar("Out")

LONGEST_WORD = 128 * 1024  # of a command line, in bytes: MAX_ARG_STRLEN of Linux

PACKAGE = pathlib.Path(__file__).resolve().parent


class CalorError(RuntimeError):
    """What calor refused or could not do. `code`: its exit code; 6 where it could not start, or nothing more is known."""

    code = 6


class CommandError(CalorError):
    """A wrong command line, such as a key that is not key=value."""

    code = 2


class CaseError(CalorError):
    """The case is wrong. `file`, `line` and `column` (from 1; None: not in a file) say where, `key` names the key, e.g.
    "boundary.air.convection", `problem` and `cure` are the message."""

    code = 3

    def __init__(self, message: str, file: str | None = None, line: int | None = None, column: int | None = None, key: str | None = None) -> None:
        super().__init__(message)
        self.file, self.line, self.column, self.key = file, line, column, key


class FileError(CalorError):
    """A file cannot be read or written."""

    code = 4


class NumbersError(CalorError):
    """The computation failed; what was computed until then is kept."""

    code = 5


def find_command() -> str:
    """The command: of the source tree or installation that this package belongs to, else on the PATH."""
    for place in (PACKAGE.parent.parent / "build" / "release" / "calor", PACKAGE.parents[3] / "bin" / "calor"):
        if place.is_file() and os.access(place, os.X_OK):
            return str(place)
    found = shutil.which("calor")
    if not found:
        raise FileError("the command calor is not there: build it (./dev build), or put it on the PATH")
    return found


@functools.cache
def fingerprint() -> str:
    """Of the command that runs cases: another version, or another build of it, has another one. Raises FileError."""
    return hashlib.sha256(pathlib.Path(find_command()).read_bytes()).hexdigest()


def key_at(text: str, line: int) -> str | None:
    """The key that a line of a TOML file gives, with the section it is in; of a section's own line the section."""
    section, key = "", None
    for number, written in enumerate(text.splitlines(), 1):
        if head := re.match(r"\s*\[\[?\s*([^\]]+?)\s*\]\]?", written):
            section, key = re.sub(r"\s*\.\s*", ".", head[1]), ""
        elif assigned := re.match(r"\s*([A-Za-z0-9_.\"' -]+?)\s*=", written):
            key = assigned[1]
        if number == line:
            return ".".join(part for part in (section, key) if part) or None
    return None


def error_of(code: int, said: str) -> CalorError:
    """The exception for a message of calor and its exit code."""
    lines = [line for line in said.splitlines() if line.strip()]
    message = lines[-1].removeprefix("calor: ") if lines else f"calor ended with code {code}"
    if code == CaseError.code:
        if by_change := re.match(r"command line \(([^)]*)\): ", message):
            return CaseError(message, None, None, None, by_change[1])
        if located := re.match(r"(?P<file>.+?):(?P<line>\d+):(?P<column>\d+): ", message):
            file, line = located["file"], int(located["line"])
            key = None
            with contextlib.suppress(OSError):
                key = key_at(pathlib.Path(file).read_text(), line)
            return CaseError(message, file, line, int(located["column"]), key)
        return CaseError(message)
    for kind in (CommandError, FileError, NumbersError):
        if kind.code == code:
            return kind(message)
    error = CalorError(message)
    error.code = 128 - code if code < 0 else code  # a signal, as a shell tells it
    return error


def together(refused: Mapping[str, CalorError]) -> CalorError:
    """The exception for what all methods, by name, have refused: of their kind where they have one in common."""
    message = "; ".join(f"{method}: {why}" for method, why in refused.items())
    codes = {why.code for why in refused.values()}
    return error_of(codes.pop(), message) if len(codes) == 1 else NumbersError(message)


def run(words: Sequence[str], progress: Callable[[float, str], None] | None = None) -> tuple[int, str]:
    """Runs the command and returns its exit code, 0 or 1, and what it printed. `progress` is told the part of the run
    that is done, 0 to 1, and a line. An interrupt ends the run after its step. Raises CalorError for other codes."""
    if longest := max((word for word in words if len(word.encode()) >= LONGEST_WORD), key=len, default=""):
        raise CommandError(f"{longest.partition('=')[0]} is too long for the command line ({len(longest) / 1024:.0f} of {LONGEST_WORD // 1024} kB): write it into the case, "
                           "or into a file that the case names")
    environment = {**os.environ, "CALOR_TERMINAL": "1" if progress else "0"}
    said = b""
    with tempfile.TemporaryFile() as printed, \
         subprocess.Popen([find_command(), *words], stdin=subprocess.DEVNULL, stdout=printed, stderr=subprocess.PIPE,
                          env=environment) as process:
        assert process.stderr
        try:
            while chunk := os.read(process.stderr.fileno(), 1 << 16):
                said += chunk
                if progress and (shown := re.findall(rb"\r\x1b\[K *([\d.]+) %([^\r]*)", chunk)):
                    progress(min(1.0, float(shown[-1][0]) / 100), shown[-1][1].decode(errors="replace").strip())
        except KeyboardInterrupt:
            process.send_signal(signal.SIGINT)
            process.wait()
            raise
        process.wait()
        printed.seek(0)
        text = printed.read().decode()
    code = process.returncode
    if code not in (0, 1) or (code == 1 and not text):  # an expectation that failed is printed; what MPI ends with 1 is not
        raise error_of(code, re.sub(r"\r\x1b\[K[^\r]*", "", said.decode(errors="replace")))
    return code, text


def side_by_side(act: Callable[[Item], Out], items: Iterable[Item], j: int) -> list[Out]:
    """What `act` gives of all items, j at a time. After an interrupt or an error no further one is begun."""
    if j < 1:
        raise CommandError(f"{j} runs side by side: at least one goes at a time")
    pool = ThreadPoolExecutor(j)
    try:
        return list(pool.map(act, items))
    finally:
        pool.shutdown(cancel_futures=True)
