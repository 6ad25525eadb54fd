"""The material point method in plain NumPy, dense grid, float64: the slow twin of native/injury.

It follows PHYSICS.md 1.4 line by line and shares no code with the native solver: eigenvalues come
from LAPACK, node sums from np.add.at, logarithms and exponentials from NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.injury.materials import COLUMNS

OFFSETS = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(27, 3)


@dataclass
class TwinState:
    """Particles: x, v (n, 3); c (n, 3, 3); b elastic left Cauchy-Green; alpha, opening (n,)."""

    x: np.ndarray
    v: np.ndarray
    c: np.ndarray
    b: np.ndarray
    alpha: np.ndarray
    opening: np.ndarray


def at_rest(x: np.ndarray, v: np.ndarray) -> TwinState:
    """Unstrained particles."""
    n = len(x)
    eye = np.tile(np.eye(3), (n, 1, 1))
    return TwinState(x.copy(), v.copy(), np.zeros((n, 3, 3)), eye, np.zeros(n), np.zeros(n))


def columns(table: np.ndarray, material: np.ndarray) -> dict[str, np.ndarray]:
    """The material constants of every particle by name."""
    return {name: table[material, i] for i, name in enumerate(COLUMNS)}


def principal_kirchhoff(m: dict[str, np.ndarray], strain: np.ndarray) -> np.ndarray:
    """2 mu dev(eps) - J p for principal Hencky strains (n, 3)."""
    trace = strain.sum(axis=1)
    n = np.where(m["tait_exponent"] > 0, m["tait_exponent"], 1.0)
    tait = -np.exp(trace) * m["bulk_modulus"] / n * (np.exp(-n * trace) - 1.0)
    volumetric = np.where(m["tait_exponent"] > 0, tait, m["bulk_modulus"] * trace)
    deviator = strain - trace[:, None] / 3.0
    return 2.0 * m["shear_modulus"][:, None] * deviator + volumetric[:, None]


def damage(m: dict[str, np.ndarray], alpha: np.ndarray) -> np.ndarray:
    """Linear from damage_start to damage_end."""
    return np.clip((alpha - m["damage_start"]) / (m["damage_end"] - m["damage_start"]), 0.0, 1.0)


def return_map(
    m: dict[str, np.ndarray],
    strain: np.ndarray,
    alpha: np.ndarray,
    opening: np.ndarray,
    rate: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closing of voids, shear yield, pressure cut-off, Rankine; loops over particles."""
    strain, alpha, opening = strain.copy(), alpha.copy(), opening.copy()
    for p in range(len(strain)):
        k = {name: float(value[p]) for name, value in m.items()}
        lone = {name: value[p : p + 1] for name, value in m.items()}
        closed = min(max(-strain[p].sum(), 0.0), opening[p])
        opening[p] -= closed
        strain[p] += closed / 3.0
        # shear yield
        mean = strain[p].mean()
        deviator = strain[p] - mean
        q = np.sqrt(1.5) * 2.0 * k["shear_modulus"] * np.linalg.norm(deviator)
        factor = 1.0
        if k["rate_reference"] > 0:
            factor += (rate[p] / k["rate_reference"]) ** k["rate_exponent"]
        full = k["yield_stress"] * factor
        cohesion = full * (1.0 - damage(lone, alpha[p : p + 1])[0])
        friction = -k["friction"] * k["bulk_modulus"] * 3.0 * mean
        if q > max(cohesion + friction, 0.0):
            span = k["damage_end"] - k["damage_start"]
            softening = k["damage_start"] <= alpha[p] < k["damage_end"]
            slope = min(full / span, 0.95 * 3.0 * k["shear_modulus"]) if softening else 0.0
            guess = (q - max(cohesion + friction, 0.0)) / (3.0 * k["shear_modulus"] - slope)
            left = max(max(cohesion - slope * guess, 0.0) + friction, 0.0)
            strain[p] = mean + deviator * left / q
            alpha[p] += (q - left) / (3.0 * k["shear_modulus"])
        # pressure cut-off
        sound = 1.0 - damage(lone, alpha[p : p + 1])[0]
        excess = max(strain[p].sum() - sound * k["pressure_cutoff"] / k["bulk_modulus"], 0.0)
        strain[p] -= excess / 3.0
        opening[p] += excess
        alpha[p] += k["opening_damage"] * excess
        # Rankine: try one, two, three active principal stresses, largest first
        strength = k["tensile_strength"] * (1.0 - damage(lone, alpha[p : p + 1])[0])
        mu, lam = k["shear_modulus"], k["bulk_modulus"] - 2.0 * k["shear_modulus"] / 3.0
        over = 2.0 * mu * strain[p] + lam * strain[p].sum() - strength
        order = np.argsort(-over)
        if over[order[0]] > 0:
            for count in (1, 2, 3):
                active = order[:count]
                total = over[active].sum() / (count * lam + 2.0 * mu)
                rest = order[count:]
                if len(rest) == 0 or np.all(over[rest] - lam * total <= 0):
                    break
            strain[p, active] -= (over[active] - lam * total) / (2.0 * mu)
            opening[p] += total
            alpha[p] += k["opening_damage"] * total
    return strain, alpha, opening


