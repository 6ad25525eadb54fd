"""The bleeding solver's step in NumPy, pair by pair: slow, plain, the same laws."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray


@dataclass(frozen=True)
class Kernels:
    """W, -W'(r) and the viscous Laplacian of one kernel set; `h` [m] is the cut-off."""

    name: str
    h: float

    def density(self, r: FloatArray) -> FloatArray:
        h, q = self.h, np.clip(1.0 - r / self.h, 0.0, None)
        if self.name == "mueller2003":
            return 315.0 / (64.0 * np.pi * h**9) * np.clip(h**2 - r**2, 0.0, None) ** 3
        return 21.0 / (2.0 * np.pi * h**3) * q**4 * (4.0 * r / h + 1.0)

    def slope(self, r: FloatArray) -> FloatArray:
        h, q = self.h, np.clip(1.0 - r / self.h, 0.0, None)
        if self.name == "mueller2003":
            return 45.0 / (np.pi * h**4) * q**2
        return 210.0 / (np.pi * h**5) * r * q**3

    def laplacian(self, r: FloatArray) -> FloatArray:
        h, q = self.h, np.clip(1.0 - r / self.h, 0.0, None)
        if self.name == "mueller2003":
            return 45.0 / (np.pi * h**5) * q
        return 2.0 * 210.0 / (np.pi * h**5) * q**3


@dataclass(frozen=True)
class TwinFluid:
    """Numbers of the fluid; the scales are those of the native settings."""

    kernels: Kernels
    mass: float
    density: float
    viscosity: float
    sound_speed: float
    dissipation: float
    density_scale: float
    gradient_scale: float
    laplacian_scale: float
    clamped: bool = True


def densities(fluid: TwinFluid, position: FloatArray) -> FloatArray:
    """Equation: Chong2017 (6), with the self term."""
    r = np.linalg.norm(position[:, None] - position[None], axis=2)
    rho = fluid.mass * fluid.density_scale * fluid.kernels.density(r).sum(axis=1)
    # Without a clamp blood parts at 95 % of its rest density (chosen; see wcsph_sums.cpp).
    return np.maximum(rho, (0.05 if fluid.clamped else 0.95) * fluid.density)


def pressures(fluid: TwinFluid, density: FloatArray) -> FloatArray:
    """Equation: Chong2017 (7)."""
    p = fluid.sound_speed**2 * (density - fluid.density)
    return np.clip(p, 0.0, None) if fluid.clamped else p


def accelerations(
    fluid: TwinFluid, position: FloatArray, velocity: FloatArray, gravity: FloatArray
) -> FloatArray:
    """Equations: Chong2017 (10), (11), (12), per mass."""
    rho = densities(fluid, position)
    p = pressures(fluid, rho)
    offset = position[:, None] - position[None]
    r = np.linalg.norm(offset, axis=2)
    np.fill_diagonal(r, 1.0)
    direction = offset / r[:, :, None]
    other = 1.0 - np.eye(len(position))
    motion = velocity[None] - velocity[:, None]
    closing = np.clip(np.einsum("ijk,ijk->ij", motion, direction), 0.0, None)
    shock = np.minimum(fluid.dissipation * closing, fluid.sound_speed) * closing / fluid.density
    term = (p / rho**2)[:, None] + (p / rho**2)[None] + shock
    push = fluid.mass * fluid.gradient_scale * term * fluid.kernels.slope(r) * other
    drag = fluid.mass * fluid.viscosity * fluid.laplacian_scale
    drag = drag / (rho[:, None] * rho[None]) * fluid.kernels.laplacian(r) * other
    pressure_part = np.einsum("ij,ijk->ik", push, direction)
    viscous_part = np.einsum("ij,ijk->ik", drag, motion)
    return pressure_part + viscous_part + gravity


def steps(
    fluid: TwinFluid,
    position: FloatArray,
    velocity: FloatArray,
    gravity: FloatArray,
    *,
    dt: float,
    drag_rate: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """One step: v* = v + dt a; v = v*/(1 + dt rate); x = x + dt v (PHYSICS 4.1b)."""
    a = accelerations(fluid, position, velocity, gravity)
    velocity = (velocity + dt * a) / (1.0 + dt * drag_rate)
    return position + dt * velocity, velocity
