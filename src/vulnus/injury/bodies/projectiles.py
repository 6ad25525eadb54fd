"""Common projectiles by name, each number with its source, and the rigid bodies they make.

Marks as in `materials`: [F] a source that was read, [M] from memory of the named literature, [D]
derived, [chosen] with the reason.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError
from vulnus.core.units import GRAM, MILLIMETRE

from ..checked_values import finite, not_negative, one_of, positive, vector
from ..parameters import ProjectileShape
from .attitude import UP, attitude
from .drawn_shapes import BladeShape, Cylinder, Ogive
from .rigid_body import BodyPath, Motion, RigidBody
from .rotations import Axis, axis_vector
from .shapes import Shape, Sphere

SHAPES = ("sphere", "cylinder", "ogive", "blade")
"""Shapes of the table."""
SIZES = ("diameter", "length", "nose_length", "width", "thickness", "tip_length", "depth", "twist")
FRICTION = 0.1  # chosen: a wet, smooth metal surface


@dataclass(frozen=True, slots=True, kw_only=True)
class Projectile:
    """A row of the table; SI. Sizes that a shape does not have are 0.

    `speed` [m/s] is the usual one, `speed_range` [m/s] what tests and weapons cover; `twist` [m]
    the length of barrel in which the bullet turns once, 0 without rifling.
    """

    name: str
    shape: ProjectileShape
    mass: float
    speed: float
    speed_range: tuple[float, float]
    source: str
    diameter: float = 0.0
    length: float = 0.0
    nose_length: float = 0.0
    width: float = 0.0
    thickness: float = 0.0
    tip_length: float = 0.0
    depth: float = 0.0
    twist: float = 0.0

    def __post_init__(self) -> None:
        """Refuse a shape that the table does not draw, and sizes that are none."""
        if isinstance(self.shape, str) and self.shape == "stl":
            raise ScenarioError(
                f"{self.name}: shape",
                "is 'stl', which the table does not draw",
                "Use add_rigid_body(RigidBody(shape=MeshShape.from_stl(path), ...)).",
            )
        one_of(f"{self.name}: shape", self.shape, SHAPES)
        for key in ("mass", "speed"):
            positive(f"{self.name}: {key}", getattr(self, key))
        for key in SIZES:
            not_negative(f"{self.name}: {key}", getattr(self, key))

    @property
    def spin(self) -> float:
        """Angular velocity [rad/s] about the long axis at the muzzle, at the usual speed."""
        return 2.0 * math.pi * self.speed / self.twist if self.twist else 0.0

    def solid(self) -> Shape:
        """Its shape; inertia is that of a homogeneous body with the projectile's mass."""
        radius = 0.5 * self.diameter
        if self.shape == "sphere":
            return Sphere(radius)
        if self.shape == "cylinder":
            return Cylinder(radius, self.length)
        if self.shape == "ogive":
            return Ogive(radius, self.length, self.nose_length)
        return BladeShape(self.length, self.width, self.thickness, self.tip_length)

    def body(
        self,
        position: Vector3,
        direction: Axis,
        *,
        speed: float | None = None,
        yaw: float = 0.0,
        pitch: float = 0.0,
        roll: float = 0.0,
        spin: float = 0.0,
        motion: Motion = "dynamic",
        friction: float = FRICTION,
        up: Vector3 = UP,
    ) -> RigidBody:
        """The rigid body with its centre of mass at `position` [m] that flies along `direction`.

        `yaw`, `pitch` and `roll` [rad] turn its nose to the right, up, and about the long axis, as
        `attitude` says; `spin` [rad/s] turns it on about that axis, clockwise from behind
        (`projectile(name).spin` is that of a rifled barrel). A blade cuts.
        """
        rotation = attitude(direction, yaw=yaw, pitch=pitch, roll=roll, up=up)
        way = axis_vector("direction", direction)
        pace = finite(f"{self.name} speed", self.speed if speed is None else speed)
        return RigidBody(
            shape=self.solid(),
            centre=position,
            velocity=_triple(way * pace),
            rotation=rotation,
            angular_velocity=_triple(finite("spin", spin) * rotation[:, 0]),
            motion=motion,
            mass=self.mass,
            friction=friction,
            cutting=self.shape == "blade",
            name=self.name,
        )

    def stab(
        self,
        entry: Vector3,
        direction: Axis,
        *,
        depth: float | None = None,
        speed: float | None = None,
        gap: float = 0.002,
        roll: float = 0.0,
        friction: float = FRICTION,
        up: Vector3 = UP,
    ) -> RigidBody:
        """A blade thrust `depth` [m] behind `entry` [m] along `direction` and drawn back as fast.

        Its tip begins, and ends, `gap` [m] before `entry`.
        """
        if self.shape != "blade":
            raise ScenarioError(self.name, "is no blade", "Use body(), or a knife.")
        deep = positive(f"{self.name} depth", self.depth if depth is None else depth)
        pace = positive(f"{self.name} speed", self.speed if speed is None else speed)
        thrust = deep + not_negative(f"{self.name} gap", gap)
        shape = self.solid()
        way = axis_vector("direction", direction)
        outside = np.asarray(vector("entry", entry)) - (gap + shape.upper[0]) * way
        path = BodyPath(
            times=np.array([0.0, 1.0, 2.0]) * thrust / pace,
            positions=outside + np.outer([0.0, thrust, 0.0], way),
        )
        return RigidBody(
            shape=shape,
            rotation=attitude(direction, roll=roll, up=up),
            friction=friction,
            cutting=True,
            path=path,
            name=self.name,
        )


