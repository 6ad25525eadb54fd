"""One material point without a grid: the native return map on matrices (n, 3, 3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.injury import _native
from vulnus.injury.materials import Material, material_table

DIAGONAL = [0, 1, 2, 0, 1, 2]
BESIDE = [0, 1, 2, 1, 2, 0]


def voigt(matrix: np.ndarray) -> np.ndarray:
    """xx yy zz xy yz zx of symmetric matrices."""
    return matrix[..., DIAGONAL, BESIDE]


def tensor(v: np.ndarray) -> np.ndarray:
    """Symmetric matrices of xx yy zz xy yz zx."""
    return v[..., [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(*v.shape[:-1], 3, 3)


def spectral(matrix: np.ndarray, law) -> np.ndarray:
    """V law(values) V^T."""
    value, vector = np.linalg.eigh(matrix)
    return np.einsum("...ia,...a,...ja->...ij", vector, law(value), vector)


@dataclass(frozen=True)
class Point:
    """After the return: elastic Hencky strain, history and Kirchhoff stress of n points."""

    hencky: np.ndarray
    alpha: np.ndarray
    opening: np.ndarray
    damage: np.ndarray
    network: np.ndarray
    tau: np.ndarray
    wave_speed: np.ndarray


def update(
    material: Material | np.ndarray,
    hencky: np.ndarray,
    *,
    network: np.ndarray | None = None,
    alpha: np.ndarray | float = 0.0,
    opening: np.ndarray | float = 0.0,
    damage: np.ndarray | float = 0.0,
    rate: float = 0.0,
    precision: str = "64",
    dx: float = 0.002,
) -> Point:
    """Return trial Hencky strains (n, 3, 3) with total left Cauchy-Green tensors `network`.

    `network` is that of the Hencky strain where it is not given. Damage here is the damage after.
    """
    table = material_table([material], dx) if isinstance(material, Material) else material
    hencky = np.asarray(hencky, np.float64).reshape(-1, 3, 3)
    state = np.zeros((len(hencky), 15))
    state[:, :6] = voigt(spectral(hencky, lambda e: np.expm1(2.0 * e)))
    state[:, 6], state[:, 7], state[:, 8] = alpha, opening, damage
    total = state[:, :6] if network is None else voigt(np.reshape(network, (-1, 3, 3)) - np.eye(3))
    state[:, 9:] = total
    run = _native.return_map64 if precision == "64" else _native.return_map32
    n = len(hencky)
    out = run(table, np.zeros(n, np.uint8), state, np.full(n, float(rate)))
    return Point(
        hencky=spectral(tensor(out[:, :6]), lambda v: 0.5 * np.log1p(v)),
        alpha=out[:, 6],
        opening=out[:, 7],
        damage=out[:, 8],
        network=tensor(out[:, 9:15]) + np.eye(3),
        tau=tensor(out[:, 15:21]),
        wave_speed=np.sqrt(out[:, 21]),
    )
