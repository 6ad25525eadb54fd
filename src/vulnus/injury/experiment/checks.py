"""What is refused before an experiment's first step, with the reason and what helps."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from ..bodies.solids import Solid, triple
from ..checked_values import is_a, length, positive, shown, vector, warn_user
from .filling_checks import THICKNESS_FOUND, refuse_scattered

if TYPE_CHECKING:
    from .particles import Filling

UNBOUNDED = 1e30
"""A place [m] that nothing reaches."""
MOST_THREADS = 4096
LEAST_COURANT = 1e-3  # [chosen: smaller steps only gather round-off]
LARGE_CELL = 0.1  # [m] [chosen: no limb is resolved with it, but 1 mm given as 1 is found]
LEAST_CELLS = 2.0
"""Cells across the thinnest part of a body; fewer have no bending and half their stiffness."""
BOX_EXTENTS = 5.0  # extents of the bodies beyond them to each side [chosen: room to fly]
LEAST_MARGIN = 20.0  # [m] [chosen: debris of 1 km/s for 20 ms; empty space costs nothing]
MOST_BOX_CELLS = 2.0**20
"""Cells along an edge of the box at most [D: the grid counts 2^20 to each side of its middle]."""
MOST_CELLS = 2.0**19  # that the bodies may span, which leaves room around them
FARTHEST_CELLS = 1e9
"""Cells from the origin at most [chosen: round-off is then a ten-millionth of a cell]."""
OVERLAP_DEPTH = 0.25  # of a point spacing inside another body: touching bodies stay below


def cell(grid_spacing: float) -> float:
    """The edge of a cell [m]; warns of one that is rather meant as millimetres."""
    spacing = length("grid_spacing", grid_spacing)
    if spacing > LARGE_CELL:
        warn_user(f"grid_spacing is {spacing:g} m; lengths are metres: 2e-3 is 2 mm")
    return spacing


def keyed_by_labels(name: str, given: object) -> None:
    """Refuse what does not tell something of each label."""
    is_a(name, given, Mapping, "Give a dictionary by label: {3: ...}.")
    assert isinstance(given, Mapping)
    for label in given:
        is_a(f"{name}: label", label, (int, np.integer), "Labels are whole numbers.")


def points_together(fillings: list[Filling], grid_spacing: float) -> None:
    """Take back the newest filling, with an error, where its points make no body."""
    newest = fillings[-1]
    try:
        refuse_scattered(newest.name, newest.position, newest.volume, grid_spacing)
    except ScenarioError:
        fillings.pop()
        raise


def courant_number(value: float) -> float:
    """The Courant number, refused outside [0.001, 1]."""
    number = positive("courant_number", value)
    if number < LEAST_COURANT:
        raise ScenarioError(
            "courant_number", f"is {number:g}, must be >= {LEAST_COURANT:g}", "Use 0.3 to 0.4."
        )
    if number > 1.0:
        raise ScenarioError("courant_number", f"is {number:g}, must be <= 1", "Use 0.3 to 0.4.")
    return number


def free_name(wish: str | None, kind: str, taken: Collection[str]) -> str:
    """`wish`, refused where it is taken; without a wish, `kind` with the first free number."""
    if wish is None:
        number = 1
        while f"{kind} {number}" in taken:
            number += 1
        return f"{kind} {number}"
    if not isinstance(wish, str) or not wish or "/" in wish:
        raise ScenarioError(f"{kind} name", f"is {shown(wish)}", "Give a text without '/'.")
    if wish in taken:
        raise ScenarioError(f"{kind} name", f"{wish!r} is taken", "Give every one its own name.")
    return wish


def body_resolved(
    name: str, solid: Solid, grid_spacing: float, *, thickest: float | None, confined: bool
) -> None:
    """Refuse a body that is thinner than two cells, unless walls confine it to a slice.

    `thickest` [m] is what was found of a combined solid, whose thinnest part is not known.
    """
    told = f"and needs {LEAST_CELLS:g}"
    advice = "Use a smaller grid_spacing; a slice between two walls may be one cell thick."
    if confined:
        return
    cells = solid.thinnest / grid_spacing
    if cells < LEAST_CELLS * (1.0 - 1e-9):
        raise ScenarioError(
            name,
            f"is {solid.thinnest:g} m thin, {cells:.2g} cells of {grid_spacing:g} m, {told}",
            advice,
        )
    if thickest is not None and thickest < THICKNESS_FOUND * LEAST_CELLS * grid_spacing:
        raise ScenarioError(
            name,
            f"is {thickest:.2g} m thin at its thickest, {thickest / grid_spacing:.2g} cells of "
            f"{grid_spacing:g} m, {told}",
            advice,
        )


def bodies_apart(fillings: Sequence[Filling]) -> None:
    """Refuse bodies that reach into each other."""
    for one in fillings:
        for other in fillings:
            if one is not other and other.solid is not None:
                _refuse_inside(one, other.name, other.solid)
    loose = [filling for filling in fillings if filling.solid is None]
    for index, one in enumerate(loose):
        for other in loose[index + 1 :]:
            _refuse_coincident(one, other)


def _refuse_inside(one: Filling, name: str, solid: Solid) -> None:
    lower, upper = solid.bounds
    near = ((one.position > lower) & (one.position < upper)).all(axis=1)
    if not near.any():
        return
    spacing = np.cbrt(one.volume[near])
    inside = solid.signed_distance(one.position[near]) < -OVERLAP_DEPTH * spacing
    if inside.any():
        place = one.position[near][inside][0].tolist()
        raise ScenarioError(
            one.name,
            f"overlaps {name}: {np.count_nonzero(inside)} of its particles are inside, the first "
            f"at {[round(x, 6) for x in place]} m",
            "Move one, or take it out of the other: solid - other.",
        )


def _refuse_coincident(one: Filling, other: Filling) -> None:
    from scipy.spatial import cKDTree

    distance, _ = cKDTree(other.position).query(one.position)
    close = distance < OVERLAP_DEPTH * np.cbrt(one.volume)
    if close.any():
        raise ScenarioError(
            one.name,
            f"overlaps {other.name}: {np.count_nonzero(close)} particles lie on each other",
            "Leave out the points that are in both.",
        )


def given_box(lower: Vector3 | None, upper: Vector3 | None) -> tuple[FloatArray, FloatArray] | None:
    """The box that was given, None where there is none."""
    if lower is None and upper is None:
        return None
    if lower is None or upper is None:
        raise ScenarioError("box", "has one corner only", "Give lower and upper, or none.")
    low, high = np.asarray(vector("lower", lower)), np.asarray(vector("upper", upper))
    if not (high > low).all():
        raise ScenarioError("upper", f"is {upper}, must be above lower {lower}", "Swap them?")
    return low, high


def box_around(
    position: FloatArray,
    box: tuple[FloatArray, FloatArray] | None,
    grid_spacing: float,
    grid_offset: Vector3,
) -> tuple[Vector3, Vector3]:
    """The box of the run: the given one or one with room, with its middle on a node of the grid."""
    lowest, highest = position.min(axis=0), position.max(axis=0)
    extent = float(np.max(highest - lowest))
    far = float(np.max(np.abs([lowest, highest])))
    if extent > MOST_CELLS * grid_spacing or far > FARTHEST_CELLS * grid_spacing:
        raise ScenarioError(
            "bodies",
            f"span {extent:g} m and reach {far:g} m from the origin, must be at most "
            f"{MOST_CELLS * grid_spacing:g} and {FARTHEST_CELLS * grid_spacing:g} m at cells of "
            f"{grid_spacing:g} m",
            "Use larger cells, or move everything to the origin.",
        )
    if box is None:
        margin = max(LEAST_MARGIN, BOX_EXTENTS * extent)
        margin = min(margin, 0.5 * (MOST_BOX_CELLS * grid_spacing - extent))
        low, high = lowest - margin, highest + margin
    else:
        low, high = box
        size = float(np.max(high - low))
        if size > MOST_BOX_CELLS * grid_spacing:
            raise ScenarioError(
                "box",
                f"is {size:g} m large, must be at most {MOST_BOX_CELLS * grid_spacing:g} m at "
                f"cells of {grid_spacing:g} m",
                "Make it smaller, or leave out lower and upper.",
            )
        outside = ~((position > low) & (position < high)).all(axis=1)
        if outside.any():
            index = int(np.flatnonzero(outside)[0])
            raise ScenarioError(
                "box",
                f"particle {index} at {position[index].tolist()} m lies outside of it",
                "Make the box larger, or leave out lower and upper.",
            )
    # The solver counts from the box's middle, so the middle must be a node.
    middle = np.asarray(grid_offset) + grid_spacing * np.rint(
        (0.5 * (low + high) - np.asarray(grid_offset)) / grid_spacing
    )
    half = np.maximum(high - middle, middle - low)
    return triple(middle - half), triple(middle + half)
