"""One point of a material on a prescribed path: what the laws say, without grid and bodies.

stretch = np.linspace(1.0, 1.2, 101)
history = material_point("copper", uniaxial_strain(stretch), duration=1e-3)
history.stress[:, 0, 0], history.plastic_strain

test = tensile_test("skin", np.linspace(1.0, 2.0, 201), rate=100.0)
test.nominal_stress.max()

The point runs the very return map of the solver (in double precision), a step for every entry of
the path. Equation: PHYSICS 1.4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from vulnus.core.arrays import AnyArray, FloatArray
from vulnus.core.errors import ScenarioError

from . import _native
from .checked_values import positive
from .material_model import UNLIMITED, Material, material_table
from .materials import material as material_named

# Order of the six entries of a symmetric tensor among native values.
ROWS, COLUMNS = np.array([0, 1, 2, 0, 1, 2]), np.array([0, 1, 2, 1, 2, 0])
FULL = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])

# Where a quantity stands among the native values of a point (bindings/injury.cpp, return_map).
STRAIN, PLASTIC_STRAIN, OPENING, DAMAGE, NETWORK = slice(0, 6), 6, 7, 8, slice(9, 15)
STATE, KIRCHHOFF = slice(0, 15), slice(15, 21)

DEFAULT_CELL = 1e-3
"""Grid cell [m] of a point that is given none; only softening depends on it [chosen]."""

LARGEST_LATERAL_STEP = 0.5
"""Lateral stretch of one step of a tensile test beyond which it is given up [chosen]."""

FREE_SIDE = 1e-14
"""Lateral stress over the moduli that counts as none [chosen: their round-off is 1e-16]."""

ROUND_OFF = 4.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True, slots=True, eq=False)
class MaterialPointHistory:
    """What a point went through; entry 0 is the start, first axis time, last axes tensors.

    `time` (m,) [s]; `deformation` F; `stress` Cauchy's, tension positive, and `kirchhoff` J times
    it [Pa]; `elastic_strain` the Hencky strain ln V_e that the elasto-plastic part carries;
    `plastic_strain` equivalent; `opening` the logarithmic volume strain of voids and cracks;
    `damage` 0 to 1; `plastic_work` [J/m³], per reference volume, that flow, voids and cracks have
    turned into heat (that of a breaking network is not in it).
    """

    time: FloatArray
    deformation: FloatArray
    kirchhoff: FloatArray
    elastic_strain: FloatArray
    plastic_strain: FloatArray
    opening: FloatArray
    damage: FloatArray
    plastic_work: FloatArray

    @property
    def volume_ratio(self) -> FloatArray:
        """J = det F."""
        ratio: FloatArray = np.linalg.det(self.deformation)
        return ratio

    @property
    def stress(self) -> FloatArray:
        """Cauchy stress [Pa], tension positive."""
        cauchy: FloatArray = self.kirchhoff / self.volume_ratio[..., None, None]
        return cauchy

    @property
    def pressure(self) -> FloatArray:
        """Mean stress [Pa], compression positive."""
        mean: FloatArray = -np.trace(self.stress, axis1=-2, axis2=-1) / 3.0
        return mean

    @property
    def von_mises_stress(self) -> FloatArray:
        """Equivalent stress q = sqrt(3/2) |dev| [Pa] of the Kirchhoff stress, which yields."""
        mean = np.trace(self.kirchhoff, axis1=-2, axis2=-1) / 3.0
        deviator = self.kirchhoff - mean[..., None, None] * np.eye(3)
        q: FloatArray = np.sqrt(1.5 * np.einsum("...ij,...ij->...", deviator, deviator))
        return q

    @property
    def nominal_stress(self) -> FloatArray:
        """First Piola-Kirchhoff stress P = tau F^-T, its entry 11 [Pa]: force x over first area."""
        inverse = np.linalg.inv(self.deformation)
        nominal: FloatArray = np.einsum(
            "...j,...j->...", self.kirchhoff[..., 0, :], inverse[..., 0, :]
        )
        return nominal


def material_point(
    material: str | Material,
    deformation: AnyArray,
    *,
    duration: float,
    grid_spacing: float = DEFAULT_CELL,
) -> MaterialPointHistory:
    """Take one point, or many side by side, along a path of deformation gradients.

    `deformation` (m, 3, 3), or (m, n, 3, 3) for n points, holds F at m equally spaced instants of
    `duration` [s]; the point is at rest and without stress at the first. Between two entries the
    velocity gradient of the midpoint rule of the solver, (F_k F_k-1^-1 - I)/dt, is applied, whose
    equivalent rate enters the law of rate. `grid_spacing` [m] is the cell over which softening
    spends the fracture energy. Raises `ScenarioError` for a path that inverts the point.
    """
    path = _checked_path(deformation)
    point = _Points(material, path.shape[1], grid_spacing)
    step = positive("duration", duration) / (len(path) - 1)
    rows = [point.reading()]
    for before, after in pairwise(path):
        increment = after @ np.linalg.inv(before)
        point.advance(increment, step)
        rows.append(point.reading())
    values = [np.array(column) for column in zip(*rows, strict=True)]
    if np.ndim(deformation) == 3:
        path, values = path[:, 0], [column[:, 0] for column in values]
    time = step * np.arange(len(path), dtype=np.float64)
    return MaterialPointHistory(time, path, *values)


def tensile_test(
    material: str | Material,
    stretch: AnyArray,
    *,
    rate: float,
    grid_spacing: float = DEFAULT_CELL,
) -> MaterialPointHistory:
    """Stretch a point along x with free sides: uniaxial stress.

    `stretch` (m,) is the length over the first length, beginning at 1 (below 1 it is compressed);
    `rate` [1/s] of the whole test is its nominal strain rate. The lateral stretch that leaves the
    sides free is found for every step. Raises `ScenarioError` where there is none.
    """
    axial = np.asarray(stretch, np.float64)
    if axial.ndim != 1 or len(axial) < 2 or not np.all(np.isfinite(axial) & (axial > 0.0)):
        raise ScenarioError(
            "stretch", "must be at least two positive numbers", "Try np.linspace(1, 1.5, 101)."
        )
    if axial[0] != 1.0 or np.any(np.diff(axial) == 0.0):
        raise ScenarioError("stretch", "must begin at 1 and change in every step", "Mend it.")
    point = _Points(material, 1, grid_spacing)
    steps = np.abs(np.diff(axial)) / positive("rate", rate)
    lateral, rows, path = 1.0, [point.reading()], [np.eye(3)]
    for k, step in enumerate(steps):
        along = axial[k + 1] / axial[k]
        across = point.free_lateral_increment(along, step)
        point.advance(np.diag([along, across, across])[None], step)
        lateral *= across
        rows.append(point.reading())
        path.append(np.diag([axial[k + 1], lateral, lateral]))
    values = [np.array(column)[:, 0] for column in zip(*rows, strict=True)]
    return MaterialPointHistory(np.concatenate([[0.0], np.cumsum(steps)]), np.array(path), *values)


def uniaxial_strain(stretch: AnyArray) -> FloatArray:
    """Path (m, 3, 3) that stretches x to `stretch` (m,) and holds the sides."""
    axial = np.asarray(stretch, np.float64)
    return _diagonal(axial, np.ones_like(axial), np.ones_like(axial))


def volumetric_strain(volume_ratio: AnyArray) -> FloatArray:
    """Path (m, 3, 3) that changes the volume to `volume_ratio` (m,) and keeps the shape."""
    edge = np.cbrt(np.asarray(volume_ratio, np.float64))
    return _diagonal(edge, edge, edge)


def simple_shear(shear: AnyArray) -> FloatArray:
    """Path (m, 3, 3) of simple shear of x along y by `shear` (m,), the tangent of the angle."""
    amount = np.asarray(shear, np.float64)
    path = np.tile(np.eye(3), (len(amount), 1, 1))
    path[:, 0, 1] = amount
    return path


def pure_shear(strain: AnyArray) -> FloatArray:
    """Path (m, 3, 3) with the Hencky strains +strain along x and -strain along y, (m,)."""
    amount = np.asarray(strain, np.float64)
    return _diagonal(np.exp(amount), np.exp(-amount), np.ones_like(amount))


class _Points:
    """Points of one material with their state, stepped by the native return map."""

    def __init__(self, material: str | Material, count: int, grid_spacing: float) -> None:
        chosen = material_named(material) if isinstance(material, str) else material
        rows = [chosen, _without_limits(chosen)]
        self._table = material_table(rows, positive("grid_spacing", grid_spacing))
        self._modulus = chosen.bulk_modulus + chosen.shear_modulus
        self._row = np.zeros(count, np.uint8)
        self._state = np.zeros((count, STATE.stop))
        self._kirchhoff = np.zeros((count, 3, 3))
        self._work = np.zeros(count)

    def reading(self) -> tuple[FloatArray, ...]:
        """Kirchhoff stress, elastic strain, plastic strain, opening, damage and plastic work."""
        state = self._state
        return (
            self._kirchhoff,
            _hencky(state[:, STRAIN]),
            state[:, PLASTIC_STRAIN],
            state[:, OPENING],
            state[:, DAMAGE],
            self._work,
        )

    def advance(self, increment: FloatArray, step: float) -> None:
        """Apply the increments F (n, 3, 3) of one step [s]."""
        trial, after = self._returned(increment, step)
        lost = _hencky(trial[:, STRAIN]) - _hencky(after[:, STRAIN])
        self._work = self._work + np.einsum("nij,nij->n", self._elastic_stress(after), lost)
        self._state = after[:, STATE]
        self._kirchhoff = after[:, KIRCHHOFF][:, FULL]

    def _returned(self, increment: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
        """State before and after the return (n, 15) and (n, 22)."""
        trial = self._state.copy()
        for place in (STRAIN, NETWORK):
            trial[:, place] = _advanced(self._state[:, place], increment)
        rate = _equivalent_rate((increment - np.eye(3)) / step)
        return trial, _native.return_map64(self._table, self._row, trial, rate)

    def _elastic_stress(self, after: FloatArray) -> FloatArray:
        """Kirchhoff stress (n, 3, 3) of the elastic strain, without the network's."""
        bare = np.zeros_like(self._state)
        bare[:, STRAIN] = after[:, STRAIN]
        row, rest = np.ones_like(self._row), np.zeros(len(bare))
        stress: FloatArray = _native.return_map64(self._table, row, bare, rest)[:, KIRCHHOFF]
        return stress[:, FULL]

    def free_lateral_increment(self, along: float, step: float) -> float:
        """Factor of the lateral stretch that leaves the sides of point 0 without stress."""

        def lateral_stress(across: float) -> float:
            _, after = self._returned(np.diag([along, across, across])[None], step)
            return float(after[0, KIRCHHOFF][1])

        if abs(lateral_stress(1.0)) <= FREE_SIDE * self._modulus:
            return 1.0
        for width in np.geomspace(abs(along - 1.0), LARGEST_LATERAL_STEP, 8):
            lower, upper = 1.0 - width, 1.0 + width
            if lateral_stress(lower) <= 0.0 <= lateral_stress(upper):
                return float(brentq(lateral_stress, lower, upper, xtol=1e-15, rtol=ROUND_OFF))
        raise ScenarioError(
            "tensile test", f"finds no free sides at a step of {along:g}", "Take more steps."
        )


