"""What the coupling needs of the blood's solver; `hemorrhage.BleedingSolver` is the real one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

from vulnus.circulation import BeatSignals
from vulnus.core.arrays import FloatArray
from vulnus.core.checkpoint import CheckpointValue
from vulnus.core.handoff import ParticleFrame


class BloodVolumes(Protocol):
    """Where the blood is [m³]: injected = in_limb + out_of_limb + removed + pending."""

    @property
    def injected(self) -> float:
        """Integral of the flow that the solver was given."""

    @property
    def in_limb(self) -> float:
        """Inside the limb's skin."""

    @property
    def out_of_limb(self) -> float:
        """Outside the limb."""

    @property
    def removed(self) -> float:
        """Taken out of the simulation."""

    @property
    def pending(self) -> float:
        """Not yet a whole particle."""


class BloodSolver(Protocol):
    """Blood particles that take in a given flow and report the pressure around the wound."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    @property
    def steps(self) -> int:
        """Steps taken so far."""

    @property
    def particle_count(self) -> int:
        """Blood particles at present."""

    @property
    def barrier_crossings(self) -> int:
        """How often a particle was found half its spacing deep in a barrier, and put back."""

    @property
    def pressure_injury(self) -> float:
        """Pressure around the wound [Pa], the mean over the last call of `advance`."""

    def advance(
        self,
        until: float,
        flow_rate: tuple[FloatArray, FloatArray],
        on_chunk: Callable[[float], None] | None = None,
    ) -> None:
        """Go to the time `until` [s] exactly, taking in a flow linear between (times, values).

        `on_chunk` is told the simulated time at least once a second of wall time.
        """

    def volumes(self) -> BloodVolumes:
        """Where the blood is now."""

    def frame(self, index: int) -> ParticleFrame:
        """The particles now, as frame `index`."""

    def state(self) -> Mapping[str, CheckpointValue]:
        """What cannot be derived, for a checkpoint."""

    def restore(self, state: Mapping[str, CheckpointValue]) -> None:
        """Go back to a state, to the bit."""


class TreePort(Protocol):
    """The tree seen from the cut; `circulation.InjuryPort` is the real one."""

    @property
    def period(self) -> float:
        """Length of a heartbeat [s]."""

    @property
    def resistance(self) -> float:
        """Resistance of tree and branch to the mean flow [Pa s/m³], > 0."""

    def bleed(self, pressure_injury: FloatArray | float) -> BeatSignals:
        """One heartbeat that bleeds against a pressure [Pa]."""
