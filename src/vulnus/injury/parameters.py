"""What the injury stage needs to know, frozen and in SI; angles in radians, patient frame LPS."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from vulnus.core.arrays import Vector3
from vulnus.core.constants import STANDARD_GRAVITY

ProjectileShape = Literal["sphere", "cylinder", "ogive", "stl", "blade"]
"""Form of a projectile; its long axis lies along the flight, nose ahead, unless it is turned."""

InjuryMode = Literal["full", "paper"]
"""full: the passage, then the collapse of the temporary cavity; paper: the passage alone, and what
is there at its end is the wound (Chong 2017, section 2.2)."""

WoundState = Literal["temporary", "permanent"]
"""temporary: when the cavity is largest; permanent: at the end, when it has collapsed."""

Motion = Literal["kinematic", "dynamic"]
"""kinematic: keeps its velocity, as in the paper; dynamic: six degrees of freedom, needs a mass."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProjectileParameters:
    """What flies: by default a rigid sphere that keeps its velocity, as in the paper (2.2).

    Which sizes count depends on `shape`: sphere: diameter; cylinder: diameter, length; ogive:
    diameter, length, nose_length; stl: mesh; blade: length, width, thickness, tip_length, depth.
    The values are complete: a scenario resolves the names of the table of projectiles before.
    """

    name: str | None = None
    """Name in the table of projectiles that the values come from, for reports; None: none."""
    shape: ProjectileShape = "sphere"
    """Form of the body; the paper's is a sphere."""
    motion: Motion = "kinematic"
    """Whether the tissue slows and turns the body; the paper's keeps its velocity."""
    diameter: float = 0.009
    """Diameter [m]; chosen: a 9 mm ball, the calibre of PHYSICS.md section 2's sphere tests. For
    stl and blade: of the track that is looked for, at most the body's width."""
    length: float = 0.0
    """Length [m] of cylinder, ogive and blade; 0 for the others."""
    nose_length: float = 0.0
    """Length [m] of the ogive's nose, up to the whole length."""
    width: float = 0.0
    """Width [m] of the blade, from back to edge."""
    thickness: float = 0.0
    """Thickness [m] of the blade."""
    tip_length: float = 0.0
    """Length [m] over which the blade narrows to its tip."""
    mass: float | None = None
    """Mass [kg]; a dynamic body needs it."""
    mesh: Path | None = None
    """STL file of a closed surface, nose towards +x."""
    mesh_scale: float = 1e-3
    """Length [m] of the file's unit; millimetres by default."""
    speed: float = 350.0
    """Speed [m/s]; chosen: that of a 9x19 mm bullet, 350-380 m/s (PHYSICS.md section 2)."""
    yaw: float = 0.0
    """Angle [rad] of the long axis beside the flight at first contact, nose to the right of a
    flier who stands upright (proximal is up)."""
    pitch: float = 0.0
    """Angle [rad] of the long axis above the flight at first contact, nose up."""
    roll: float = 0.0
    """Turn [rad] about the long axis, clockwise seen from behind: how a blade is held (0: its
    width lies along the limb)."""
    spin: float = 0.0
    """Angular velocity [rad/s] about the long axis, clockwise from behind (right-hand twist)."""
    depth: float = 0.0
    """How deep [m] behind the skin a blade's tip is thrust before it is drawn back as fast."""
    friction: float = 0.1
    """Coulomb coefficient between projectile and tissue; chosen: a wet, smooth metal surface."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AimParameters:
    """The straight line of flight: one point on it and one direction.

    The point is `target`, else the point of `artery` at `fraction`; the direction is `direction`,
    else it comes from `azimuth` and `elevation`.
    """

    artery: str | None = "anterior_tibial"
    """Name of the artery whose centre-line the line crosses, or None where `target` is given."""
    fraction: float = 0.45
    """Where on the artery: fraction of its length from its proximal end, 0-1."""
    target: Vector3 | None = None
    """A point [m] on the line of flight; takes precedence over `artery`."""
    azimuth: float = 0.0
    """Side that the projectile comes from, seen from above [rad]: 0 anterior, pi/2 patient's left
    (+x), pi posterior, 3 pi/2 right."""
    elevation: float = 0.0
    """Height that the projectile comes from [rad]: > 0 from above; -pi/2 to pi/2."""
    direction: Vector3 | None = None
    """Direction of flight, of any length; takes precedence over the two angles."""
    start: Vector3 | None = None
    """Where the projectile's middle is before the shot [m], outside the limb, as the muzzle of a
    contact shot; None: far enough away. It replaces the direction: it flies from here through the
    point."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ShotParameters:
    """One projectile and its own line of flight."""

    projectile: ProjectileParameters = field(default_factory=ProjectileParameters)
    aim: AimParameters = field(default_factory=AimParameters)


