"""The state in which a body's particles begin: under stress, damaged, or worked.

A stress is turned into the elastic strain under which the material's own law gives it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray
from vulnus.core.errors import ScenarioError

from .. import _native
from ..checked_values import given_or_made, numbers
from ..material_model import Material, material_table
from ..material_point import (
    COLUMNS,
    DAMAGE,
    FULL,
    KIRCHHOFF,
    NETWORK,
    OPENING,
    PLASTIC_STRAIN,
    ROWS,
    STATE,
    STRAIN,
)

Given = AnyArray | float | Callable[[FloatArray], AnyArray]
"""One value for all particles, one for each, or a function of their positions (n, 3) [m]."""

NEWTON_STEPS = 40
"""Chosen: a strain that is found takes five."""
PROBE = 1e-7
"""Compressive strain by which the stiffness is probed [chosen: the root of round-off]."""
CLOSE_ENOUGH = 1e-9
"""Part of the moduli to which a stress is met [chosen: far below round-off of float32]."""
NO_STIFFNESS = 1e-8
"""Part of the largest stiffness that counts as none, as that of broken tissue against shear
[chosen: above what probing by `PROBE` sees]."""
LARGEST_STEP = 0.3
"""Largest change of a strain in one Newton step [chosen: keeps the law's exponentials in reach]."""
CHANGED = 1e-9
"""Opening or damage that shows a stress beyond a strength [chosen: above round-off]."""


def initial_state(
    name: str,
    material: Material,
    position: FloatArray,
    *,
    grid_spacing: float,
    stress: Given | None,
    damage: Given,
    plastic_strain: Given,
) -> FloatArray:
    """Native values (n, 15) of the particles at `position` (n, 3) [m], in the order of STATE."""
    state = np.zeros((len(position), STATE.stop))
    state[:, DAMAGE] = _given(f"{name}: damage", damage, position, ())
    state[:, PLASTIC_STRAIN] = _given(f"{name}: plastic_strain", plastic_strain, position, ())
    if not ((state[:, DAMAGE] >= 0.0) & (state[:, DAMAGE] <= 1.0)).all():
        raise ScenarioError(f"{name}: damage", "must be from 0 to 1", "Give 0 intact, 1 broken.")
    if not (state[:, PLASTIC_STRAIN] >= 0.0).all():
        raise ScenarioError(f"{name}: plastic_strain", "must be >= 0", "It only grows.")
    if stress is not None:
        wanted = _given(f"{name}: stress", stress, position, (3, 3))
        _refuse_asymmetric(name, wanted)
        law = _Law(name, material, grid_spacing)
        law.strain_for(wanted, state)
    return state


def volume_ratio(state: FloatArray) -> FloatArray:
    """J (n,) of particles in this state: present over undeformed volume."""
    ratio: FloatArray = np.sqrt(np.linalg.det(state[:, STRAIN][:, FULL] + np.eye(3)))
    return ratio * np.exp(state[:, OPENING])


class _Law:
    """The law of a material, asked for its stress under diagonal strains."""

    def __init__(self, name: str, material: Material, grid_spacing: float) -> None:
        self._name = name
        self._table = material_table([material], grid_spacing)
        self._stiffness = material.bulk_modulus + material.shear_modulus + material.network_modulus
        self._bulk_modulus = material.bulk_modulus
        self._has_network = material.network_modulus > 0.0

    def strain_for(self, stress: FloatArray, state: FloatArray) -> None:
        """Put into `state` (n, 15) the strain under which the Cauchy `stress` (n, 3, 3) stands."""
        keys = np.column_stack([stress.reshape(-1, 9), state[:, DAMAGE], state[:, PLASTIC_STRAIN]])
        distinct, index = np.unique(keys, axis=0, return_inverse=True)
        principal, axes = np.linalg.eigh(distinct[:, :9].reshape(-1, 3, 3))
        base = np.zeros((len(distinct), STATE.stop))
        base[:, DAMAGE], base[:, PLASTIC_STRAIN] = distinct[:, 9], distinct[:, 10]
        after = self._solved(principal, base)
        index = np.ravel(index)
        state[:, STRAIN] = _turned(after[:, STRAIN], axes)[index]
        state[:, PLASTIC_STRAIN] = after[index, PLASTIC_STRAIN]
        if self._has_network:
            state[:, NETWORK] = _turned(after[:, NETWORK], axes)[index]

    def _solved(self, wanted: FloatArray, base: FloatArray) -> FloatArray:
        """Values (n, 22) after the return with the principal Cauchy stresses (n, 3), by Newton.

        What exceeds the yield stress at rest has flown; the network bears the rest.
        """
        mean = wanted.mean(axis=1, keepdims=True) / (3.0 * self._bulk_modulus)
        hencky = np.repeat(mean, 3, axis=1)
        for _ in range(NEWTON_STEPS):
            missing = wanted - self._stress(hencky, base)
            if np.max(np.abs(missing)) <= CLOSE_ENOUGH * self._stiffness:
                break
            columns = [
                (wanted - missing - self._stress(hencky - PROBE * unit, base)) / PROBE
                for unit in np.eye(3)
            ]
            stiffness = np.stack(columns, axis=-1)
            step = (np.linalg.pinv(stiffness, rcond=NO_STIFFNESS) @ missing[..., None])[..., 0]
            hencky += np.clip(step, -LARGEST_STEP, LARGEST_STEP)
        after = self._returned(hencky, base)
        damage = self._returned(np.zeros_like(hencky), base)[:, DAMAGE]  # with that of its work
        kept = (np.abs(after[:, OPENING]) < CHANGED) & (after[:, DAMAGE] < damage + CHANGED)
        met = np.abs(wanted - self._stress(hencky, base)).max(axis=1)
        bad = ~(kept & (met <= 10.0 * CLOSE_ENOUGH * self._stiffness))
        if bad.any():
            raise ScenarioError(
                f"{self._name}: stress",
                f"with principal values {wanted[bad][0].round(3).tolist()} Pa is beyond what the "
                "material bears",
                "Stay below its yield stress at rest and its strengths; a damaged one bears less.",
            )
        return after

    def _returned(self, hencky: FloatArray, base: FloatArray) -> FloatArray:
        trial = base.copy()
        trial[:, :3] = np.expm1(2.0 * hencky)
        if self._has_network:
            trial[:, NETWORK.start : NETWORK.start + 3] = trial[:, :3]
        row, rate = np.zeros(len(base), np.uint8), np.zeros(len(base))
        after: FloatArray = _native.return_map64(self._table, row, trial, rate)
        return after

    def _stress(self, hencky: FloatArray, base: FloatArray) -> FloatArray:
        """Principal Cauchy stresses (n, 3) [Pa] under these strains."""
        kirchhoff = self._returned(hencky, base)[:, KIRCHHOFF][:, :3]
        cauchy: FloatArray = kirchhoff * np.exp(-hencky.sum(axis=1))[:, None]
        return cauchy


def _given(name: str, value: Given, position: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """A value for every particle (n, ...), refused where it does not fit or is not finite."""
    array = numbers(given_or_made(name, value, position))
    wanted = (len(position), *shape)
    fits = array.shape in (shape, wanted)
    if not fits or not np.isfinite(array).all():
        each = " ".join(map(str, shape)) or "one number"
        raise ScenarioError(
            name,
            f"has the shape {array.shape} or a value that is not finite",
            f"Give {each} for all, an array {wanted}, or a function of the positions (n, 3).",
        )
    return np.array(np.broadcast_to(array, wanted))


def _turned(strain: FloatArray, axes: FloatArray) -> FloatArray:
    """Six entries (n, 6) of tensors whose entries xx, yy, zz lie along `axes` (n, 3, 3)."""
    tensor = np.einsum("nia,na,nja->nij", axes, strain[:, :3], axes)
    six: FloatArray = tensor[:, ROWS, COLUMNS]
    return six


def _refuse_asymmetric(name: str, stress: FloatArray) -> None:
    size = np.abs(stress).max(initial=0.0)
    if np.abs(stress - stress.transpose(0, 2, 1)).max(initial=0.0) > 1e-9 * size:
        raise ScenarioError(f"{name}: stress", "is not symmetric", "Give a (3, 3) with s = s.T.")
