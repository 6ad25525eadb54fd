"""The tree's segments by distance from the root, for sweeps over whole levels at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import IndexArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class TreeLevels:
    """The rows of a `SegmentTable`, level by level.

    Level k holds the rows `bounds[k]:bounds[k + 1]`. `branching[k]` are those with children and
    `first_child[k]` where each one's children begin, counted from the next level's first row.
    """

    bounds: tuple[int, ...]
    branching: tuple[IndexArray, ...]
    first_child: tuple[IndexArray, ...]

    @classmethod
    def of(cls, depth: IntArray, parent_row: IntArray) -> TreeLevels:
        """Levels of rows in breadth-first order, from their depth and their parents, (n,)."""
        levels = int(depth[-1]) + 1
        bounds = np.searchsorted(depth, np.arange(levels + 1))
        branching, first_child = [], []
        for k in range(levels - 1):
            parents, first = np.unique(parent_row[bounds[k + 1] : bounds[k + 2]], return_index=True)
            branching.append(parents.astype(np.int64))
            first_child.append(first.astype(np.int64))
        return cls(tuple(int(bound) for bound in bounds), tuple(branching), tuple(first_child))