def spectral(b: np.ndarray, law) -> np.ndarray:
    """V law(lambda) V^T of symmetric matrices (n, 3, 3)."""
    value, vector = np.linalg.eigh(b)
    return np.einsum("nia,na,nja->nij", vector, law(value), vector)


def stencil(x: np.ndarray, dx: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Node numbers (n, 27, 3), weights (n, 27), node - particle (n, 27, 3)."""
    base = np.floor(x / dx - 0.5)
    f = x / dx - base
    w = np.stack([0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2], axis=1)
    node = base[:, None, :] + OFFSETS[None]
    weight = np.prod([w[:, OFFSETS[:, a], a] for a in range(3)], axis=0)
    return node.astype(int), weight, node * dx - x[:, None, :]


def step(
    s: TwinState,
    *,
    volume: np.ndarray,
    m: dict[str, np.ndarray],
    dx: float,
    dt: float,
    gravity: np.ndarray,
    stress_sign: float = 1.0,
) -> TwinState:
    """One step; `stress_sign` = -1 makes it wrong on purpose."""
    mass = m["density"] * volume
    node, weight, arm = stencil(s.x, dx)
    lowest = node.reshape(-1, 3).min(axis=0)
    shape = tuple(node.reshape(-1, 3).max(axis=0) - lowest + 1)
    flat = np.ravel_multi_index(tuple((node - lowest).transpose(2, 0, 1)), shape)
    tau = spectral(s.b, lambda v: principal_kirchhoff(m, 0.5 * np.log(v)))
    affine = mass[:, None, None] * s.c
    affine = affine - stress_sign * dt * 4.0 / dx**2 * volume[:, None, None] * tau
    grid_mass, grid_v = np.zeros(np.prod(shape)), np.zeros((np.prod(shape), 3))
    np.add.at(grid_mass, flat, weight * mass[:, None])
    momentum = mass[:, None, None] * s.v[:, None] + np.einsum("nij,nkj->nki", affine, arm)
    np.add.at(grid_v, flat, weight[..., None] * momentum)
    loaded = grid_mass > 0
    grid_v[loaded] = grid_v[loaded] / grid_mass[loaded, None] + dt * gravity
    local = grid_v[flat]
    v = np.einsum("nk,nki->ni", weight, local)
    c = 4.0 / dx**2 * np.einsum("nk,nki,nkj->nij", weight, local, arm)
    f = np.eye(3) + dt * c
    b = np.einsum("nij,njk,nlk->nil", f, s.b, f)
    symmetric = 0.5 * (c + c.transpose(0, 2, 1))
    deviator = symmetric - np.trace(symmetric, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    rate = np.sqrt(2.0 / 3.0 * np.einsum("nij,nij->n", deviator, deviator))
    value, vector = np.linalg.eigh(b)
    strain, alpha, opening = return_map(m, 0.5 * np.log(value), s.alpha, s.opening, rate)
    b = np.einsum("nia,na,nja->nij", vector, np.exp(2.0 * strain), vector)
    return TwinState(s.x + dt * v, v, c, b, alpha, opening)
