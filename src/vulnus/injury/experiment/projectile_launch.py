"""A shot of an experiment before its tissue is known: who flies where, and how it lies."""

from __future__ import annotations

from dataclasses import dataclass, replace

from vulnus.core.arrays import Vector3

from ..bodies.flight import start_before_contact
from ..bodies.projectiles import Projectile
from ..bodies.rigid_body import Motion, RigidBody
from ..particle_reading import JoinedParticles

GAP_CELLS = 1.0
"""Cells between a projectile and the first tissue at time 0 [chosen: beyond what contact feels]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Launch:
    """What `Experiment.add_projectile` was told; SI, angles in radians."""

    projectile: Projectile
    speed: float
    direction: Vector3
    target: Vector3 | None
    centre: Vector3 | None
    motion: Motion
    yaw: float
    pitch: float
    roll: float
    spin: float
    friction: float

    def rigid_body(self, name: str, particles: JoinedParticles, grid_spacing: float) -> RigidBody:
        """The body at its place at time 0."""
        if self.centre is not None:
            return self._at(self.centre)
        assert self.target is not None  # add_projectile asks for one of the two
        anywhere = self._at(self.target)
        start = start_before_contact(
            anywhere, particles, target=self.target, gap=GAP_CELLS * grid_spacing, name=name
        )
        return replace(anywhere, centre=start)

    def _at(self, centre: Vector3) -> RigidBody:
        return self.projectile.body(
            centre,
            self.direction,
            speed=self.speed,
            yaw=self.yaw,
            pitch=self.pitch,
            roll=self.roll,
            spin=self.spin,
            motion=self.motion,
            friction=self.friction,
        )
