"""Whether the rigid bodies of an experiment fit its tissue, its box and one another."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import ScenarioError

from ..bodies.flight import Flight
from ..bodies.rigid_body import RigidBody
from ..bodies.shape_distance import distance_to
from ..bodies.shapes import Sphere
from ..checked_values import warn_user
from .checks import FARTHEST_CELLS

LEAST_PROJECTILE_CELLS = 5.0
"""Cells across a projectile below which its depth depends on the grid (PHYSICS 1.6)."""
LARGE = 1.0  # [m] [chosen: no projectile, blade or plate at a limb is larger]
TIMES_LARGER = 20.0  # than the tissue [chosen: plates may be larger, millimetres as metres are]
MOST_PROBES = 4000  # points of a body that are looked for in another [chosen: every cell of it]
OVERLAP = 0.05  # cells [chosen: bodies that touch are no overlap]


def refuse_misfits(bodies: Sequence[RigidBody], position: FloatArray, grid_spacing: float) -> None:
    """Refuse bodies of another scale than the tissue at `position`, far off, or in one another."""
    most = max(LARGE, TIMES_LARGER * float(np.max(np.ptp(position, axis=0))))
    for body in bodies:
        size = float(np.max(body.shape.upper - body.shape.lower))
        if size > most:
            raise ScenarioError(
                body.name,
                f"is {size:g} m across, must be at most {most:g} m for tissue of this size",
                "Sizes are metres: 4.5e-3 is 4.5 mm.",
            )
        if float(np.max(np.abs(body.place))) > FARTHEST_CELLS * grid_spacing:
            raise ScenarioError(
                f"{body.name} centre",
                f"is {body.place} m, must be within {FARTHEST_CELLS * grid_spacing:g} m",
                "Move everything to the origin.",
            )
    for one, other in combinations(bodies, 2):
        if "dynamic" in (one.motion, other.motion) and _overlap(one, other, grid_spacing):
            raise ScenarioError(
                one.name,
                f"and {other.name} are in one another: rigid bodies do not touch, both would fly "
                "as one through the other",
                "Move one of them, also in time by a longer way to the tissue.",
            )


def warn_of_body(body: RigidBody, flight: Flight, grid_spacing: float) -> None:
    """Warn of a body that the grid does not resolve, and of one that passes by."""
    cells = 2.0 * body.shape.inner_radius / grid_spacing
    if cells < LEAST_PROJECTILE_CELLS * (1.0 - 1e-6) and not body.cutting:
        warn_user(
            f"{body.name} is {cells:.1f} cells across; its depth depends on the grid below "
            f"{LEAST_PROJECTILE_CELLS:g}: use a grid_spacing of at most "
            f"{2.0 * body.shape.inner_radius / LEAST_PROJECTILE_CELLS:.3g} m"
        )
    if flight.direction is not None and not flight.meets_tissue:
        warn_user(f"{body.name} meets no tissue on its line of flight; its depth is NaN")


def _overlap(one: RigidBody, other: RigidBody, grid_spacing: float) -> bool:
    """Whether two bodies share space at the start."""
    apart = float(np.linalg.norm(np.subtract(one.place, other.place)))
    if apart > _radius(one) + _radius(other):
        return False
    if isinstance(one.shape, Sphere) and isinstance(other.shape, Sphere):
        return apart < one.shape.radius + other.shape.radius - OVERLAP * grid_spacing
    if isinstance(one.shape, Sphere):
        one, other = other, one
    world = _inside(one) @ one.turn.T + np.asarray(one.place)
    local = (world - np.asarray(other.place)) @ other.turn
    return bool((distance_to(other.shape, local) < -OVERLAP * grid_spacing).any())


def _radius(body: RigidBody) -> float:
    """Radius [m] of a ball around the centre of mass that holds the body."""
    corner = np.maximum(np.abs(body.shape.lower), np.abs(body.shape.upper))
    return float(np.linalg.norm(corner))


def _inside(body: RigidBody) -> FloatArray:
    """Points (n, 3) [m] in a body, in its own frame."""
    sampled = body.shape.distance
    assert sampled is not None  # every shape but the sphere is sampled
    index = np.argwhere(sampled.values <= 0.0)
    chosen = index[:: max(1, len(index) // MOST_PROBES)]
    points: FloatArray = sampled.lower + sampled.spacing * chosen
    return points