def _without_limits(material: Material) -> Material:
    """The elastic part of a material alone."""
    return replace(
        material,
        yield_stress=UNLIMITED,
        friction=0.0,
        tensile_strength=UNLIMITED,
        pressure_cutoff=UNLIMITED,
        network_modulus=0.0,
        failure_stretch=UNLIMITED,
    )


def _checked_path(deformation: AnyArray) -> FloatArray:
    """The path as (m, n, 3, 3); refused where it is none."""
    path = np.asarray(deformation, np.float64)
    if path.ndim == 3:
        path = path[:, None]
    if path.ndim != 4 or path.shape[2:] != (3, 3) or len(path) < 2:
        raise ScenarioError(
            "deformation",
            f"has the shape {np.shape(deformation)}, must be (m, 3, 3) with at least two entries",
            "Give one deformation gradient for every instant.",
        )
    with np.errstate(invalid="ignore"):
        bad = ~(np.linalg.det(path) > 0.0)
    if bad.any():
        entry = int(np.argwhere(bad)[0, 0])
        raise ScenarioError(
            "deformation",
            f"entry {entry} turns the point inside out or is not finite (det F must be > 0)",
            "Check that entry.",
        )
    if not np.allclose(path[0], np.eye(3), rtol=0.0, atol=1e-12):
        raise ScenarioError(
            "deformation", "does not begin at the identity", "Begin with F = np.eye(3)."
        )
    return path


