"""The benchmark's scene in the `quadrants` package (PyPI; a fork of Taichi), as its users write it.

The same scheme as the native solver: MLS-MPM with APIC, quadratic B-splines, Hencky strains from
the singular value decomposition of F, Tait's law, rate-dependent von Mises and Drucker-Prager
return, softening, tension cut-offs, a rigid sphere; float32, the same particles, nodes and steps.

Tuned for processors: particles in the order of the grid's blocks, nodes with mass and momentum side
by side, loops over the 27 nodes unrolled, no strain rebuilt where nothing flows.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import quadrants as qd

from vulnus.injury.materials import COLUMNS

LAYOUTS = ("dense", "pointer")
"""How the grid's nodes are stored: over the whole box, or in blocks of 4³ made where needed."""

BLOCK = 4  # nodes along a block's edge, as in the native grid
STEEPEST_SOFTENING = 0.95  # plasticity.hpp
DENSITY, BULK, SHEAR, VOLUME, GROWTH, AVERAGED, YIELD, HARDENING = (
    COLUMNS.index(name)
    for name in (
        *("density", "bulk_modulus", "shear_modulus", "volume_exponent", "volume_growth"),
        *("volume_averaging", "yield_stress", "hardening"),
    )
)
FRICTION, RATE, EXPONENT, START, SLOPE, CUTOFF, STRENGTH, TORN = (
    COLUMNS.index(name)
    for name in (
        *("friction", "rate_reference", "rate_exponent", "damage_start", "damage_slope"),
        *("pressure_cutoff", "tensile_strength", "opening_damage"),
    )
)
NETWORK, STIFFENING, BREAK, BREAK_SLOPE = (
    COLUMNS.index(name)
    for name in ("network_modulus", "network_stiffening", "break_start", "break_slope")
)


def start(threads: int, precision: str = "float32") -> None:
    """Start the package anew with so many threads (0: all processors)."""
    options = {"cpu_max_num_threads": threads} if threads else {}
    real = {"float32": qd.f32, "float64": qd.f64}[precision]
    qd.init(arch=qd.cpu, default_fp=real, default_cpu_block_dim=256,
            log_level=qd.ERROR, **options)  # fmt: skip


@qd.func
def diagonal(d):
    return qd.Matrix([[d[0], 0.0, 0.0], [0.0, d[1], 0.0], [0.0, 0.0, d[2]]])


