"""The equation map: numbered equation of the paper -> function -> tests that name it.

A function or a law says `Equation: Chong2017 (13)` in its docstring (Python) or in the comment
in front of it (C++). A test says the same in its docstring. Without arguments this writes
`docs/theory/equation_map.md`; with `--check` it writes nothing and fails when an equation 1-13
has no function or no test, or when the written page is not what the code says now.
"""

from __future__ import annotations

import argparse
import ast
import pathlib
import re
import sys
from collections import defaultdict
from typing import NamedTuple

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "theory" / "equation_map.md"
EQUATIONS = range(1, 14)
TITLES = {
    1: "momentum of the solid",
    2: "momentum of blood (Navier-Stokes)",
    3: "momentum of blood in tissue (Brinkman)",
    4: "SPH interpolation",
    5: "smoothing kernel (poly6)",
    6: "density of a particle",
    7: "equation of state",
    8: "SPH gradient",
    9: "SPH Laplacian",
    10: "pressure force (spiky kernel)",
    11: "viscous force (viscosity kernel)",
    12: "gravity",
    13: "Darcy drag",
}
MARK = re.compile(r"Equations?: Chong2017((?:,? \(\d+\))+)")
CPP_NAME = re.compile(r"([A-Za-z_]\w*)\s*\([^;{}]*\)\s*(?:const)?\s*(?:noexcept)?\s*(?::[^{;]*)?\{")
CPP_TYPE = re.compile(r"^\s*(?:template\s*<[^>]*>\s*)?(?:struct|class)\s+(\w+)")


class Place(NamedTuple):
    """A function that names an equation."""

    name: str
    path: str
    line: int


def equations_named(text: str) -> set[int]:
    """The numbers in every `Equation: Chong2017 (n), (m)` of `text`."""
    return {int(n) for mark in MARK.finditer(text) for n in re.findall(r"\d+", mark.group(1))}


def python_places(path: pathlib.Path) -> list[tuple[int, Place]]:
    """Equations in the docstrings of the functions and classes of a Python file."""
    found = []
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, kinds):
            place = Place(node.name, path.relative_to(ROOT).as_posix(), node.lineno)
            found += [(n, place) for n in equations_named(ast.get_docstring(node) or "")]
    return found


def cpp_places(path: pathlib.Path) -> list[tuple[int, Place]]:
    """Equations in the comments of a C++ file, each with the function or type that follows."""
    found = []
    lines = path.read_text(encoding="utf-8").splitlines()
    for index, line in enumerate(lines):
        numbers = equations_named(line) if "//" in line else set()
        name = following_name(lines, index) if numbers else None
        if name:
            place = Place(name, path.relative_to(ROOT).as_posix(), index + 1)
            found += [(n, place) for n in numbers]
    return found


def following_name(lines: list[str], index: int) -> str | None:
    """The name of the function or type defined after line `index`, past comments."""
    code = [line for line in lines[index : index + 40] if not line.lstrip().startswith("//")]
    if code and (kind := CPP_TYPE.match(code[0])):
        return kind.group(1)
    for name in CPP_NAME.finditer("\n".join(code)):
        if name.group(1) not in {"if", "for", "while", "switch", "return", "VULNUS_HD"}:
            return name.group(1)
    return None


def collect() -> tuple[dict[int, list[Place]], dict[int, list[Place]]]:
    """Functions and tests by equation number."""
    functions: dict[int, list[Place]] = defaultdict(list)
    tests: dict[int, list[Place]] = defaultdict(list)
    for path in sorted((ROOT / "src").rglob("*.py")):
        for number, place in python_places(path):
            functions[number].append(place)
    for path in sorted([*(ROOT / "native").rglob("*.hpp"), *(ROOT / "native").rglob("*.cpp")]):
        for number, place in cpp_places(path):
            functions[number].append(place)
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        for number, place in python_places(path):
            if place.name.startswith(("test_", "Test")):
                tests[number].append(place)
    return functions, tests


def page(functions: dict[int, list[Place]], tests: dict[int, list[Place]]) -> str:
    """The Markdown page."""

    def cell(places: list[Place]) -> str:
        return "<br>".join(f"`{p.name}` in {p.path}" for p in places) or "missing"

    rows = [
        f"| ({n}) {TITLES[n]} | {cell(functions.get(n, []))} | {cell(tests.get(n, []))} |"
        for n in EQUATIONS
    ]
    head = [
        "# Equation map",
        "",
        "Every numbered equation of Chong et al. 2017, the functions that implement it and the",
        "tests that name it. Written by `tools/equation_map.py`; where the code departs from the",
        "printed form, [deviations](deviations.md) says how and why.",
        "",
        "| equation | functions | tests |",
        "|---|---|---|",
    ]
    return "\n".join([*head, *rows, ""])


def main() -> int:
    """Write the page, or check it."""
    parser = argparse.ArgumentParser(description="Write or check the equation map.")
    parser.add_argument("--check", action="store_true", help="write nothing, fail on a gap")
    arguments = parser.parse_args()
    functions, tests = collect()
    gaps = [f"equation ({n}) has no function" for n in EQUATIONS if not functions.get(n)]
    gaps += [f"equation ({n}) has no test" for n in EQUATIONS if not tests.get(n)]
    text = page(functions, tests)
    if not arguments.check:
        PAGE.parent.mkdir(parents=True, exist_ok=True)
        PAGE.write_text(text, encoding="utf-8")
    elif not PAGE.exists() or PAGE.read_text(encoding="utf-8") != text:
        gaps.append("docs/theory/equation_map.md is out of date: python tools/equation_map.py")
    for gap in gaps:
        print(f"equation map: {gap}", file=sys.stderr)
    return bool(gaps)


if __name__ == "__main__":
    sys.exit(main())
