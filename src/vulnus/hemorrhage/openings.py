"""Where a barrier is open: whether anything can cross it, and how large the holes are.

A field of test particles fills all space that a ball of their size can be in; it crosses the skin
where the space inside the limb and the space outside hang together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import BoolArray, Float32Array
from vulnus.core.handoff import InjuredLimb, Tissue

from . import _native
from .barriers import LimbBarriers

CLEARANCE = 0.5
"""Radius of a test particle over the blood's spacing: half, where two of them touch."""

SHELL = 1.0
"""Half thickness [cells] of the shell in which a hole's area is counted; chosen: as thin as the
grid resolves, and within the skin."""

SKIN_PRESENT = 0.25
"""Density of skin points, over the highest, from which there was skin before the shot; chosen: at
the face of a flat skin the kernel sees a half."""

HOLE_DENSITY = 0.5
"""Density of skin points over that before the shot below which the paper's barrier has a hole
(PHYSICS 1.4)."""


@dataclass(frozen=True, slots=True)
class Openings:
    """`area` [m²] of the holes in the skin that test particles can cross, 0 where none `leaks`.

    `sparse_area` [m²] is that where skin points are sparse, as `sparse_skin_area` says.
    """

    leaks: bool
    area: float
    sparse_area: float = 0.0


def skin_openings(barriers: LimbBarriers, particle_spacing: float) -> Openings:
    """Whether particles of this spacing [m] get out of the limb, and through how large a hole."""
    reached = crossed_space(barriers, CLEARANCE * particle_spacing)
    if not reached.any():
        return Openings(leaks=False, area=0.0)
    # Back to the holes' rim: what a test particle's middle reaches, grown by its radius.
    from scipy.ndimage import distance_transform_edt

    cell = barriers.grid.cell
    near = distance_transform_edt(~reached) * cell <= CLEARANCE * particle_spacing
    hole = near & (barriers.barrier > 0.0)
    middle = barriers.limb + np.float32(0.5 * barriers.skin_depth)
    return Openings(leaks=True, area=_area_on_surface(middle, hole, cell))


def crossed_space(barriers: LimbBarriers, clearance: float) -> BoolArray:
    """Nodes (nx, ny, nz) that a ball of radius `clearance` [m] reaches on its way out or in.

    All space around the limb and all space in it that hangs together with it; empty where the
    barrier parts the two.
    """
    from scipy.ndimage import label

    free = barriers.barrier > np.float32(clearance)
    pieces, _ = label(free)
    outside = free & (barriers.limb > np.float32(2.0 * barriers.grid.cell))
    around = np.unique(pieces[outside])
    depth = np.float32(_inner_depth(barriers, clearance))
    inner = np.unique(pieces[free & (barriers.limb < -depth)])
    both = np.intersect1d(around, inner)
    crossed: BoolArray = np.isin(pieces, both[both > 0])
    return crossed


def _inner_depth(barriers: LimbBarriers, clearance: float) -> float:
    """How deep [m] under the limb's surface the space behind its skin begins for certain."""
    return float(barriers.skin_depth) + clearance + 2.0 * barriers.grid.cell


def sparse_skin_area(wound: InjuredLimb, barriers: LimbBarriers) -> float:
    """Area [m²] where the density of skin points has fallen below half of that before the shot.

    The hole of the mode "presence", in which all skin is a barrier wherever it is, measured on the
    middle of the skin of the limb as it was.
    """
    grid = barriers.grid
    skin = wound.tissue == Tissue.SKIN
    reach = 2.0 * wound.spacing
    where = (grid.corner, grid.cell, grid.shape, reach)
    nothing = np.zeros(int(np.count_nonzero(skin)), np.float32)
    now, _ = _native.tissue_fraction(wound.position[skin], wound.volume[skin], nothing, *where)
    before, _ = _native.tissue_fraction(
        wound.reference_position[skin], wound.volume[skin], nothing, *where
    )
    floor = SKIN_PRESENT * float(before.max(initial=0.0))
    hole = (before > floor) & (now < HOLE_DENSITY * before)
    return _area_on_surface(barriers.limb + np.float32(0.5 * barriers.skin_depth), hole, grid.cell)


def _area_on_surface(distance: Float32Array, chosen: BoolArray, cell: float) -> float:
    """Area [m²] of the chosen part of the surface distance = 0: nodes in a thin shell around it."""
    shell = np.abs(distance) < np.float32(SHELL * cell)
    return float(np.count_nonzero(shell & chosen)) * cell**2 / (2.0 * SHELL)