@dataclass(frozen=True, slots=True, kw_only=True)
class InjuryParameters:
    """One shot: the projectile, its line, and the resolution of the material point method."""

    projectile: ProjectileParameters = field(default_factory=ProjectileParameters)
    aim: AimParameters = field(default_factory=AimParameters)
    other_shots: tuple[ShotParameters, ...] = ()
    """Further projectiles that touch the limb at the same time as the first, each on its line."""
    grid_spacing: float = 0.003
    """Edge of a grid cell [m]; chosen: a third of a 9 mm ball (PHYSICS.md 1.6 asks for a fifth
    where the tract's shape matters, 0.002)."""
    mode: InjuryMode = "full"
    """Whether the cavity's collapse is computed too, or the passage alone, as in the paper."""
    duration: float | None = None
    """Time from first contact to the end of the run [s]; None: 1 ms in the mode "paper" (section
    2.2), else until the temporary cavity has collapsed, between 10 and 20 ms (PHYSICS heading 3;
    `run_end`), and never before a blade is out again."""
    phase_one: float = 1e-3
    """Least time [s] with the tissues' true moduli; they stay as long as a projectile in the limb
    is faster than a tenth of `relaxation_sound_speed`, and as long as a blade is thrust. Chosen: as
    long as the paper's whole run."""
    relaxation_sound_speed: float = 300.0
    """Speed of sound [m/s] that every tissue is slowed to after that, by a lower bulk modulus, so
    that the collapse takes larger steps; chosen: ten times the speed of a collapsing cavity's wall.
    0: the true moduli to the end."""
    bleeds_from: WoundState = "permanent"
    """Which state of the wound bleeds and is drawn."""
    courant_number: float = 0.4
    """Part of a cell that sound and matter may cross in one step; 0.3-0.4 (PHYSICS.md 1.5)."""
    window_length: float | None = 0.12
    """Length of the limb that is simulated, along its long axis around the track [m]; None: the
    whole limb. Tissue outside stays where it is. Chosen: 0.12, PHYSICS.md 1.6."""
    held_length: float = 0.006
    """Length [m] at both ends of the limb where the tissue is held fast; chosen: two cells."""
    absorbing_length: float = 0.02
    """Length [m] inside an end where the window cuts the limb over which motion is damped as the
    rest of the limb would, which gives way and carries waves off; 0: such an end is held like the
    limb's own. Chosen: a sixth of the window."""
    gravity: Vector3 = (0.0, 0.0, -STANDARD_GRAVITY)
    """Acceleration of gravity [m/s²]; a standing patient by default."""
    frame_interval: float = 5e-5
    """Time between exported frames during `phase_one` [s]; chosen: 20 frames in 1 ms."""
    relaxation_frame_interval: float = 5e-4
    """Time between exported frames after that [s]; chosen: at most 38 frames until 20 ms."""
    bone_modulus_scale: float = 0.3
    """Factor on the elastic moduli of cortical bone, 1 for the true stiffness; 0.3 (17 to 5 GPa)
    halves the number of steps and changes little in soft tissue (PHYSICS.md 1.5)."""
    artery_failure_stretch: float = 1.6
    """Stretch of the centre-line at which the wall is torn through; chosen: between 1.4 and 1.8 of
    circumferential and axial strips at high rate (Mohan & Melbin 1983, from memory)."""
    damage_threshold: float = 0.9
    """Damage from which tissue counts as destroyed; 0.9 (PHYSICS.md 1.4)."""
    laceration_threshold: float = 0.1
    """Destroyed share of an artery's wall, around its circumference, from which it is lacerated;
    from `damage_threshold` it is transected. Chosen: a tear of a tenth is seen at surgery."""
    threads: int = 0
    """Number of threads, 0 for all; the result does not depend on it."""
    seed: int = 0
    """Seed of the run; the stage itself draws no random numbers."""
