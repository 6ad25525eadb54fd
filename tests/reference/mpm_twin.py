"""The material point method in plain NumPy, dense grid, float64: the slow twin of native/injury.

It follows PHYSICS.md 1.4 line by line and shares no code with the native solver: eigenvalues come
from LAPACK, node sums from np.add.at, logarithms and exponentials from NumPy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from vulnus.injury.materials import COLUMNS

OFFSETS = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(27, 3)


@dataclass
class TwinState:
    """Particles: x, v (n, 3); c (n, 3, 3); alpha, opening, damage (n,).

    b (n, 3, 3) is the elastic, `network` the total left Cauchy-Green tensor.
    """

    x: np.ndarray
    v: np.ndarray
    c: np.ndarray
    b: np.ndarray
    alpha: np.ndarray
    opening: np.ndarray
    damage: np.ndarray
    network: np.ndarray


def at_rest(x: np.ndarray, v: np.ndarray) -> TwinState:
    """Unstrained particles."""
    n = len(x)
    eye = np.tile(np.eye(3), (n, 1, 1))
    zero = np.zeros(n)
    return TwinState(
        x.copy(), v.copy(), np.zeros((n, 3, 3)), eye, zero, zero.copy(), zero.copy(), eye.copy()
    )


def columns(table: np.ndarray, material: np.ndarray) -> dict[str, np.ndarray]:
    """The material constants of every particle by name."""
    values = {name: table[material, i] for i, name in enumerate(COLUMNS)}
    return {**values, "material": material}


def principal_kirchhoff(m: dict[str, np.ndarray], strain: np.ndarray) -> np.ndarray:
    """2 mu dev(eps) - J p for principal Hencky strains (n, 3)."""
    trace = strain.sum(axis=1)
    n = np.where(m["volume_exponent"] > 0, m["volume_exponent"], 1.0)
    a = m["volume_growth"]
    curved = m["bulk_modulus"] / n * (np.exp(a * trace) - np.exp((a - n) * trace))
    volumetric = np.where(m["volume_exponent"] > 0, curved, m["bulk_modulus"] * trace)
    deviator = strain - trace[:, None] / 3.0
    return 2.0 * m["shear_modulus"][:, None] * deviator + volumetric[:, None]


def strain_at(k: dict[str, float], tension: float) -> float:
    """Volumetric strain where the pressure part of the Kirchhoff stress is `tension`."""
    straight, n = tension / k["bulk_modulus"], k["volume_exponent"]
    if n == 0.0 or not 0.0 < straight < 1.0:
        return straight
    a = k["volume_growth"]
    return brentq(
        lambda t: (np.exp(a * t) - np.exp((a - n) * t)) / n - straight, 0.0, 5.0, xtol=1e-17
    )


def softening(m: dict[str, np.ndarray], alpha: np.ndarray) -> np.ndarray:
    """Linear from damage_start to 1."""
    return np.clip((alpha - m["damage_start"]) * m["damage_slope"], 0.0, 1.0)


def invariant(b: np.ndarray) -> np.ndarray:
    """First invariant (n,) of the isochoric part of b."""
    return np.trace(b, axis1=1, axis2=2) * np.linalg.det(b) ** (-1.0 / 3.0)


def network_damage(m: dict[str, np.ndarray], b: np.ndarray) -> np.ndarray:
    """The equivalent stress 3 mu e (1 - D) falls linearly from break_start on."""
    e = np.sqrt(np.maximum(invariant(b) - 3.0, 0.0) / 3.0)
    start = m["break_start"]
    line = np.clip(1.0 - (e - start) * m["break_slope"], 0.0, 1.0)
    return np.where(e > start, 1.0 - line * start / np.where(e > start, e, 1.0), 0.0)


def network_kirchhoff(m: dict[str, np.ndarray], b: np.ndarray, damage: np.ndarray) -> np.ndarray:
    """mu exp(beta (I - 3)) dev(J^(-2/3) b) (1 - D), no stiffer than at break_start."""
    most = 3.0 * m["break_start"] ** 2
    exponent = m["network_stiffening"] * np.minimum(invariant(b) - 3.0, most)
    modulus = m["network_modulus"] * np.exp(exponent) * (1.0 - damage)
    isochoric = b * np.linalg.det(b)[:, None, None] ** (-1.0 / 3.0)
    mean = np.trace(isochoric, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    return modulus[:, None, None] * (isochoric - mean)


def return_map(
    m: dict[str, np.ndarray],
    strain: np.ndarray,
    alpha: np.ndarray,
    opening: np.ndarray,
    *,
    damage: np.ndarray,
    rate: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closing of voids, shear yield, pressure cut-off, Rankine; loops over particles.

    `damage` is what the network and the past leave.
    """
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
        full = (k["yield_stress"] + k["hardening"] * alpha[p]) * factor
        softened = softening(lone, alpha[p : p + 1])[0]
        sound = 1.0 - max(softened, damage[p])
        cohesion = full * sound
        friction = -k["friction"] * k["bulk_modulus"] * 3.0 * mean
        if q > max(cohesion + friction, 0.0):
            falls = k["damage_start"] <= alpha[p] and damage[p] <= softened < 1.0
            steepest = 0.95 * 3.0 * k["shear_modulus"]
            slope = min(full * k["damage_slope"], steepest) if falls else 0.0
            slope -= k["hardening"] * factor * sound
            guess = (q - max(cohesion + friction, 0.0)) / (3.0 * k["shear_modulus"] - slope)
            left = max(max(cohesion - slope * guess, 0.0) + friction, 0.0)
            strain[p] = mean + deviator * left / q
            alpha[p] += (q - left) / (3.0 * k["shear_modulus"])
        if k["shear_modulus"] == 0.0:
            strain[p] = mean
        # pressure cut-off
        sound = 1.0 - max(softening(lone, alpha[p : p + 1])[0], damage[p])
        excess = max(strain[p].sum() - strain_at(k, sound * k["pressure_cutoff"]), 0.0)
        strain[p] -= excess / 3.0
        opening[p] += excess
        alpha[p] += k["opening_damage"] * excess
        # Rankine: try one, two, three active principal stresses, largest first
        sound = 1.0 - max(softening(lone, alpha[p : p + 1])[0], damage[p])
        strength = k["tensile_strength"] * sound
        mu, lam = k["shear_modulus"], k["bulk_modulus"] - 2.0 * k["shear_modulus"] / 3.0
        over = 2.0 * mu * strain[p] + lam * strain[p].sum() - strength
        order = np.argsort(-over)
        if over[order[0]] > 0 and mu > 0:
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