@qd.data_oriented
class QuadrantsMpm:
    """The particles and nodes of one scene; `step(dt)` advances it."""

    def __init__(
        self,
        position: np.ndarray,
        *,
        velocity: np.ndarray,
        volume: float,
        material: np.ndarray,
        table: np.ndarray,
        grid_spacing: float,
        gravity: tuple[float, float, float],
        ball_centre: tuple[float, float, float],
        ball_velocity: tuple[float, float, float],
        ball_radius: float,
        layout: str = "dense",
    ) -> None:
        order = block_order(position, grid_spacing)
        self.source = order
        self.real = qd.lang.impl.get_runtime().default_fp
        self.count, self.layout = len(position), layout
        self.dx, self.volume, self.radius = grid_spacing, volume, ball_radius
        self.gravity, self.push = qd.Vector(gravity), qd.Vector(ball_velocity)
        lower = np.floor(position.min(axis=0) / grid_spacing).astype(int) - 2 * BLOCK
        upper = np.ceil(position.max(axis=0) / grid_spacing).astype(int) + 2 * BLOCK
        self.lower = qd.Vector([int(v) // BLOCK * BLOCK for v in lower])
        blocks = [int(n) for n in upper // BLOCK - lower // BLOCK + 1]
        self._place_fields(blocks)
        self.table = qd.field(self.real, shape=table.shape)
        self.ball = qd.Vector.field(3, self.real, shape=())
        self.ball[None] = ball_centre
        kind = np.float32 if self.real == qd.f32 else np.float64
        self.table.from_numpy(table.astype(kind))
        self.x.from_numpy(position[order].astype(kind))
        self.v.from_numpy(velocity[order].astype(kind))
        self.material.from_numpy(material[order].astype(np.int32))
        self._unstrain()
        self._regroup()

    def _place_fields(self, blocks: list[int]) -> None:
        vector, matrix = qd.Vector.field, qd.Matrix.field
        self.x, self.v = vector(3, self.real), vector(3, self.real)
        self.C, self.F, self.b = (matrix(3, 3, self.real) for _ in range(3))
        self.alpha, self.opening, self.damage = (qd.field(self.real) for _ in range(3))
        self.material, self.cell = qd.field(qd.i32), vector(3, qd.i32)
        tensors = (self.x, self.v, self.C, self.F, self.b)
        for field in (*tensors, self.alpha, self.opening, self.damage, self.material, self.cell):
            qd.root.dense(qd.i, self.count).place(field)
        self.mass, self.momentum = qd.field(self.real), vector(3, self.real)
        self.averaged_volume, self.averaged_rate = qd.field(self.real), qd.field(self.real)
        self.nodes = self._grid(blocks, self.mass, self.momentum)
        self.cells = self._grid(blocks, self.averaged_volume, self.averaged_rate)

    def _grid(self, blocks: list[int], *fields: qd.Field) -> qd.SNode:
        if self.layout == "dense":
            grid = qd.root
            grid.dense(qd.ijk, [BLOCK * n for n in blocks]).place(*fields)
        else:
            grid = qd.root.pointer(qd.ijk, blocks)
            grid.dense(qd.ijk, BLOCK).place(*fields)
        return grid

    @qd.kernel
    def _unstrain(self):
        for p in self.x:
            self.F[p] = qd.Matrix.identity(self.real, 3)
            self.b[p] = qd.Matrix.identity(self.real, 3)

    def step(self, dt: float, *, regroup: bool = False) -> None:
        """One step of `dt` [s]; `regroup`: the first after the solver would sort its particles."""
        self._clear(self.nodes, self._clear_nodes)
        self._scatter(dt)
        if regroup:
            self._regroup()
        self._update_nodes(dt)
        self._clear(self.cells, self._clear_cells)
        self._gather(dt)
        self._move_ball(dt)

    def finish(self, dt: float) -> None:
        """Return the strains to the yield surface with the newest velocity gradient."""
        self._deform_all(dt)

    def _clear(self, grid: qd.SNode, kernel: Callable[[], None]) -> None:
        if self.layout == "dense":
            kernel()
        else:
            grid.deactivate_all()

    @qd.kernel
    def _regroup(self):
        """Find the cell of every particle; the volume's rate is averaged over those of one cell."""
        for p in self.x:
            self.cell[p] = qd.floor(self.x[p] / self.dx - 0.5).cast(qd.i32) - self.lower

    @qd.kernel
    def _clear_nodes(self):
        for node in qd.grouped(self.mass):
            self.mass[node] = 0.0
            self.momentum[node] = qd.Vector([0.0, 0.0, 0.0])

    @qd.kernel
    def _clear_cells(self):
        for cell in qd.grouped(self.averaged_volume):
            self.averaged_volume[cell] = 0.0
            self.averaged_rate[cell] = 0.0

    @qd.func
    def softening(self, m, alpha):
        """Damage from the plastic strain."""
        return qd.min(qd.max((alpha - self.table[m, START]) * self.table[m, SLOPE], 0.0), 1.0)

    @qd.func
    def shear_return(self, m, rate, eps, alpha, damage):
        """Radial return to q <= Y(alpha, rate) + M p; the strain, alpha and whether it flows."""
        mean = eps.sum() / 3.0
        dev = eps - mean
        three_mu = 3.0 * self.table[m, SHEAR]
        q = three_mu * qd.sqrt(2.0 / 3.0 * dev.norm_sqr())
        frictional = -3.0 * self.table[m, FRICTION] * self.table[m, BULK] * mean
        factor = 1.0
        if self.table[m, RATE] > 0.0:
            factor += qd.pow(qd.max(rate / self.table[m, RATE], 1e-12), self.table[m, EXPONENT])
        full = (self.table[m, YIELD] + self.table[m, HARDENING] * alpha) * factor
        softened = self.softening(m, alpha)
        sound = 1.0 - qd.max(damage, softened)
        limit = qd.max(full * sound + frictional, 0.0)
        flows = q > limit
        if three_mu <= 0.0:
            eps = mean
        elif flows:
            slope = -self.table[m, HARDENING] * factor * sound
            if alpha >= self.table[m, START] and damage <= softened < 1.0:
                slope += qd.min(full * self.table[m, SLOPE], STEEPEST_SOFTENING * three_mu)
            less = qd.max(full * sound - slope * (q - limit) / (three_mu - slope), 0.0)
            left = qd.max(less + frictional, 0.0)
            eps = mean + left / q * dev
            alpha += (q - left) / three_mu
        return eps, alpha, flows or three_mu <= 0.0

    @qd.func
    def tension_return(self, m, eps, alpha, opening, damage):
        """Cavitation cut-off of the pressure, then Rankine's of the principal stress."""
        sound = 1.0 - qd.max(damage, self.softening(m, alpha))
        bulk, two_mu = self.table[m, BULK], 2.0 * self.table[m, SHEAR]
        excess = qd.max(eps.sum() - sound * self.table[m, CUTOFF] / bulk, 0.0)
        eps -= excess / 3.0
        opening += excess
        alpha += self.table[m, TORN] * excess
        lam = bulk - two_mu / 3.0
        sound = 1.0 - qd.max(damage, self.softening(m, alpha))
        over = two_mu * eps + lam * eps.sum() - sound * self.table[m, STRENGTH]
        cracks = over.max() > 0.0 and two_mu > 0.0
        if cracks:
            crack = over.max() / (lam + two_mu)
            crack = qd.max(crack, (over.sum() - over.min()) / (2.0 * lam + two_mu))
            crack = qd.max(crack, over.sum() / (3.0 * lam + two_mu))
            eps -= qd.max(over - lam * crack, 0.0) / two_mu
            opening += crack
            alpha += self.table[m, TORN] * crack
        return eps, alpha, opening, cracks or excess > 0.0

    @qd.func
    def network(self, m, p, log_jacobian, step, damage):
        """Kirchhoff stress without (1 - D) of the network at p, and its damage."""
        tau = qd.Matrix.zero(self.real, 3, 3)
        mu = self.table[m, NETWORK]
        if mu > 0.0 and damage < 1.0:
            b = step @ self.b[p] @ step.transpose()
            self.b[p] = b
            scaled = qd.exp(-2.0 / 3.0 * log_jacobian) * b
            excess = qd.max(scaled.trace() - 3.0, 0.0)
            e, start = qd.sqrt(excess / 3.0), self.table[m, BREAK]
            if e > start:
                line = qd.max(1.0 - (e - start) * self.table[m, BREAK_SLOPE], 0.0)
                damage = qd.max(damage, 1.0 - line * start / e)
            stiffened = self.table[m, STIFFENING] * qd.min(excess, 3.0 * start * start)
            if stiffened > 0.0:
                mu *= qd.exp(stiffened)
            tau = mu * (scaled - scaled.trace() / 3.0 * qd.Matrix.identity(self.real, 3))
        return tau, damage

    @qd.func
    def deform(self, p, dt):
        """Advance F and b, return F to all limits; Kirchhoff stress."""
        m, C = self.material[p], self.C[p]
        if self.table[m, AVERAGED] > 0.0 and self.averaged_volume[self.cell[p]] > 0.0:
            mean = self.averaged_rate[self.cell[p]] / self.averaged_volume[self.cell[p]]
            C += (mean - C.trace()) / 3.0 * qd.Matrix.identity(self.real, 3)
        step = qd.Matrix.identity(self.real, 3) + dt * C
        F = step @ self.F[p]
        U, sigma, V = qd.svd(F)
        eps = qd.log(qd.Vector([sigma[0, 0], sigma[1, 1], sigma[2, 2]]))
        alpha, opening = self.alpha[p], self.opening[p]
        opened = opening > 0.0
        tau, damage = self.network(m, p, eps.sum() + opening, step, self.damage[p])
        closed = qd.min(qd.max(-eps.sum(), 0.0), opening)
        opening -= closed
        eps += closed / 3.0
        d = 0.5 * (C + C.transpose())
        d -= d.trace() / 3.0 * qd.Matrix.identity(self.real, 3)
        rate = qd.sqrt(2.0 / 3.0 * d.norm_sqr())
        eps, alpha, flows = self.shear_return(m, rate, eps, alpha, damage)
        eps, alpha, opening, opens = self.tension_return(m, eps, alpha, opening, damage)
        if flows or opens or opened:
            F = U @ diagonal(qd.exp(eps)) @ V.transpose()
            self.alpha[p], self.opening[p] = alpha, opening
        damage = qd.max(damage, self.softening(m, alpha))
        self.F[p], self.damage[p] = F, damage
        trace, n = eps.sum(), self.table[m, VOLUME]
        volumetric = self.table[m, BULK] * trace
        if n > 0.0:
            grown = qd.exp(self.table[m, GROWTH] * trace)
            volumetric = grown * self.table[m, BULK] / n * (1.0 - qd.exp(-n * trace))
        principal = 2.0 * self.table[m, SHEAR] * (eps - trace / 3.0) + volumetric
        return U @ diagonal(principal) @ U.transpose() + (1.0 - damage) * tau

    @qd.kernel
    def _deform_all(self, dt: float):
        for p in self.x:
            self.deform(p, dt)

    @qd.func
    def stencil(self, p):
        """First node, distance from it in cells, and the weights of the three nodes an axis."""
        cell = self.x[p] / self.dx
        base = qd.floor(cell - 0.5).cast(qd.i32)
        fx = cell - base.cast(self.real)
        w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1.0) ** 2, 0.5 * (fx - 0.5) ** 2]
        return base - self.lower, fx, w[0], w[1], w[2]

    @qd.kernel
    def _move_ball(self, dt: float):
        self.ball[None] += dt * self.push

    @qd.kernel
    def _scatter(self, dt: float):
        for p in self.x:
            tau = self.deform(p, dt)
            mass = self.table[self.material[p], DENSITY] * self.volume
            affine = mass * self.C[p] - 4.0 * dt * self.volume / self.dx**2 * tau
            base, fx, w0, w1, w2 = self.stencil(p)
            w = qd.static([w0, w1, w2])
            for i, j, k in qd.static(qd.ndrange(3, 3, 3)):
                apart = (qd.Vector([float(i), float(j), float(k)]) - fx) * self.dx
                weight = w[i][0] * w[j][1] * w[k][2]
                node = base + qd.Vector([i, j, k])
                self.momentum[node] += weight * (mass * self.v[p] + affine @ apart)
                self.mass[node] += weight * mass

    @qd.kernel
    def _update_nodes(self, dt: float):
        for node in qd.grouped(self.mass):
            m = self.mass[node]
            if m > 0.0:
                v = self.momentum[node] / m + dt * self.gravity
                offset = (node + self.lower).cast(self.real) * self.dx - self.ball[None]
                distance = offset.norm()
                if distance < self.radius:
                    approach = (v - self.push).dot(offset) / distance
                    if approach < 0.0:
                        v -= approach * offset / distance
                self.momentum[node] = v

    @qd.kernel
    def _gather(self, dt: float):
        for p in self.x:
            base, fx, w0, w1, w2 = self.stencil(p)
            w = qd.static([w0, w1, w2])
            v = qd.Vector([0.0, 0.0, 0.0])
            C = qd.Matrix.zero(self.real, 3, 3)
            for i, j, k in qd.static(qd.ndrange(3, 3, 3)):
                apart = qd.Vector([float(i), float(j), float(k)]) - fx
                weighted = w[i][0] * w[j][1] * w[k][2] * self.momentum[base + qd.Vector([i, j, k])]
                v += weighted
                C += weighted.outer_product(apart)
            self.v[p] = v
            C *= 4.0 / self.dx
            self.C[p] = C
            if self.table[self.material[p], AVERAGED] > 0.0:
                self.averaged_volume[self.cell[p]] += self.volume
                self.averaged_rate[self.cell[p]] += self.volume * C.trace()
            self.x[p] += dt * v


def block_order(position: np.ndarray, grid_spacing: float) -> np.ndarray:
    """The order of blocks of 4³ cells, and of cells in a block, as the native solver sorts."""
    cell = np.floor(position / grid_spacing - 0.5).astype(np.int64)
    cell -= cell.min(axis=0)
    block, inside = cell // BLOCK, cell % BLOCK
    return np.lexsort((*inside.T[::-1], *block.T[::-1]))
