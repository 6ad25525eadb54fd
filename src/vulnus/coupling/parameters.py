"""How long the limb bleeds and how the tree and the blood particles talk to each other."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CouplingParameters:
    """The bleeding run.

    `duration` [s] of bleeding to simulate (5 s, chosen: six beats show the filling and the jet).
    `frame_interval` [s] between two saved particle frames (0.04 s, chosen: 25 a second, a film's
    rate); frames lie at exact multiples of it, frame 0 at time 0.
    `sample_interval` [s] between two rows of waveforms and ledger, and two looks at the pressure
    around the wound (5 ms, chosen: 20 in the systolic upstroke of about 0.1 s).
    `relaxation` ω in (0, 1] of the exchanged pressure, p ← p + ω (p_measured - p): 1 is the paper's
    plain exchange, smaller values damp the beat-to-beat oscillation of a closed pocket
    (0.5: PHYSICS.md 4.5 gives 0.3-0.5).
    `initial_pressure` [Pa] around the wound in the first beat (0: open to the air).
    """

    duration: float = 5.0
    frame_interval: float = 0.04
    sample_interval: float = 0.005
    relaxation: float = 0.5
    initial_pressure: float = 0.0