def averaged_rate(
    c: np.ndarray, x: np.ndarray, dx: float, weight: np.ndarray, material: np.ndarray
) -> np.ndarray:
    """`c` with its trace averaged over points of one material and base node, by `weight` (n,)."""
    base = np.column_stack([np.floor(x / dx - 0.5).astype(int), material])
    _, group = np.unique(base, axis=0, return_inverse=True)
    group = group.ravel()
    trace = np.trace(c, axis1=1, axis2=2)
    volume = np.bincount(group, weight)
    mean = np.bincount(group, weight * trace) / np.where(volume > 0, volume, 1.0)
    change = np.where(weight > 0, mean[group] - trace, 0.0)
    return c + change[:, None, None] / 3.0 * np.eye(3)


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
    tau = tau + network_kirchhoff(m, s.network, s.damage)
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
    f = np.eye(3) + dt * averaged_rate(c, s.x, dx, volume * m["volume_averaging"], m["material"])
    b = np.einsum("nij,njk,nlk->nil", f, s.b, f)
    network = np.einsum("nij,njk,nlk->nil", f, s.network, f)
    damage = np.maximum(s.damage, network_damage(m, network))
    symmetric = 0.5 * (c + c.transpose(0, 2, 1))
    deviator = symmetric - np.trace(symmetric, axis1=1, axis2=2)[:, None, None] / 3.0 * np.eye(3)
    rate = np.sqrt(2.0 / 3.0 * np.einsum("nij,nij->n", deviator, deviator))
    value, vector = np.linalg.eigh(b)
    strain, alpha, opening = return_map(
        m, 0.5 * np.log(value), s.alpha, s.opening, damage=damage, rate=rate
    )
    b = np.einsum("nia,na,nja->nij", vector, np.exp(2.0 * strain), vector)
    damage = np.maximum(damage, softening(m, alpha))
    forgotten = (m["network_modulus"] == 0) | (damage >= 1.0)
    network = np.where(forgotten[:, None, None], np.eye(3), network)
    return TwinState(s.x + dt * v, v, c, b, alpha, opening, damage, network)