def _advanced(strain: FloatArray, increment: FloatArray) -> FloatArray:
    """F b F^T - I (n, 6) of b - I (n, 6); as `advance_strain` of elasticity.hpp."""
    step = increment - np.eye(3)
    half = step + increment @ strain[:, FULL]
    new = half + half @ step.transpose(0, 2, 1) + step.transpose(0, 2, 1)
    return np.ascontiguousarray(new[:, ROWS, COLUMNS])


def _equivalent_rate(gradient: FloatArray) -> FloatArray:
    """sqrt(2/3) |dev sym C| (n,) [1/s]; as `equivalent_strain_rate` of elasticity.hpp."""
    symmetric = 0.5 * (gradient + gradient.transpose(0, 2, 1))
    mean = np.trace(symmetric, axis1=1, axis2=2) / 3.0
    deviator = symmetric - mean[:, None, None] * np.eye(3)
    rate: FloatArray = np.sqrt(2.0 / 3.0 * np.einsum("nij,nij->n", deviator, deviator))
    return rate


def _hencky(strain: FloatArray) -> FloatArray:
    """Logarithmic strain (n, 3, 3) of b - I (n, 6)."""
    value, vector = np.linalg.eigh(strain[:, FULL])
    hencky: FloatArray = np.einsum("nia,na,nja->nij", vector, 0.5 * np.log1p(value), vector)
    return hencky


def _diagonal(*entries: FloatArray) -> FloatArray:
    path = np.zeros((len(entries[0]), 3, 3))
    for axis, entry in enumerate(entries):
        path[:, axis, axis] = entry
    return path
