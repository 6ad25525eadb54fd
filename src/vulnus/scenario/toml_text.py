"""A scenario as TOML text in which every key stands with its unit, meaning and limits.

The text is itself a valid scenario that gives the same result.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Iterator
from typing import Any

import annotated_types
from pydantic.fields import FieldInfo

from .quantity import AUTO, Section, tables_of, unit_of

_WIDTH = 96
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_LIMITS = (
    (annotated_types.Ge, "ge", "≥"),
    (annotated_types.Gt, "gt", ">"),
    (annotated_types.Le, "le", "≤"),
    (annotated_types.Lt, "lt", "<"),
)


def as_toml(section: Section, header: str = "") -> str:
    """The text of `section` and its tables, under the comment `header`."""
    lines = [*_comment(header)] if header else []
    lines += _table(section, "")
    return "\n".join(lines) + "\n"


def value_as_toml(value: Any) -> str:
    """One value as TOML: text, number, truth value, array or inline table; None is "auto"."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, dict):
        inside = ", ".join(f"{_key(k)} = {value_as_toml(v)}" for k, v in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_as_toml(item) for item in value) + "]"
    return _text(AUTO if value is None else str(value))


def limits_of(field: FieldInfo) -> str:
    """The range of a key, as "> 0, ≤ 12"; empty where it has none."""
    found = []
    for kind, name, sign in _LIMITS:
        found += [
            f"{sign} {getattr(item, name):.10g}"
            for item in field.metadata
            if isinstance(item, kind)
        ]
    return ", ".join(found)


def _table(section: Section, path: str) -> Iterator[str]:
    inner = []
    for key, field in type(section).model_fields.items():
        value = getattr(section, key)
        if isinstance(value, Section):
            inner.append((f"[{path}.{key}]" if path else f"[{key}]", value))
            continue
        if value and tables_of(field):
            inner += [(f"[[{path}.{key}]]", item) for item in value]
            continue
        yield from _comment(field.description or key)
        notes = ", ".join(note for note in (unit_of(field), limits_of(field)) if note)
        yield f"{key} = {value_as_toml(value)}" + (f"  # {notes}" if notes else "")
    for header, value in inner:
        yield ""
        title = (type(value).__doc__ or "").split("\n")[0]
        yield from _comment(title.split(": ", 1)[-1])
        yield header
        yield from _table(value, header.strip("[]"))


def _comment(text: str) -> Iterator[str]:
    for paragraph in text.split("\n"):
        for line in textwrap.wrap(paragraph, _WIDTH) or [""]:
            yield f"# {line}".rstrip()


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _text(name)


def _text(value: str) -> str:
    # JSON's escapes are TOML's, but for DEL, which TOML wants escaped too.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
