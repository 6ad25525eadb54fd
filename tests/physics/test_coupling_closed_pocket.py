"""A severed artery bleeding into a closed box of real blood particles (PHYSICS.md S23)."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.circulation import CirculationParameters, build_tree
from vulnus.circulation.aortic_signal import signal_of
from vulnus.core.handoff import ParticleFrame
from vulnus.coupling import CouplingParameters, bleed_out
from vulnus.hemorrhage import BloodVolumes, FluidParameters, FluidScene

pytestmark = pytest.mark.physics

SPACING = 2e-3
SIDE = 1e-2
SAMPLE_INTERVAL = 2.5e-3  # this box is so stiff that 10 ms of bleeding raise it by 190 mmHg
BEATS = 4


class BoxOfBlood:
    """A fluid in a closed box as the coupling sees it."""

    def __init__(self) -> None:
        scene = FluidScene(FluidParameters(particle_spacing=SPACING, sound_speed=20.0), threads=1)
        scene.add_container((0.0, 0.0, 0.0), (SIDE, SIDE, SIDE), open_faces=())
        scene.set_source((SIDE / 2, SIDE / 2, SIDE / 2))
        self.fluid = scene.build()

    time = property(lambda self: self.fluid.time)
    steps = property(lambda self: self.fluid.steps)
    particle_count = property(lambda self: self.fluid.particle_count)
    barrier_crossings = property(lambda self: self.fluid.barrier_crossings)

    @property
    def pressure_injury(self) -> float:
        native = self.fluid.native
        return native.pressure_time / native.sampled_time if native.sampled_time > 0.0 else 0.0

    def advance(self, until, flow_rate, on_chunk=None):
        self.fluid.native.pressure_time = self.fluid.native.sampled_time = 0.0
        self.fluid.advance(until, flow_rate, on_chunk)

    def volumes(self) -> BloodVolumes:
        native, particle = self.fluid.native, self.fluid.particle_volume
        return BloodVolumes(
            injected=native.injected,
            in_limb=self.fluid.particle_count * particle,
            out_of_limb=0.0,
            removed=native.removed * particle,
            pending=native.pending,
        )

    def frame(self, index):
        return ParticleFrame(index, self.time, np.zeros((1, 3), np.float32), {})

    def state(self):
        return self.fluid.state()

    def restore(self, state):
        self.fluid.restore(state)


@pytest.fixture(scope="module")
def port():
    tree = build_tree(CirculationParameters())
    return tree.injury_port(*tree.locate("anterior_tibial", 0.5))


@pytest.fixture(scope="module")
def outcome(port):
    chosen = CouplingParameters(
        duration=BEATS * port.period, frame_interval=1.0, sample_interval=SAMPLE_INTERVAL
    )
    return bleed_out(port, BoxOfBlood(), chosen)


def test_bleeding_stops_when_the_pocket_is_full(outcome, port):
    first, *later = outcome.mean_flow_per_beat
    assert first * outcome.period > 0.9 * SIDE**3  # the first beat fills the box
    # 10 % of free bleeding: the exchange between beats overshoots in so stiff a box, ever less
    assert np.max(np.abs(later)) < 0.1 * port.bleed(0.0).mean_flow


def test_pocket_keeps_to_the_arterys_pressure(outcome, port):
    """Around the mean pressure of the closed artery, never beyond twice its systolic.

    One particle more or less in this box is 0.8 % of density, 25 mmHg at this speed of sound, and
    one interval between two looks at the pressure 47 mmHg.
    """
    arterial = signal_of(port.open_pressure)
    filled = outcome.waveforms.time > port.period
    pressure = outcome.waveforms.pressure_injury[filled]
    assert np.max(pressure) < 2.0 * np.max(arterial)
    assert 0.3 < np.mean(pressure) / np.mean(arterial) < 2.0


def test_ledger_closes(outcome):
    # 0.5 % is what the project promises; the particles' account is exact to round-off
    assert outcome.ledger.volume_error_fraction < 1e-6
    assert outcome.barrier_crossings == 0


class Memory:
    """Keeps every checkpoint; a save raises an interrupt after so many."""

    def __init__(self, stop_after: int) -> None:
        self.data, self.left = None, stop_after

    def load(self):
        return self.data

    def due(self):
        return True

    def save(self, data):
        self.data = {
            name: value.copy() if isinstance(value, np.ndarray) else value
            for name, value in data.items()
        }
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt


def test_interrupted_run_of_real_blood_goes_on_with_the_same_bits(port):
    chosen = CouplingParameters(duration=0.32, frame_interval=0.1, sample_interval=0.02)
    straight = bleed_out(port, BoxOfBlood(), chosen)
    memory = Memory(stop_after=9)
    with pytest.raises(KeyboardInterrupt):
        bleed_out(port, BoxOfBlood(), chosen, checkpoint=memory)
    resumed = bleed_out(port, BoxOfBlood(), chosen, checkpoint=memory)
    assert np.array_equal(resumed.waveforms.pressure_injury, straight.waveforms.pressure_injury)
    assert np.array_equal(resumed.waveforms.flow_injury, straight.waveforms.flow_injury)
    assert np.array_equal(resumed.ledger.pending, straight.ledger.pending)
    assert resumed.steps == straight.steps
