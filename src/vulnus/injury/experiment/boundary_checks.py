"""Whether boundaries meet the tissue as they are meant to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError

from ..bodies.flight import Flight
from ..bodies.rigid_body import RigidBody
from ..boundaries import AbsorbingEnds, Boundary, HeldEnds, Wall
from ..checked_values import warn_user

DEEPEST_BEHIND = 1.0  # cells that tissue may reach behind a wall that it should not cross [chosen]
NEAR = 2.0  # cells from which a boundary is felt [D: the support of quadratic splines]
ON_NODES = 0.01  # cells from a layer of nodes [chosen: far above round-off]
ACROSS = 1e-3  # cells that a rigid body reaches behind a plane [chosen: above round-off]


def check_boundaries(
    boundaries: Sequence[Boundary],
    position: FloatArray,
    *,
    grid_spacing: float,
    grid_offset: Vector3,
) -> None:
    """Refuse boundaries that hold nothing, everything or the wrong side of the tissue."""
    for number, boundary in enumerate(boundaries, 1):
        if isinstance(boundary, Wall):
            name = f"wall (boundary {number})"
            _check_wall(name, boundary, position, grid_spacing)
            _warn_off_nodes(name, boundary, position, grid_spacing, grid_offset)
        elif isinstance(boundary, HeldEnds):
            _check_ends(f"hold_ends (boundary {number})", boundary, position, grid_spacing)
        elif isinstance(boundary, AbsorbingEnds):
            name = f"absorb_ends (boundary {number})"
            _check_ends(name, boundary, position, grid_spacing + boundary.thickness)
            _check_sponge(name, boundary, position)


def _check_wall(name: str, wall: Wall, position: FloatArray, grid_spacing: float) -> None:
    height = _height(wall, position)
    if float(height.max()) < 0.0:
        raise ScenarioError(
            name, "has all tissue behind it", "Turn its normal: it points to the free side."
        )
    behind = -float(height.min())
    if wall.kind != "fixed" and behind > DEEPEST_BEHIND * grid_spacing:
        raise ScenarioError(
            name,
            f"has tissue {behind:g} m behind it, {behind / grid_spacing:.2g} cells, must be at "
            f"most {DEEPEST_BEHIND:g}: a {wall.kind} wall lets nothing across",
            "Cut the body there: solid & HalfSpace(point=..., normal=...). To grip it use "
            'kind="fixed".',
        )


def _warn_off_nodes(
    name: str, wall: Wall, position: FloatArray, grid_spacing: float, grid_offset: Vector3
) -> None:
    normal = np.asarray(wall.normal)
    if np.max(np.abs(normal)) < 1.0 - 1e-12 or np.any(wall.velocity):
        return
    if float(np.abs(_height(wall, position)).min()) > NEAR * grid_spacing:
        return
    axis = int(np.argmax(np.abs(normal)))
    cells = (wall.point[axis] - grid_offset[axis]) / grid_spacing
    off = abs(cells - round(cells))
    if off > ON_NODES:
        warn_user(
            f"{name} is {off:.2g} cells from the nearest layer of nodes at "
            f"{grid_offset[axis] + grid_spacing * round(cells):g} m; it acts on nodes: put it there"
        )


def _check_ends(
    name: str, ends: HeldEnds | AbsorbingEnds, position: FloatArray, reach: float
) -> None:
    along = position @ np.asarray(ends.axis)
    lowest, highest = float(along.min()), float(along.max())
    spans = f"tissue spans {lowest:g} to {highest:g} m along its axis"
    if not ((along > ends.lower) & (along < ends.upper)).any():
        raise ScenarioError(name, f"holds all tissue: {spans}", "Move lower and upper apart.")
    if lowest > ends.lower + reach and highest < ends.upper - reach:
        raise ScenarioError(
            name,
            f"holds nothing: {spans}, the ends are {ends.lower:g} and {ends.upper:g} m",
            "Move an end to the body, or use add_wall for what is met later.",
        )


def _check_sponge(name: str, ends: AbsorbingEnds, position: FloatArray) -> None:
    along = position @ np.asarray(ends.axis)
    room = min(float(along.max()), ends.upper) - max(float(along.min()), ends.lower)
    if not ends.thickness < 0.5 * room:
        raise ScenarioError(
            name,
            f"has a thickness of {ends.thickness:g} m, must be less than half of the body between "
            f"its ends ({room:g} m)",
            "About ten cells are enough.",
        )


def refuse_half_bodies(
    boundaries: Sequence[Boundary],
    bodies: Sequence[RigidBody],
    flights: Sequence[Flight],
    grid_spacing: float,
) -> None:
    """Refuse a dynamic body that a plane of symmetry cuts, unless it runs on a rail."""
    planes = [wall for wall in boundaries if isinstance(wall, Wall) and wall.kind == "slip"]
    for body, flight in zip(bodies, flights, strict=True):
        if body.motion != "dynamic" or body.rail is not None:
            continue
        cut = [wall for wall in planes if _behind(wall, body, flight) > ACROSS * grid_spacing]
        alone = [wall for wall in cut if not any(_opposite(wall, other) for other in cut)]
        if alone:
            raise ScenarioError(
                body.name,
                f"reaches {_behind(alone[0], body, flight):g} m behind a slip wall, which mirrors "
                "the tissue but not a free body",
                "Model the whole, or use a RigidBody with a rail along the wall and the part of "
                "its mass that is before the wall.",
            )


def _behind(wall: Wall, body: RigidBody, flight: Flight) -> float:
    """How far [m] a body reaches behind a wall."""
    normal = np.asarray(wall.normal)
    centre = float((np.asarray(body.place) - np.asarray(wall.point)) @ normal)
    return flight.outline.reach(-normal, body.turn) - centre


def _opposite(wall: Wall, other: Wall) -> bool:
    return float(np.dot(wall.normal, other.normal)) < -1.0 + 1e-9


def _height(wall: Wall, position: FloatArray) -> FloatArray:
    """Distance (n,) [m] before the wall."""
    height: FloatArray = (position - np.asarray(wall.point)) @ np.asarray(wall.normal)
    return height
