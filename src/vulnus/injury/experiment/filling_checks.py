"""Whether the points of a body hold together on a grid, and how thick a combined solid is."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import ScenarioError

from ..bodies.combined_solids import ClosedSurface, Difference, FunctionSolid, Intersection, Union
from ..bodies.solids import Solid
from ..checked_values import warn_user

ON_EACH_OTHER = 1e-3  # of a particle's size: nearer points are the same one twice [chosen]
FARTHEST = 1.5
"""Cells between neighbours from which they no longer share a node's support [D: quadratic splines
reach 1.5 cells to each side]."""
DENSEST, THINNEST = 3.0, 0.1
"""Size of a particle over the distance to its neighbour, at most and least [chosen: a lattice has
1, random points 2; beyond it, some unit was mixed up]."""
LARGEST_PARTICLE = 2.0  # cells [chosen: it acts on three]

MOST_PROBES = 200_000
"""Particles at which a solid's depth is asked for [chosen: a tenth of a second]."""
DEEPEST = 20  # particles around which it is searched on
SEARCHED = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 5)] * 3), axis=-1).reshape(-1, 3)
"""Places (125, 3) around a particle, in spacings."""
THICKNESS_FOUND = 0.9
"""Part of a thickness that the search finds at least [chosen: 1/8 spacing is missing]."""


def refuse_scattered(
    name: str, position: FloatArray, volume: FloatArray, grid_spacing: float
) -> None:
    """Refuse points that lie on each other or far apart, or whose volume is not theirs."""
    size: FloatArray = volume ** (1.0 / 3.0)
    largest = int(np.argmax(size))
    if size[largest] > LARGEST_PARTICLE * grid_spacing:
        raise ScenarioError(
            f"{name}: volume",
            f"of particle {largest} is {volume[largest]:g} m³, a cube of "
            f"{size[largest] / grid_spacing:.3g} cells, must be at most {LARGEST_PARTICLE:g}",
            "Points should lie half a grid_spacing apart; volumes are m³.",
        )
    if len(position) < 2:
        return
    from scipy.spatial import cKDTree

    found: FloatArray = np.asarray(cKDTree(position).query(position, k=2)[0])
    apart = found[:, 1]
    twice = np.flatnonzero(apart < ON_EACH_OTHER * size)
    if len(twice):
        raise ScenarioError(
            f"{name}: position",
            f"{len(twice)} points lie on others, the first is number {twice[0]}",
            "Leave out what is there twice.",
        )
    distance = float(np.median(apart))
    cells = distance / grid_spacing
    told = f"has points {distance:g} m apart, {cells:.3g} cells of {grid_spacing:g} m"
    if cells > FARTHEST:
        raise ScenarioError(
            f"{name}: position",
            f"{told}, must be at most {FARTHEST:g}: they do not hold together",
            "Place them half a grid_spacing apart.",
        )
    if cells > 1.0 + 1e-6:
        warn_user(f"{name} {told}: it falls to pieces; half a cell is right")
    ratio = float(np.median(size)) / distance
    if not THINNEST <= ratio <= DENSEST:
        raise ScenarioError(
            f"{name}: volume",
            f"is that of cubes of {float(np.median(size)):g} m, but the points are {distance:g} m "
            "apart",
            f"Each should stand for about {distance**3:.3g} m³.",
        )


def thickest_part(solid: Solid, position: FloatArray, spacing: float) -> float | None:
    """Thickness [m] of a combined solid where it is thickest; None for one that knows its own.

    It is searched from the particles at `position` (n, 3) [m], `spacing` [m] apart.
    """
    if not isinstance(solid, ClosedSurface | Difference | FunctionSolid | Intersection | Union):
        return None
    probes = position[:: max(1, len(position) // MOST_PROBES)]
    depth = -solid.signed_distance(probes)
    deepest = probes[np.argsort(depth)[-DEEPEST:]]
    around = (deepest[:, None, :] + spacing * SEARCHED).reshape(-1, 3)
    found = max(float(depth.max()), -float(solid.signed_distance(around).min()))
    # The slope of a function need be 1 beside the surface only.
    return 2.0 * found * (2.0 if isinstance(solid, FunctionSolid) else 1.0)
