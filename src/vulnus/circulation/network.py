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
from typing import Literal, NamedTuple

import numpy as np

from vulnus.core.arrays import FloatArray

from .arrays import ComplexArray
from .levels import TreeLevels
from .segments import SegmentTable
from .womersley import HARMONICS_AT_A_TIME, LineConstants


@dataclass(frozen=True, slots=True, eq=False)
class SteadyState:
    """The mean of every segment, (n,) each.

    `pressure_in`, `pressure_out` [Pa] at both ends, `flow` [m³/s]; Norton loads Q = Y P + J as
    seen distally: `conductance_in`, `source_in` at the inlet, `conductance_load`, `source_load`
    behind the outlet, in [m³/(Pa s)] and [m³/s].
    """

    pressure_in: FloatArray
    pressure_out: FloatArray
    flow: FloatArray
    conductance_in: FloatArray
    conductance_load: FloatArray
    source_in: FloatArray
    source_load: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class NetworkState:
    """The solved tree: `steady` for the mean, (n, H) arrays for the harmonics 1..H.

    `root` (H + 1,) is the spectrum of the pressure at the root [Pa]; `pressure_in`,
    `pressure_out` [Pa] at both ends of a segment; `admittance_in`, `admittance_load`
    [m³/(Pa s)] looking distally at the inlet and behind the outlet.
    """

    steady: SteadyState
    root: ComplexArray
    pressure_in: ComplexArray
    pressure_out: ComplexArray
    admittance_in: ComplexArray
    admittance_load: ComplexArray


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
    table: SegmentTable, transmission: ComplexArray, root: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Pressure at the inlet and the outlet of every segment, (n, H), from the root's (H,)."""
    pressure_in = np.empty_like(transmission)
    pressure_out = np.empty_like(transmission)
    pressure_in[0] = root
    levels = table.levels
    for k in range(len(levels.bounds) - 1):
        level = slice(levels.bounds[k], levels.bounds[k + 1])
        if k > 0:
            pressure_in[level] = pressure_out[table.parent_row[level]]
        np.multiply(pressure_in[level], transmission[level], out=pressure_out[level])
    return pressure_in, pressure_out


class HarmonicWaves(NamedTuple):
    """The harmonics 1..H of `NetworkState`, (n, H) each, and the pressure at the root, (H,)."""

    root: ComplexArray
    pressure_in: ComplexArray
    pressure_out: ComplexArray
    admittance_in: ComplexArray
    admittance_load: ComplexArray


def harmonic_waves(
    table: SegmentTable,
    lines: LineConstants,
    terminal: ComplexArray,
    drive: ComplexArray,
    *,
    source: Literal["pressure", "flow"],
) -> HarmonicWaves:
    """All waves of the tree driven by the harmonics (H,) of the pressure or flow at its root.

    Goes through the harmonics in blocks that stay in the processor's cache.
    """
    blocks = []
    for start in range(0, len(drive), HARMONICS_AT_A_TIME):
        block = slice(start, start + HARMONICS_AT_A_TIME)
        waves = WaveFactors.over(lines.propagation[:, block], table.length)
        inlet, load, transmission = harmonic_admittances(
            table.levels, waves, lines.impedance[:, block], terminal[:, block]
        )
        root = drive[block] / inlet[0] if source == "flow" else drive[block]
        pressure_in, pressure_out = harmonic_pressures(table, transmission, root)
        blocks.append(HarmonicWaves(root, pressure_in, pressure_out, inlet, load))
    if len(blocks) == 1:
        return blocks[0]
    return HarmonicWaves(*(np.concatenate(part, axis=-1) for part in zip(*blocks, strict=True)))


class SteadyLoads(NamedTuple):
    """Norton loads of the mean as in `SteadyState`, (n,) each."""

    conductance_in: FloatArray
    conductance_load: FloatArray
    source_in: FloatArray
    source_load: FloatArray


def steady_loads(
    table: SegmentTable, resistance: FloatArray, venous_pressure: float
) -> SteadyLoads:
    """Sweep of the mean from the ends to the root; `resistance` is each line's (Poiseuille)."""
    load = (1.0 / table.terminal_resistance).tolist()
    source = [-venous_pressure * conductance for conductance in load]
    inlet, source_in = [0.0] * len(load), [0.0] * len(load)
    parents, resistances = table.parent_row.tolist(), resistance.tolist()
    for row in range(len(load) - 1, -1, -1):
        share = 1.0 / (1.0 + resistances[row] * load[row])
        inlet[row] = load[row] * share
        source_in[row] = source[row] * share
        if (parent := parents[row]) >= 0:
            load[parent] += inlet[row]
            source[parent] += source_in[row]
    return SteadyLoads(np.array(inlet), np.array(load), np.array(source_in), np.array(source))


def steady_state(
    table: SegmentTable, resistance: FloatArray, loads: SteadyLoads, root_pressure: float
) -> SteadyState:
    """Mean pressures and flows from the root's mean pressure [Pa] outwards."""
    pressure_in = [root_pressure] * len(resistance)
    pressure_out = [0.0] * len(resistance)
    flow = [0.0] * len(resistance)
    conductance, source = loads.conductance_in.tolist(), loads.source_in.tolist()
    drop = resistance.tolist()
    for row, parent in enumerate(table.parent_row.tolist()):
        if parent >= 0:
            pressure_in[row] = pressure_out[parent]
        flow[row] = conductance[row] * pressure_in[row] + source[row]
        pressure_out[row] = pressure_in[row] - drop[row] * flow[row]
    return SteadyState(
        pressure_in=np.array(pressure_in),
        pressure_out=np.array(pressure_out),
        flow=np.array(flow),
        conductance_in=loads.conductance_in,
        conductance_load=loads.conductance_load,
        source_in=loads.source_in,
        source_load=loads.source_load,
    )
