"""The bleeding limb: blood from a severed artery into tissue, tract and air."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import AnyArray, FloatArray
from vulnus.core.handoff import ParticleFrame

from .fluid import Fluid
from .openings import Openings


@dataclass(frozen=True, slots=True)
class BloodVolumes:
    """Where the blood is [m³]: injected = in_limb + out_of_limb + removed + pending."""

    injected: float
    in_limb: float
    out_of_limb: float
    removed: float
    pending: float


class BleedingSolver(Fluid):
    """Blood in an injured limb; made by `prepare`."""

    name = "hemorrhage"
    openings = Openings(leaks=False, area=0.0)
    """Whether blood can get out of the limb through its skin, and through how large a hole."""

    @property
    def pressure_injury(self) -> float:
        """Pressure around the wound [Pa], the mean since the last `reset_pressure_injury`.

        `advance` resets it first; 0 where the surroundings are a free surface.
        """
        sampled = self.native.sampled_time
        return self.native.pressure_time / sampled if sampled > 0.0 else 0.0

    def reset_pressure_injury(self) -> None:
        """Start a new mean."""
        self.native.pressure_time = 0.0
        self.native.sampled_time = 0.0

    def advance(
        self,
        until: float,
        flow_rate: tuple[FloatArray, FloatArray] | None = None,
        on_chunk: Callable[[float], None] | None = None,
    ) -> None:
        """As `Fluid.advance`, with a new mean of the pressure around the wound."""
        self.reset_pressure_injury()
        super().advance(until, flow_rate, on_chunk)

    def volumes(self) -> BloodVolumes:
        """Where the blood is now."""
        inside = int(np.count_nonzero(self.native.in_limb))
        return BloodVolumes(
            injected=self.native.injected,
            in_limb=inside * self.particle_volume,
            out_of_limb=(self.particle_count - inside) * self.particle_volume,
            removed=self.native.removed * self.particle_volume,
            pending=self.native.pending,
        )

    def frame(self, index: int) -> ParticleFrame:
        """The particles now, as frame `index`, in order of their appearance."""
        order = np.argsort(self.id, kind="stable")
        data: dict[str, AnyArray] = {
            "velocity_m_per_s": self.velocity[order].astype(np.float32, copy=False),
            "pressure_pa": self.pressure[order].astype(np.float32, copy=False),
            "id": self.id[order],
            "in_limb": self.native.in_limb[order],
        }
        position = np.ascontiguousarray(self.position[order], dtype=np.float32)
        return ParticleFrame(index=index, time=self.time, position=position, point_data=data)
