"""Pieces of bone that no longer hang together with a main bone.

Two points of bone hang together where both are whole, were neighbours before the shot and have not
been pulled apart; the connected components of that graph are the pieces. What is crushed has lost
all bonds; how large its pieces are follows from what it costs to part them.
"""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, IndexArray, Vector3
from vulnus.core.wound_report import BoneFragment, BoneReport

from ..materials import CORTICAL_BONE

NEIGHBOUR_REACH = 1.6
"""Distance of neighbours before the shot over the points' spacing; chosen: the nearest shell of a
Poisson-disk set, so that a torn layer one point thick parts two pieces."""

PARTED_STRETCH = 1.3
"""Stretch of a bond that has parted; chosen: ten times the strain at which bone breaks."""

MAIN_SHARE = 0.1
"""Share of an unbroken bone's mass from which a piece is a main part of it; chosen."""

SPHERES = 24.0
"""Factor of `crushed_piece_mass` [M: Grady 1982, J. Appl. Phys. 53, 322]."""

LEAST_POINTS = 4
"""Points of the smallest fragment; chosen: fewer have no extent in all three directions."""


def bone_report(
    reference: AnyArray,
    position: AnyArray,
    mass: AnyArray,
    whole: BoolArray,
    *,
    spacing: float,
    strain_rate: float | None = None,
) -> BoneReport:
    """Fragments of the bone whose points (n, 3) [m] lay at `reference` and now lie at `position`.

    `mass` (n,) [kg]; `whole` (n,) says which points are not destroyed; `spacing` [m] is the least
    distance of points before; `strain_rate` [1/s] that at which bone was crushed, None where its
    pieces are not estimated.
    """
    mass = np.asarray(mass, np.float64)
    if len(mass) == 0:
        return BoneReport(mass=0.0, debris_mass=0.0, fragments=())
    now = np.asarray(position, np.float64)
    bone_of, piece_of = _pieces(np.asarray(reference, np.float64), now, whole, spacing)
    bone_mass = np.bincount(bone_of, mass)
    members = np.bincount(piece_of, whole.astype(np.float64))
    piece_mass = np.bincount(piece_of, mass * whole)
    its_bone = np.zeros(len(piece_mass), np.int64)
    its_bone[piece_of] = bone_of
    is_main = piece_mass >= MAIN_SHARE * bone_mass[its_bone]
    is_fragment = ~is_main & (members >= LEAST_POINTS)
    fragments = [
        BoneFragment(
            mass=float(piece_mass[piece]),
            position=_middle(now[piece_of == piece], mass[piece_of == piece]),
            points=int(members[piece]),
        )
        for piece in np.flatnonzero(is_fragment)
    ]
    debris = float(mass[~whole].sum() + piece_mass[~(is_main | is_fragment)].sum())
    return BoneReport(
        mass=float(mass.sum()),
        debris_mass=debris,
        debris_piece_mass=min(debris, crushed_piece_mass(strain_rate)) if strain_rate else 0.0,
        fragments=tuple(sorted(fragments, key=lambda piece: (-piece.mass, piece.position))),
    )


def _pieces(
    before: FloatArray, now: FloatArray, whole: BoolArray, spacing: float
) -> tuple[IndexArray, IndexArray]:
    """Number (n,) of the bone that each point was part of before, and of its piece now."""
    pairs = _neighbours(before, NEIGHBOUR_REACH * spacing)
    length = np.linalg.norm(before[pairs[:, 0]] - before[pairs[:, 1]], axis=1)
    apart = np.linalg.norm(now[pairs[:, 0]] - now[pairs[:, 1]], axis=1)
    holds = whole[pairs].all(axis=1) & (apart < PARTED_STRETCH * np.maximum(length, spacing))
    return _components(len(before), pairs), _components(len(before), pairs[holds])


def crushed_piece_mass(strain_rate: float) -> float:
    """Mass [kg] of a piece of cortical bone that was crushed at a strain rate [1/s].

    A piece's kinetic energy of expansion about its own middle pays for its new surface (Grady):

        size = (24 G / (rho rate²))^(1/3),   mass = rho size³ = 24 G / rate².
    """
    return SPHERES * CORTICAL_BONE.fracture_energy / strain_rate**2


def _neighbours(points: FloatArray, reach: float) -> IndexArray:
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(points).query_pairs(reach, output_type="ndarray"), np.int64)


def _components(count: int, pairs: IndexArray) -> IndexArray:
    """Number (count,) of the connected piece that each point belongs to."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, labels = connected_components(links, directed=False)
    return np.asarray(labels, np.int64)


def _middle(points: FloatArray, mass: FloatArray) -> Vector3:
    x, y, z = (float(c) for c in np.average(points, axis=0, weights=mass))
    return x, y, z
