"""Fail where a page of the house names a file or folder of the repository that does not exist.

Looks at the backticked paths and relative links of the Markdown pages.
"""

from __future__ import annotations

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOPS = "src|native|tests|validation|benchmarks|examples|tools|docs"
CODE = re.compile(rf"`((?:{TOPS})/[\w./-]*)`")
LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)#\s]+)")


def pages() -> list[pathlib.Path]:
    """The Markdown pages that people read."""
    found = [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / "validation").rglob("*.md"),
    ]
    return sorted(path for path in found if "_build" not in path.parts)


def broken(path: pathlib.Path) -> list[str]:
    """Names in `path` that lead nowhere."""
    text = path.read_text(encoding="utf-8")
    wrong = [name for name in CODE.findall(text) if not (ROOT / name).exists()]
    wrong += [name for name in LINK.findall(text) if not (path.parent / name).exists()]
    return [f"{path.relative_to(ROOT)}: no such path: {name}" for name in wrong]


if __name__ == "__main__":
    lines = [line for path in pages() for line in broken(path)]
    print("\n".join(lines), file=sys.stderr)
    sys.exit(bool(lines))
