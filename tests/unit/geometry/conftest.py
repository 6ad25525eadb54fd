"""Measures of meshes that several tests of the geometry room share."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

from vulnus.core.handoff import TriangleSurface
from vulnus.geometry import _native


def _directed_edges(surface: TriangleSurface) -> np.ndarray:
    t = surface.triangles.astype(np.int64)
    return np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])


@pytest.fixture
def is_watertight() -> Callable[[TriangleSurface], bool]:
    """Each edge belongs to two triangles, once in each direction; no vertex is unused."""

    def check(surface: TriangleSurface) -> bool:
        edges = _directed_edges(surface)
        forward = edges[:, 0] << 32 | edges[:, 1]
        backward = edges[:, 1] << 32 | edges[:, 0]
        once = len(np.unique(forward)) == len(forward)
        used = len(np.unique(surface.triangles)) == len(surface.vertices)
        return once and used and np.array_equal(np.sort(forward), np.sort(backward))

    return check


@pytest.fixture
def euler_characteristic() -> Callable[[TriangleSurface], int]:
    def count(surface: TriangleSurface) -> int:
        edges = np.unique(np.sort(_directed_edges(surface), axis=1), axis=0)
        return len(surface.vertices) - len(edges) + len(surface.triangles)

    return count


@pytest.fixture
def with_threads() -> Iterator[Callable[[int], None]]:
    """Sets the number of threads; two again at the end."""
    yield _native.set_thread_count
    _native.set_thread_count(2)
