"""Points between material points of skin that still hold together, so that gaps are no holes.

Skin is one or two material points thick; a Poisson-disk set leaves gaps in so thin a sheet. Two
points that were neighbours before the injury, are intact and have not been torn apart have skin
between them.
"""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import BoolArray, FloatArray
from vulnus.core.handoff import InjuredLimb, Tissue

BOND_REACH = 3.0
"""Distance of neighbours before the injury over the points' spacing; chosen: across the largest
gap of a Poisson-disk set of skin, about 2.5."""

TORN_STRETCH = 1.54
"""Stretch at which skin fails (Ní Annaidh 2012; PHYSICS §1.1)."""

WITNESS_SLACK = 0.5
"""How much farther than before the skin point nearest to a bond's middle may be from it, over the
spacing; chosen: half a spacing tells skin in place from skin pushed aside by a projectile."""

DISTURBED_REACH = 10.0
"""How far from disturbed tissue bonds are made, over the spacing; chosen: farther off the tissue
under the skin closes its gaps."""

DISTURBED_SHARE = 0.2
"""Displacement over the spacing from which tissue is disturbed; chosen."""


def disturbed_points(wound: InjuredLimb) -> BoolArray:
    """Material points that were damaged or moved (n,)."""
    moved = np.linalg.norm(wound.position - wound.reference_position, axis=1)
    return np.asarray((moved > DISTURBED_SHARE * wound.spacing) | (wound.damage > 0.01))


def skin_bond_middles(wound: InjuredLimb, whole: BoolArray) -> FloatArray:
    """Middles (m, 3) [m] of the holding bonds of skin near disturbed tissue, as it lies now."""
    from scipy.spatial import cKDTree

    disturbed = disturbed_points(wound)
    if not disturbed.any():
        return np.empty((0, 3))
    spacing = wound.spacing
    skin = np.flatnonzero(wound.tissue == Tissue.SKIN)
    tree = cKDTree(wound.reference_position[disturbed])
    gap, _ = tree.query(
        wound.reference_position[skin], distance_upper_bound=DISTURBED_REACH * spacing
    )
    near = skin[np.isfinite(gap)]
    before = wound.reference_position[near].astype(np.float64)
    now = wound.position[near].astype(np.float64)
    neighbours = cKDTree(before)
    first, second = neighbours.query_pairs(BOND_REACH * spacing, output_type="ndarray").T
    stretched = np.linalg.norm(now[first] - now[second], axis=1)
    unstretched = np.linalg.norm(before[first] - before[second], axis=1)
    holds = whole[near[first]] & whole[near[second]]
    holds &= stretched < TORN_STRETCH * np.maximum(unstretched, spacing)
    first, second = first[holds], second[holds]
    middle_before = 0.5 * (before[first] + before[second])
    middle_now = 0.5 * (now[first] + now[second])
    if len(middle_now) == 0:
        return np.empty((0, 3))
    distance, witness = neighbours.query(middle_before)
    off = np.linalg.norm(now[witness] - middle_now, axis=1)
    in_place = whole[near[witness]] & (off < distance + WITNESS_SLACK * spacing)
    return np.asarray(middle_now[in_place])
