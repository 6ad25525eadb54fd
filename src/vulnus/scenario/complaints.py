"""What is wrong with a scenario file: file, line, key, value, limit, and what to do."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from vulnus.core.errors import ScenarioError

from .quantity import Section, may_be_auto, tables_of, unit_of
from .toml_text import limits_of, value_as_toml

_LONGEST_VALUE = 60
_KINDS = {
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text in quotes",
    "list_type": "must be an array [..]",
    "dict_type": "must be a table",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "finite_number": "must be a finite number",
    "string_too_short": "must not be empty",
}
_TABLE = re.compile(r"^\s*(\[\[?)\s*([^\[\]]+?)\s*\]")
_KEY = re.compile(r"""^\s*([A-Za-z0-9_\-."' ]+?)\s*=""")


def scenario_error(
    trouble: ValidationError, config: type[Section], *, file: str, text: str
) -> ScenarioError:
    """All complaints of `trouble` as one error; `text` is the file's, to find the lines."""
    lines = key_lines(text)
    found = [
        Complaint(error, config, known=sorted(all_keys(config)), lines=lines)
        for error in trouble.errors()
    ]
    if len(found) == 1:
        only = found[0]
        return ScenarioError(f"{file}{only.place}: {only.subject}", only.problem, only.advice)
    listing = "\n".join(
        f"  {one.place.removeprefix(', ')}{': ' if one.place else ''}"
        f"{one.subject}: {one.problem}. {one.advice}"
        for one in found
    )
    return ScenarioError(
        file,
        f"{len(found)} keys cannot be used:\n{listing}",
        "`vulnus scenario show demo` prints every key with its unit, meaning and limits",
    )


class Complaint:
    """One key that cannot be used."""

    def __init__(
        self,
        error: Mapping[str, Any],
        config: type[Section],
        *,
        known: Sequence[str],
        lines: Mapping[str, int],
    ) -> None:
        self.key = dotted(error["loc"])
        name = re.sub(r"\[\d+\]", "", self.key)
        line = lines.get(self.key) or lines.get(re.sub(r"\[\d+\]$", "", self.key))
        self.place = f", line {line}" if line else ""
        if error["type"] == "extra_forbidden":
            self.subject = self.key
            self.problem = "this key is not known"
            self.advice = nearest_key(name, known)
            return
        value = repr(error["input"])
        if isinstance(error["input"], dict):
            value = "{..}"
        if len(value) > _LONGEST_VALUE:
            value = value[:_LONGEST_VALUE] + "…"
        self.subject = f"{self.key} = {value}" if name in known else self.key
        self.problem = _problem(error)
        self.advice = _advice(config, name)


def dotted(location: Sequence[int | str]) -> str:
    """A key's place as `injury.aim.target_mm[1]`."""
    text = ""
    for part in location:
        text += f"[{part}]" if isinstance(part, int) else f".{part}" if text else str(part)
    return text


def all_keys(config: type[Section], path: str = "") -> Iterator[str]:
    """Every dotted key below `config`, tables included."""
    for name, field in config.model_fields.items():
        key = f"{path}.{name}" if path else name
        yield key
        inner = tables_of(field) or field.annotation
        if isinstance(inner, type) and issubclass(inner, Section):
            yield from all_keys(inner, key)


def nearest_key(key: str, known: Sequence[str]) -> str:
    """Advice that names the known key nearest to `key`.

    The same name in another table comes first, then the nearest of the same table, then of any.
    """
    table, _, name = key.rpartition(".")
    by_name: dict[str, str] = {}
    for other in sorted(known, key=lambda other: not other.startswith(table)):
        by_name.setdefault(other.rpartition(".")[2], other)
    if name in by_name:
        return f"Did you mean {by_name[name]}?"
    siblings = [k for k in known if k.rpartition(".")[0] == table]
    if without_unit := [k for k in siblings if k.startswith(f"{key}_")]:
        return f"Did you mean {without_unit[0]}?"
    close = difflib.get_close_matches(key, siblings, n=1, cutoff=0.6)
    if not close:
        close = [by_name[n] for n in difflib.get_close_matches(name, by_name, n=1, cutoff=0.6)]
    if not close:
        close = difflib.get_close_matches(key, known, n=1, cutoff=0.0)
    return f"Did you mean {close[0]}?" if close else "Remove it"


def key_lines(text: str) -> dict[str, int]:
    """Dotted key to its line number; a plain scan that is only used to show the line."""
    found: dict[str, int] = {}
    counts: dict[str, int] = {}
    table = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _TABLE.match(line):
            table = _numbered(_plain(header[2]), counts, begins_another=header[1] == "[[")
            found.setdefault(table, number)
        elif key := _KEY.match(line):
            name = _plain(key[1])
            found.setdefault(f"{table}.{name}" if table else name, number)
    return found


def _numbered(table: str, counts: dict[str, int], *, begins_another: bool) -> str:
    """`table` as pydantic names it: injury.projectiles[1].aim; `counts` the [[..]] so far."""
    if begins_another:
        counts[table] = counts.get(table, 0) + 1
    for name, count in counts.items():
        if table == name or table.startswith(f"{name}."):
            return f"{name}[{count - 1}]{table.removeprefix(name)}"
    return table


def _plain(key: str) -> str:
    return ".".join(part.strip().strip("\"'") for part in key.split("."))


def _problem(error: Mapping[str, Any]) -> str:
    kind, given = error["type"], error.get("ctx", {})
    signs = {
        "greater_than": ("gt", "greater than"),
        "greater_than_equal": ("ge", "at least"),
        "less_than": ("lt", "less than"),
        "less_than_equal": ("le", "at most"),
        "multiple_of": ("multiple_of", "a multiple of"),
    }
    if kind in signs:
        name, words = signs[kind]
        return f"must be {words} {given[name]:.10g}"
    if kind == "literal_error":
        return f"must be {given['expected']}"
    if kind in ("too_short", "too_long"):
        count = given.get("min_length", given.get("max_length"))
        return f"must have {count} entries, has {given['actual_length']}"
    if kind == "value_error":
        return str(given["error"])
    return _KINDS.get(kind) or str(error["msg"])


def _advice(config: type[Section], key: str) -> str:
    """What the key takes: unit, range, default."""
    section: type[Section] = config
    *tables, name = key.split(".")
    for table in tables:
        field = section.model_fields.get(table)
        inner = None if field is None else tables_of(field) or field.annotation
        if not (isinstance(inner, type) and issubclass(inner, Section)):
            return "Correct it"
        section = inner
    field = section.model_fields.get(name)
    if field is None or isinstance(field.default, Section):
        return "Correct it"
    limits, unit = limits_of(field), unit_of(field)
    takes = f"a value {limits} {unit}".strip() if limits else f"it in {unit}" if unit else ""
    default = value_as_toml(None if may_be_auto(field) else field.default)
    return f"Give {takes} (default {default})" if takes else f"The default is {default}"
