"""The arterial tree at work: pressure and flow anywhere, and the port where an artery is cut."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import CirculationError
from vulnus.core.handoff import VesselInjury

from .aortic_signal import AorticSignal, check_parameters, scaled_signal, signal_of, spectrum_of
from .arrays import ComplexArray
from .cycle_summary import CycleSummary, summarise_cycle
from .injury_branch import InjuryPort
from .limb_arteries import locate_in_chain
from .network import (
    NetworkState,
    harmonic_waves,
    steady_loads,
    steady_state,
)
from .parameters import CirculationParameters
from .segments import SegmentTable, stergiopulos91
from .source_path import SourceEquation, through_junction, through_line
from .terminals import terminal_admittance
from .womersley import LineConstants, line_constants

TREES = {"stergiopulos91": stergiopulos91}
"""Tables that `CirculationParameters.tree` may name."""

FIBULAR = "fibular"


def build_tree(
    parameters: CirculationParameters, side: str = "left", *, severed: str | None = None
) -> ArterialTree:
    """The arterial tree that the parameters describe, for a limb of the given side.

    `severed` names the artery that is going to be cut; "fibular", which the 91 segments lack,
    adds that branch. Raises `CirculationError` for an unknown tree or an unphysical parameter.
    """
    if parameters.tree not in TREES:
        raise CirculationError(
            "circulation.tree",
            f'is "{parameters.tree}", known are {", ".join(sorted(TREES))}',
            "Name one of them",
        )
    check_parameters(parameters)
    table = TREES[parameters.tree](peroneal=severed == FIBULAR)
    return ArterialTree(table, scaled_signal(parameters), parameters, side=side)


def open_injury_port(
    parameters: CirculationParameters, injury: VesselInjury, side: str = "left"
) -> InjuryPort:
    """The port of the tree at a vessel's injury: the right tree, the place, the lumen.

    The lumen is the limb's own where it is known (> 0), else the table's.
    """
    tree = build_tree(parameters, side, severed=injury.artery)
    segment, position = tree.locate(injury.artery, injury.arc_fraction, injury.arc_length)
    radius = injury.lumen_radius if injury.lumen_radius > 0.0 else None
    return tree.injury_port(segment, position, lumen_radius=radius)


class ArterialTree:
    """A tree of Womersley lines driven at its root, periodic in the heartbeat.

    Nothing is computed before it is asked for, and then once. Segments are named by their id in
    the table; `table.id_of["left anterior tibial 2"]` finds one by its readable name.
    """

    def __init__(
        self,
        table: SegmentTable,
        signal: AorticSignal,
        parameters: CirculationParameters,
        *,
        side: str = "left",
    ) -> None:
        if side not in ("left", "right"):
            raise CirculationError("side", f'is "{side}"', 'Use "left" or "right"')
        self.table = table
        self.signal = signal
        self.parameters = parameters
        self.side = side
        self.period = signal.period

    @cached_property
    def time(self) -> FloatArray:
        """Times of the signals' samples [s], (2 H,), even over one period from 0."""
        samples = 2 * self.parameters.harmonics
        return np.asarray(np.arange(samples) * (self.period / samples), dtype=float)

    @cached_property
    def angular_frequency(self) -> FloatArray:
        """ω of the harmonics 1..H [rad/s], (H,)."""
        number = np.arange(1, self.parameters.harmonics + 1, dtype=float)
        return np.asarray(number * (2.0 * np.pi / self.period))

    @cached_property
    def lines(self) -> LineConstants:
        """Propagation and impedance of every segment at every harmonic."""
        return line_constants(self.table, self.angular_frequency, self.parameters)

    def solve(self) -> NetworkState:
        """The whole uninjured tree: pressures and admittances of all segments and harmonics."""
        return self._state

    @cached_property
    def _state(self) -> NetworkState:
        parameters, resistance = self.parameters, self.lines.resistance
        drive = self._drive()
        terminal = terminal_admittance(self.table, self.angular_frequency, parameters)
        waves = harmonic_waves(
            self.table, self.lines, terminal, drive[1:], source=parameters.source
        )
        loads = steady_loads(self.table, resistance, parameters.venous_pressure)
        mean = float(drive[0].real)
        if parameters.source == "flow":
            mean = (mean - float(loads.source_in[0])) / float(loads.conductance_in[0])
        return NetworkState(
            steady=steady_state(self.table, resistance, loads, mean),
            root=np.append(mean, waves.root),
            pressure_in=waves.pressure_in,
            pressure_out=waves.pressure_out,
            admittance_in=waves.admittance_in,
            admittance_load=waves.admittance_load,
        )

    def _drive(self) -> ComplexArray:
        """Spectrum c_0..c_H of what the heart imposes at the root, a pressure or a flow."""
        flows = self.parameters.source == "flow"
        signal = self.signal.flow if flows else self.signal.pressure
        return spectrum_of(signal, self.parameters.harmonics)

    def pressure_spectrum(self, segment: int, position: float) -> ComplexArray:
        """Fourier coefficients c_0..c_H of the pressure [Pa] at `position` [m] of a segment."""
        return self._spectra(segment, position)[0]

    def flow_spectrum(self, segment: int, position: float) -> ComplexArray:
        """Fourier coefficients c_0..c_H of the flow [m³/s] at `position` [m] of a segment."""
        return self._spectra(segment, position)[1]

    def pressure(self, segment: int, position: float) -> FloatArray:
        """Pressure [Pa] over the cycle, (2 H,), at `position` [m] from a segment's inlet."""
        return signal_of(self.pressure_spectrum(segment, position))

    def flow(self, segment: int, position: float) -> FloatArray:
        """Flow [m³/s] over the cycle, (2 H,), at `position` [m]; positive away from the heart."""
        return signal_of(self.flow_spectrum(segment, position))

    def pressure_summary(self, segment: int, position: float) -> CycleSummary:
        """Mean, systolic and diastolic pressure [Pa] at `position` [m] of a segment."""
        return summarise_cycle(self.time, self.pressure(segment, position))

    def pressure_aorta(self) -> FloatArray:
        """Pressure [Pa] at the entrance of the aorta over the cycle, (2 H,)."""
        return signal_of(self._state.root)

    def locate(
        self, artery: str, arc_fraction: float | None = None, arc_length: float | None = None
    ) -> tuple[int, float]:
        """Segment id and position [m] in it of a place on a limb artery of the tree's side.

        `artery` is popliteal, anterior_tibial, posterior_tibial or fibular. The place is a
        fraction of the artery's length, so that short and long legs agree; the length [m] from
        its proximal end counts where no fraction is given.
        """
        return locate_in_chain(self.table, self.side, artery, arc_fraction, arc_length)

    def injury_port(
        self,
        segment: int,
        position: float,
        *,
        lumen_radius: float | None = None,
        exit_loss_coefficient: float | None = None,
    ) -> InjuryPort:
        """The tree as seen from a cut at `position` [m] of a segment.

        `lumen_radius` [m] of the stump, the table's where None; `exit_loss_coefficient` K, the
        parameters' where None. In the mode "transection" the tree behind the cut is taken away.
        """
        open_pressure, impedance = self._thevenin(segment, position)
        shunt = self.parameters.injury_mode == "shunt"
        loss = self.parameters.exit_loss_coefficient
        if exit_loss_coefficient is not None:
            loss = exit_loss_coefficient
        if lumen_radius is None:
            lumen_radius = float(self.table.radius[self.table.row(segment)])
        return InjuryPort.between(
            period=self.period,
            pressure_aorta=self.pressure_aorta(),
            open_pressure=open_pressure,
            impedance=impedance,
            lumen_radius=lumen_radius,
            density=self.parameters.density,
            exit_loss_coefficient=loss,
            branch_resistance=self.parameters.shunt_resistance if shunt else 0.0,
        )

    def _spectra(self, segment: int, position: float) -> tuple[ComplexArray, ComplexArray]:
        row, position = self._place(segment, position)
        state, rest = self._state, self.table.length[row] - position
        gamma, impedance = self.lines.propagation[row], self.lines.impedance[row]
        whole = np.exp(-2.0 * gamma * self.table.length[row])
        twice = np.exp(-2.0 * gamma * rest)
        u = impedance * state.admittance_load[row]
        wave = state.pressure_in[row] * np.exp(-gamma * position)
        wave /= (1.0 + whole) + u * (1.0 - whole)
        pressure = wave * ((1.0 + twice) + u * (1.0 - twice))
        flow = wave * ((1.0 - twice) + u * (1.0 + twice)) / impedance
        mean_flow = self.mean_flow(segment)
        drop = self.lines.resistance[row] * position / self.table.length[row] * mean_flow
        mean_pressure = state.steady.pressure_in[row] - drop
        return np.append(mean_pressure, pressure), np.append(mean_flow, flow)

    def mean_flow(self, segment: int) -> float:
        """Mean flow through a segment [m³/s], positive away from the heart."""
        return float(self._state.steady.flow[self.table.row(segment)])

    def _place(self, segment: int, position: float) -> tuple[int, float]:
        row = self.table.row(segment)
        length = float(self.table.length[row])
        if not -1e-9 <= position <= length + 1e-9:
            raise CirculationError(
                f"position in {self.table.names[row]}",
                f"is {position:g} m, must lie in [0, {length:g}] m",
                "Use ArterialTree.locate",
            )
        return row, min(max(position, 0.0), length)

    def _thevenin(self, segment: int, position: float) -> tuple[ComplexArray, ComplexArray]:
        """Open pressure and internal impedance per harmonic 0..H at a place of the tree."""
        row, position = self._place(segment, position)
        equation = self._source_equation(row, position)
        if self.parameters.injury_mode == "shunt":
            admittance, source = self._distal_load(row, position)
            equation = through_junction(equation, admittance, source)
        return equation.thevenin(self.table.names[row])

    def _source_equation(self, row: int, position: float) -> SourceEquation:
        """What the heart's side of the tree allows at `position` [m] of a row's segment."""
        drive = self._drive()
        given, free = np.ones_like(drive), np.zeros_like(drive)
        if self.parameters.source == "pressure":
            equation = SourceEquation(a=given, b=free, c=drive)
        else:
            equation = SourceEquation(a=free, b=given, c=drive)
        path = self._path_from_root(row)
        for above, below in pairwise(path):
            equation = self._along(equation, above, float(self.table.length[above]))
            for sibling in np.flatnonzero(self.table.parent_row == above):
                if sibling != below:
                    steady = self._state.steady
                    conductance = steady.conductance_in[sibling]
                    admittance = np.append(conductance, self._state.admittance_in[sibling])
                    source = float(steady.source_in[sibling])
                    equation = through_junction(equation, admittance, source)
        return self._along(equation, row, position)

    def _path_from_root(self, row: int) -> list[int]:
        path = [row]
        while (parent := int(self.table.parent_row[path[-1]])) >= 0:
            path.append(parent)
        return path[::-1]

    def _along(self, equation: SourceEquation, row: int, length: float) -> SourceEquation:
        return through_line(
            equation,
            propagation=self.lines.propagation[row],
            impedance=self.lines.impedance[row],
            resistance=float(self.lines.resistance[row] * length / self.table.length[row]),
            length=length,
        )

    def _distal_load(self, row: int, position: float) -> tuple[ComplexArray, float]:
        """Admittance (H + 1,) and Norton source [m³/s] of the tree behind a place."""
        state, rest = self._state, self.table.length[row] - position
        impedance = self.lines.impedance[row]
        twice = np.exp(-2.0 * self.lines.propagation[row] * rest)
        u = impedance * state.admittance_load[row]
        wave = (1.0 - twice + u * (1.0 + twice)) / (1.0 + twice + u * (1.0 - twice))
        conductance = state.steady.conductance_load[row]
        resistance = self.lines.resistance[row] * rest / self.table.length[row]
        share = 1.0 / (1.0 + resistance * conductance)
        admittance = np.append(conductance * share, wave / impedance)
        return admittance, float(state.steady.source_load[row] * share)
