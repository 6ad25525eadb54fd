"""Blood without particles: pockets and drains whose pressure is known by hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from vulnus.circulation import CirculationParameters, InjuryPort, build_tree
from vulnus.core.handoff import ParticleFrame
from vulnus.coupling.bleed import bleed_out


@dataclass
class Volumes:
    """The account of a fake solver."""

    injected: float
    in_limb: float
    out_of_limb: float
    removed: float
    pending: float


class Pocket:
    """A compliance C [m³/Pa] with a leak of resistance R [Pa s/m³] to the outside, in RK2 steps.

    Its arithmetic depends on where it stops, as a real solver's does, so that a resumed run only
    agrees to the bit if it stops at the same instants.
    """

    def __init__(self, compliance: float, leak_resistance: float = np.inf) -> None:
        self.compliance = compliance
        self.leak_resistance = leak_resistance
        self.time = 0.0
        self.steps = 0
        self.held = self.leaked = self.injected = 0.0
        self.pressure_injury = 0.0
        self.particle_count = 1
        self.barrier_crossings = 0
        self.fail_after: float | None = None
        self.stops: list[float] = []

    def advance(self, until, flow_rate, on_chunk=None):
        if self.fail_after is not None and until > self.fail_after:
            raise KeyboardInterrupt
        times, flows = flow_rate
        nodes = times[(times > self.time) & (times < until)]
        mean, begun = 0.0, self.time
        for stop in np.append(nodes, until):
            step = stop - self.time
            middle = 0.5 * (stop + self.time)
            volume = float(np.interp(middle, times, flows)) * step
            leak = self.held / self.compliance / self.leak_resistance * step
            mean += step * (self.held + 0.5 * (volume - leak)) / self.compliance
            self.held += volume - leak
            self.leaked += leak
            self.injected += volume
            self.time = float(stop)
            self.steps += 1
        self.pressure_injury = mean / (self.time - begun)
        self.stops.append(self.time)
        if on_chunk is not None:
            on_chunk(self.time)

    def volumes(self):
        return Volumes(self.injected, self.held, self.leaked, 0.0, 0.0)

    def frame(self, index):
        return ParticleFrame(index, self.time, np.zeros((1, 3), np.float32), {"held": self.held})

    def state(self):
        return {
            "time": self.time,
            "steps": self.steps,
            "volumes": np.array([self.held, self.leaked, self.injected, self.pressure_injury]),
        }

    def restore(self, state):
        self.time, self.steps = float(state["time"]), int(state["steps"])
        self.held, self.leaked, self.injected, self.pressure_injury = (
            float(value) for value in state["volumes"]
        )


class MemoryCheckpoint:
    """Keeps the newest checkpoint; due at every `every`-th question."""

    def __init__(self, every: int = 1) -> None:
        self.every, self.asked, self.data = every, 0, None

    def load(self):
        return self.data

    def save(self, data):
        self.data = {
            name: value.copy() if isinstance(value, np.ndarray) else value
            for name, value in data.items()
        }

    def due(self):
        self.asked += 1
        return self.asked % self.every == 0


@pytest.fixture
def pocket():
    return Pocket


@pytest.fixture
def memory_checkpoint():
    return MemoryCheckpoint


@pytest.fixture(scope="session")
def tibial_port() -> InjuryPort:
    tree = build_tree(CirculationParameters())
    return tree.injury_port(*tree.locate("anterior_tibial", 0.5))


@pytest.fixture
def run_bleeding(tibial_port):
    """Run a fake solver on the severed anterior tibial; also returns the frames."""

    def run(solver, parameters, **keywords):
        frames = []
        outcome = bleed_out(tibial_port, solver, parameters, on_frame=frames.append, **keywords)
        return outcome, frames

    return run
