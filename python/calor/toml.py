"""Cases as dictionaries: written as TOML, and changes as words of the command line."""
from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from .command import CommandError


def key_text(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key)


def value_text(value: Any) -> str:
    """A value on one line. Raises TypeError for what a case cannot hold."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key_text(key)} = {value_text(item)}" for key, item in value.items()) + " }"
    if hasattr(value, "tolist"):  # of numpy
        return value_text(value.tolist())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(value_text, value)) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    raise TypeError(f"a case holds texts, numbers, true and false, lists and dictionaries, not {value!r}")


def change(text: str) -> tuple[str, Any]:
    """("time.end", "20 s") of "time.end=20 s": as on the command line of calor, a value that is no TOML is a text. Raises
    CommandError."""
    key, equals, value = text.partition("=")
    if not equals or not key:
        raise CommandError(f"'{text}' is no change: write key=value")
    try:
        return key.strip(), tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key.strip(), value


def listed(value: Any) -> list[Any]:
    """A list; where a case takes one, a single value may go without brackets."""
    return value if isinstance(value, list) else [value]


def texts(value: Any) -> Iterator[str]:
    """All texts among the values of a case."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, (Mapping, list, tuple)):
        for part in value.values() if isinstance(value, Mapping) else value:
            yield from texts(part)


def write(case: Mapping[str, Any], path: str = "") -> str:
    """A dictionary as TOML: plain keys, then sections."""
    lines, sections = [], []
    for key, value in case.items():
        name = f"{path}{key_text(key)}"
        if isinstance(value, Mapping):
            inner = write(value, f"{name}.")
            has_keys = any(not isinstance(item, Mapping) for item in value.values()) or not value
            sections.append(f"\n[{name}]\n{inner}" if has_keys else inner)
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            sections += [f"\n[[{name}]]\n{write(item, f'{name}.')}" for item in value]
        else:
            lines.append(f"{key_text(key)} = {value_text(value)}\n")
    return "".join(lines + sections)