def _triple(values: FloatArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z


def projectile(name: str) -> Projectile:
    """The projectile of the table with this name; `ScenarioError` with the nearest one if none."""
    return PROJECTILES[one_of("projectile", name, PROJECTILES)]


_ROWS = (
    Projectile(
        name="bb_4.5mm",
        shape="sphere",
        mass=0.35 * GRAM,  # PHYSICS 2: 0.34-0.375 g
        diameter=4.4 * MILLIMETRE,  # PHYSICS 2: 4.4-4.5 mm
        speed=179.8,  # 590 ft/s, the FBI's gelatin calibration [F: Hornady/FBI, PHYSICS M8a]
        speed_range=(60.0, 210.0),
        source="steel air-gun BB; gelatin at 75-210 m/s [F: Guey, militaryhealth.bmj.com]",
    ),
    Projectile(
        name="sphere_5.5mm_steel",
        shape="sphere",
        mass=0.68 * GRAM,
        diameter=5.5 * MILLIMETRE,
        speed=500.0,  # chosen: the middle of the tests
        speed_range=(99.0, 1265.0),
        source="5.5 mm steel sphere [F: Caister 2020]",
    ),
    Projectile(
        name="sphere_6mm_steel",
        shape="sphere",
        mass=0.89 * GRAM,
        diameter=6.0 * MILLIMETRE,
        speed=500.0,  # chosen: the middle of the tests
        speed_range=(99.0, 1265.0),
        source="6 mm steel sphere, 7850 kg/m3 [D]; speeds as for 5.5 mm",
    ),
    Projectile(
        name="sphere_6.35mm_steel",
        shape="sphere",
        mass=1.05 * GRAM,
        diameter=6.35 * MILLIMETRE,
        speed=500.0,  # chosen: the middle of the tests
        speed_range=(99.0, 1265.0),
        source="quarter-inch steel sphere, 7850 kg/m3 [D]; speeds as for 5.5 mm",
    ),
    Projectile(
        name="sphere_9mm_steel",
        shape="sphere",
        mass=3.0 * GRAM,
        diameter=9.0 * MILLIMETRE,
        speed=350.0,  # chosen: that of a 9x19 mm bullet
        speed_range=(99.0, 1265.0),
        source="9 mm steel sphere [F: Kieser 2014]; speeds as for 5.5 mm",
    ),
    Projectile(
        name="fsp_0.16g",
        shape="cylinder",
        mass=0.16 * GRAM,  # [F: Breeze 2013 abstract]
        diameter=2.6 * MILLIMETRE,  # [M]
        length=3.8 * MILLIMETRE,  # a right cylinder of steel with this mass [D]
        speed=500.0,  # chosen: within the tests
        speed_range=(112.0, 1652.0),
        source="fragment-simulating projectile, mass and speeds [F: Breeze 2013 abstract]",
    ),
    Projectile(
        name="fsp_1.10g",
        shape="cylinder",
        mass=1.10 * GRAM,  # [F: Breeze 2013 abstract]
        diameter=5.4 * MILLIMETRE,  # [M]
        length=6.1 * MILLIMETRE,  # a right cylinder of steel with this mass [D]
        speed=500.0,  # chosen: within the tests
        speed_range=(112.0, 1652.0),
        source="fragment-simulating projectile, mass and speeds [F: Breeze 2013 abstract]",
    ),
    Projectile(
        name="fsp_2.84g",
        shape="cylinder",
        mass=2.84 * GRAM,  # [F: Breeze 2013 abstract]
        diameter=7.5 * MILLIMETRE,  # [M]
        length=8.2 * MILLIMETRE,  # a right cylinder of steel with this mass [D]
        speed=500.0,  # chosen: within the tests
        speed_range=(112.0, 1652.0),
        source="fragment-simulating projectile, mass and speeds [F: Breeze 2013 abstract]",
    ),
    Projectile(
        name="22lr",
        shape="ogive",
        mass=2.6 * GRAM,
        diameter=5.7 * MILLIMETRE,
        length=11.7 * MILLIMETRE,  # [M]
        nose_length=6.5 * MILLIMETRE,  # [M]
        speed=350.0,
        speed_range=(330.0, 380.0),
        twist=0.406,  # 1 in 16 inch [M]
        source=".22 Long Rifle, 40 grain round nose [M: PHYSICS 2]",
    ),
    Projectile(
        name="9x19_fmj",
        shape="ogive",
        mass=8.0 * GRAM,
        diameter=9.0 * MILLIMETRE,
        length=15.5 * MILLIMETRE,  # [M]
        nose_length=9.0 * MILLIMETRE,  # [M]
        speed=360.0,
        speed_range=(350.0, 380.0),
        twist=0.25,  # [M]
        source="9x19 mm Parabellum, 124 grain full metal jacket [M: PHYSICS 2]",
    ),
    Projectile(
        name="45acp_fmj",
        shape="ogive",
        mass=14.9 * GRAM,
        diameter=11.5 * MILLIMETRE,
        length=16.8 * MILLIMETRE,  # [M]
        nose_length=10.5 * MILLIMETRE,  # [M]
        speed=265.0,  # 869 ft/s [F: lutzmoeller.net]
        speed_range=(250.0, 290.0),
        twist=0.406,  # 1 in 16 inch [M]
        source=".45 ACP, 230 grain full metal jacket [F: lutzmoeller.net]",
    ),
    Projectile(
        name="5.56_m193",
        shape="ogive",
        mass=3.56 * GRAM,
        diameter=5.69 * MILLIMETRE,
        length=19.0 * MILLIMETRE,  # [M]
        nose_length=11.0 * MILLIMETRE,  # [M]
        speed=990.0,
        speed_range=(600.0, 990.0),
        twist=0.305,  # 1 in 12 inch [M]
        source="5.56x45 mm M193 ball [M: PHYSICS 2]; rigid, so it does not break up",
    ),
    Projectile(
        name="5.56_m855",
        shape="ogive",
        mass=4.0 * GRAM,
        diameter=5.69 * MILLIMETRE,
        length=23.2 * MILLIMETRE,  # [M]
        nose_length=13.0 * MILLIMETRE,  # [M]
        speed=930.0,
        speed_range=(600.0, 930.0),
        twist=0.178,  # 1 in 7 inch [M]
        source="5.56x45 mm M855 ball [M: PHYSICS 2]; rigid, so it does not break up",
    ),
    Projectile(
        name="7.62x39",
        shape="ogive",
        mass=7.9 * GRAM,
        diameter=7.85 * MILLIMETRE,
        length=26.8 * MILLIMETRE,  # [M]
        nose_length=14.0 * MILLIMETRE,  # [M]
        speed=715.0,
        speed_range=(600.0, 760.0),  # [F: Mo 2022, PMC9252937]
        twist=0.24,  # [M]
        source="7.62x39 mm M43 ball [F: Mo 2022, PMC9252937]",
    ),
    Projectile(
        name="knife",
        shape="blade",
        mass=0.2,  # 0.1-0.3 kg, without hand and arm [M: PHYSICS 2]
        length=120.0 * MILLIMETRE,  # [chosen: a kitchen knife]
        width=25.0 * MILLIMETRE,  # 15-35 mm [M: PHYSICS 2]
        thickness=2.0 * MILLIMETRE,  # 1-3 mm [M: PHYSICS 2]
        tip_length=25.0 * MILLIMETRE,  # [chosen: as long as it is wide]
        depth=60.0 * MILLIMETRE,  # [chosen: half of the blade]
        speed=7.0,
        speed_range=(5.0, 10.0),  # [M: Knight 1975; Gilchrist 2008]
        source="kitchen knife thrust by a hand [M: Knight 1975; Gilchrist 2008]",
    ),
)

PROJECTILES: Mapping[str, Projectile] = MappingProxyType({row.name: row for row in _ROWS})
"""Common projectiles by name."""
