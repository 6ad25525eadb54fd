"""Waves in a branching tree: one sweep up for admittances, one sweep down for pressures.

Each harmonic is a chain of two-ports. With e = e^(-γL), u = Zc Y2 and Y2 the admittance that a
segment's outlet sees,

    Y1    = (1 - e² + u (1 + e²)) / (1 + e² + u (1 - e²)) / Zc
    P2/P1 = 2 e / (1 + e² + u (1 - e²))

which is (C + D Y2)/(A + B Y2) and 1/(A + B Y2) divided by cosh's growing exponential, so that
long lossy lines neither overflow nor lose digits. Only the mean sees the venous pressure: there
a load is a Norton source, Q2 = Y2 P2 + J2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray, IndexArray

from .arrays import ComplexArray
from .segments import SegmentTable


@dataclass(frozen=True, slots=True, eq=False)
class TreeLevels:
    """The rows of a `SegmentTable` by distance from the root, for sweeps over whole levels.

    Level k holds the rows `bounds[k]:bounds[k + 1]`. `branching[k]` are those with children and
    `first_child[k]` where each one's children begin, counted from the next level's first row.
    """

    bounds: tuple[int, ...]
    branching: tuple[IndexArray, ...]
    first_child: tuple[IndexArray, ...]

    @classmethod
    def of(cls, table: SegmentTable) -> TreeLevels:
        """Levels of a table, whose rows are in breadth-first order."""
        levels = int(table.depth[-1]) + 1
        bounds = np.searchsorted(table.depth, np.arange(levels + 1))
        branching, first_child = [], []
        for k in range(levels - 1):
            parents, first = np.unique(
                table.parent_row[bounds[k + 1] : bounds[k + 2]], return_index=True
            )
            branching.append(parents.astype(np.int64))
            first_child.append(first.astype(np.int64))
        return cls(tuple(int(bound) for bound in bounds), tuple(branching), tuple(first_child))


@dataclass(frozen=True, slots=True, eq=False)
class NetworkState:
    """The solved tree, rows as in the table, columns harmonics 0..H (0 the mean).

    `pressure_in`, `pressure_out` [Pa] at both ends; `admittance_in`, `admittance_load`
    [m³/(Pa s)] looking distally at the inlet and behind the outlet; `source_in`, `source_load`
    (n,) [m³/s], the Norton sources J of the mean there.
    """

    pressure_in: ComplexArray
    pressure_out: ComplexArray
    admittance_in: ComplexArray
    admittance_load: ComplexArray
    source_in: FloatArray
    source_load: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class WaveFactors:
    """Per segment and harmonic 1..H: `once` = e^(-γL), `plus` = 1 + e², `minus` = 1 - e²."""

    once: ComplexArray
    plus: ComplexArray
    minus: ComplexArray

    @classmethod
    def over(cls, propagation: ComplexArray, length: FloatArray) -> WaveFactors:
        """Factors of lines with γ (n, H) [1/m] and lengths (n,) [m]."""
        once = np.exp(propagation * -length[:, np.newaxis])
        twice = once * once
        return cls(
            once=np.asarray(once, dtype=complex),
            plus=np.asarray(1.0 + twice, dtype=complex),
            minus=np.asarray(1.0 - twice, dtype=complex),
        )


def harmonic_admittances(
    levels: TreeLevels,
    waves: WaveFactors,
    impedance: ComplexArray,
    terminal: ComplexArray,
) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Input admittance, load admittance and transmission P2/P1 of every segment, (n, H) each.

    `impedance` is Zc, `terminal` the admittance of the bed behind each segment's end, 0 where it
    branches. Sweeps from the ends to the root.
    """
    load = terminal.copy()
    inlet = np.empty_like(load)
    transmission = np.empty_like(load)
    for k in range(len(levels.bounds) - 2, -1, -1):
        level = slice(levels.bounds[k], levels.bounds[k + 1])
        if k < len(levels.branching):
            below = inlet[levels.bounds[k + 1] : levels.bounds[k + 2]]
            load[levels.branching[k]] += np.add.reduceat(below, levels.first_child[k], axis=0)
        u = impedance[level] * load[level]
        denominator = 1.0 / (waves.plus[level] + u * waves.minus[level])
        transmission[level] = 2.0 * waves.once[level] * denominator
        inlet[level] = (waves.minus[level] + u * waves.plus[level]) * denominator / impedance[level]
    return inlet, load, transmission


def harmonic_pressures(
    table: SegmentTable, levels: TreeLevels, transmission: ComplexArray, root: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Pressure at the inlet and the outlet of every segment, (n, H), from the root's (H,)."""
    pressure_in = np.empty_like(transmission)
    pressure_out = np.empty_like(transmission)
    pressure_in[0] = root
    for k in range(len(levels.bounds) - 1):
        level = slice(levels.bounds[k], levels.bounds[k + 1])
        if k > 0:
            pressure_in[level] = pressure_out[table.parent_row[level]]
        np.multiply(pressure_in[level], transmission[level], out=pressure_out[level])
    return pressure_in, pressure_out


@dataclass(frozen=True, slots=True, eq=False)
class SteadyLoads:
    """Norton loads of the mean: conductances [m³/(Pa s)] and sources [m³/s], (n,) each."""

    conductance_in: FloatArray
    conductance_load: FloatArray
    source_in: FloatArray
    source_load: FloatArray


def steady_loads(
    table: SegmentTable, resistance: FloatArray, venous_pressure: float
) -> SteadyLoads:
    """Sweep of the mean from the ends to the root; `resistance` is each line's (Poiseuille)."""
    load = 1.0 / table.terminal_resistance
    source = -venous_pressure * load
    inlet = np.zeros_like(load)
    source_in = np.zeros_like(load)
    for row in range(len(load) - 1, -1, -1):
        share = 1.0 / (1.0 + resistance[row] * load[row])
        inlet[row] = load[row] * share
        source_in[row] = source[row] * share
        parent = table.parent_row[row]
        if parent >= 0:
            load[parent] += inlet[row]
            source[parent] += source_in[row]
    return SteadyLoads(inlet, load, source_in, source)


def steady_pressures(
    table: SegmentTable, resistance: FloatArray, loads: SteadyLoads, root_pressure: float
) -> tuple[FloatArray, FloatArray]:
    """Mean pressure at the inlet and the outlet of every segment, (n,), from the root's."""
    pressure_in = np.full(len(resistance), root_pressure)
    pressure_out = np.empty_like(pressure_in)
    for row, parent in enumerate(table.parent_row):
        if parent >= 0:
            pressure_in[row] = pressure_out[parent]
        flow = loads.conductance_in[row] * pressure_in[row] + loads.source_in[row]
        pressure_out[row] = pressure_in[row] - resistance[row] * flow
    return pressure_in, pressure_out
