"""The setting up of an experiment: what is added to it, piece by piece, before it runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vulnus.core.arrays import AnyArray, Vector3
from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import LabelVolume
from vulnus.core.units import DEGREE

from ..bodies.projectiles import FRICTION, Projectile
from ..bodies.projectiles import projectile as named_projectile
from ..bodies.rigid_body import Motion, RigidBody
from ..bodies.rotations import Axis, axis_vector
from ..bodies.solids import Solid, triple
from ..boundaries import AbsorbingEnds, Boundary, HeldEnds, Wall, WallKind
from ..checked_values import finite, not_negative, one_of, positive, vector, whole_number
from ..materials import Material
from ..solver import Precision
from . import checks
from .checks import UNBOUNDED
from .initial_state import Given
from .labelled_bodies import label_bodies
from .particles import Arrangement, ParticleStore, Velocity, fill
from .projectile_launch import Launch
from .sensors import Sensor

ON_THE_PLANE = 1e-6
"""Cells that a boundary reaches further, so that nodes on its plane count as behind it [chosen: far
above round-off]."""


class ExperimentSetup:
    """What an experiment consists of; see `Experiment`."""

    def __init__(
        self,
        *,
        grid_spacing: float,
        gravity: Vector3 = (0.0, 0.0, 0.0),
        courant_number: float = 0.4,
        precision: Precision = "float32",
        threads: int = 0,
        lower: Vector3 | None = None,
        upper: Vector3 | None = None,
        grid_offset: Vector3 = (0.0, 0.0, 0.0),
    ) -> None:
        self.grid_spacing = checks.cell(grid_spacing)
        self.gravity = vector("gravity", gravity)
        self.courant_number = checks.courant_number(courant_number)
        one_of("precision", precision, ("float32", "float64"))
        self.precision: Precision = precision
        self.threads = whole_number("threads", threads, checks.MOST_THREADS)
        self._box = checks.given_box(lower, upper)
        self._grid_offset = vector("grid_offset", grid_offset)
        self._store = ParticleStore()
        self._boundaries: list[Boundary] = []
        self._rigid: dict[str, RigidBody | Launch] = {}
        self._sensors: dict[str, Sensor] = {}
        self._begun = False

    def add_body(
        self,
        solid: Solid,
        *,
        material: str | Material,
        velocity: Velocity = (0.0, 0.0, 0.0),
        particles_per_cell: float = 8,
        arrangement: Arrangement = "lattice",
        rotation: AnyArray | None = None,
        seed: int = 0,
        name: str | None = None,
    ) -> str:
        """Fill a solid with particles of a material; returns the body's name.

        `material` is a name in `MATERIALS` or a `Material`; `velocity` [m/s] one vector, an array
        (n, 3), or a function of the positions (n, 3) [m]; `arrangement` "lattice" (along the
        solid's axes) or "poisson" (random, from `seed`); `rotation` turns the solid about its
        centre first. The particles' volumes add up to the solid's. Bodies must not overlap; those
        that touch share the grid and so stick together without friction or gap.
        """
        self._refuse_after_start("add_body")
        if not isinstance(solid, Solid):
            raise ScenarioError("solid", f"is {solid!r}", "Give a Block, Ball, Rod or other Solid.")
        chosen = self._store.free_name(name, "body")
        turned = solid if rotation is None else solid.rotated(rotation)
        filled = fill(
            turned,
            point_spacing=self._point_spacing(particles_per_cell),
            arrangement=arrangement,
            seed=seed,
        )
        self._store.add(
            chosen, filled.position, filled.volume, material, velocity=velocity, solid=turned
        )
        return chosen

    def add_points(
        self,
        position: AnyArray,
        *,
        volume: AnyArray | float,
        material: str | Material,
        velocity: Velocity = (0.0, 0.0, 0.0),
        name: str | None = None,
    ) -> str:
        """Add a body as points (n, 3) [m] with a `volume` [m³] for each or for all; its name.

        The points should lie half a grid spacing apart; farther than a whole one, and the body
        falls to pieces.
        """
        self._refuse_after_start("add_points")
        chosen = self._store.free_name(name, "points")
        self._store.add(chosen, position, volume, material, velocity=velocity)
        checks.points_together(self._store.fillings, self.grid_spacing)
        return chosen

    def add_labels(
        self,
        labels: LabelVolume | AnyArray,
        *,
        materials: Mapping[int, str | Material],
        spacing: Vector3 | float | None = None,
        origin: Vector3 = (0.0, 0.0, 0.0),
        velocity: Velocity = (0.0, 0.0, 0.0),
        particles_per_cell: float = 8,
        names: Mapping[int, str] | None = None,
    ) -> dict[int, str]:
        """Fill the labels of a voxel volume, one body a label; returns label to body name.

        `labels` is a `LabelVolume`, or an array (nx, ny, nz) of whole numbers whose voxel (0, 0, 0)
        is centred at `origin` [m] and whose voxels have the edges `spacing` [m]. `materials` names
        the material of each label to fill; other labels stay empty. A body is called by `names`,
        else "label 3" and so on.
        """
        self._refuse_after_start("add_labels")
        checks.keyed_by_labels("materials", materials)
        checks.keyed_by_labels("names", {} if names is None else names)
        bodies = label_bodies(
            labels,
            wanted=tuple(materials),
            spacing=spacing,
            origin=origin,
            point_spacing=self._point_spacing(particles_per_cell),
        )
        found = {}
        for label, filled in bodies.items():
            wish = (names or {}).get(label, f"label {label}")
            found[label] = self._store.free_name(wish, "label")
            self._store.add(
                found[label], filled.position, filled.volume, materials[label], velocity=velocity
            )
        return found

    def set_state(
        self,
        body: str,
        *,
        velocity: Velocity | None = None,
        stress: Given | None = None,
        damage: Given = 0.0,
        plastic_strain: Given = 0.0,
    ) -> None:
        """Let a body of tissue begin moving, under stress, damaged or worked.

        Each value is one for all particles, an array with one for each, or a function of their
        positions (n, 3) [m]: `velocity` (3,) [m/s] (None leaves that of `add_body`), Cauchy's
        `stress` (3, 3) [Pa], tension positive, `damage` 0 to 1, `plastic_strain` >= 0. The body is
        placed as it stands under this stress; its undeformed volume and mass follow from that.
        Whether the stress is in equilibrium is yours to see to. A second call replaces the first.
        Raises `ScenarioError` for a stress beyond what the material bears.
        """
        self._refuse_after_start("set_state")
        self._store.begin_in(
            body,
            grid_spacing=self.grid_spacing,
            velocity=velocity,
            stress=stress,
            damage=damage,
            plastic_strain=plastic_strain,
        )

    def add_rigid_body(self, body: RigidBody) -> str:
        """Add a rigid body: a projectile, a blade, a plate; returns its name.

        Rigid bodies touch the tissue but not one another.
        """
        self._refuse_after_start("add_rigid_body")
        if not isinstance(body, RigidBody):
            raise ScenarioError("rigid body", f"is {body!r}", "Give a RigidBody(shape=..., ...).")
        name = checks.free_name(body.name, "rigid body", self._rigid)
        self._rigid[name] = body
        return name

    def add_projectile(
        self,
        projectile: str | Projectile,
        *,
        speed: float,
        direction: Axis,
        target: Vector3 | None = None,
        centre: Vector3 | None = None,
        motion: Motion = "dynamic",
        yaw_degrees: float = 0.0,
        pitch_degrees: float = 0.0,
        roll_degrees: float = 0.0,
        spin: float = 0.0,
        friction: float = FRICTION,
        name: str | None = None,
    ) -> str:
        """Shoot a projectile of the table `PROJECTILES`, or a `Projectile`; returns its name.

        It flies at `speed` [m/s] along `direction`. Give either `target`, any point [m] on its
        line: it then starts one cell before it meets the first tissue; or `centre`, where its
        centre of mass [m] is at time 0. Its nose points along `direction`, turned to the right by
        `yaw_degrees`, up (+z) by `pitch_degrees`, and about its long axis, clockwise from behind,
        by `roll_degrees` (a blade's width lies along z at 0, across it at 90); `spin` [rad/s] turns
        it on about that axis, for a rifled barrel by `projectile(name).spin`. `motion` "dynamic"
        lets the tissue slow it down, "kinematic" keeps its velocity. `friction` is Coulomb's
        coefficient.
        """
        self._refuse_after_start("add_projectile")
        shot = named_projectile(projectile) if isinstance(projectile, str) else projectile
        if not isinstance(shot, Projectile):
            raise ScenarioError(
                "projectile", f"is {projectile!r}", "Give a name of PROJECTILES or a Projectile."
            )
        if (target is None) == (centre is None):
            raise ScenarioError(
                "target", "is given with centre or both are missing", "Give one of the two."
            )
        one_of("motion", motion, ("dynamic", "kinematic"))
        launch = Launch(
            projectile=shot,
            speed=positive("speed", speed),
            direction=triple(axis_vector("direction", direction)),
            target=None if target is None else vector("target", target),
            centre=None if centre is None else vector("centre", centre),
            motion=motion,
            yaw=DEGREE * finite("yaw_degrees", yaw_degrees),
            pitch=DEGREE * finite("pitch_degrees", pitch_degrees),
            roll=DEGREE * finite("roll_degrees", roll_degrees),
            spin=finite("spin", spin),
            friction=not_negative("friction", friction),
        )
        chosen = checks.free_name(name, "projectile", self._rigid)
        self._rigid[chosen] = launch
        return chosen

    def add_wall(
        self,
        *,
        point: Vector3,
        normal: Axis,
        kind: WallKind = "slip",
        friction: float = 0.0,
        velocity: Vector3 = (0.0, 0.0, 0.0),
    ) -> None:
        """Add a plane through `point` [m] that acts behind it; `normal` points to the free side.

        "fixed" holds the tissue at the wall's `velocity` [m/s]; "slip" only stops motion across it
        (a plane of symmetry); "separating" lets it leave and slide with Coulomb `friction` while it
        presses. Nodes on the plane and behind it are held, so put it on a node, at a whole multiple
        of `grid_spacing`. There, across a coordinate axis and at rest, a "slip" wall mirrors what
        is before it: the tissue moves exactly as half of the whole body. The wall moves along with
        its velocity.
        """
        self._refuse_after_start("add_wall")
        one_of("kind", kind, ("fixed", "slip", "separating"))
        across = axis_vector("normal", normal)
        place = vector("point", point) + ON_THE_PLANE * self.grid_spacing * across
        self._boundaries.append(
            Wall(
                point=triple(place),
                normal=triple(across),
                kind=kind,
                friction=not_negative("friction", friction),
                velocity=vector("velocity", velocity),
            )
        )

    def hold_ends(self, *, axis: Axis, lower: float = -UNBOUNDED, upper: float = UNBOUNDED) -> None:
        """Hold the grid where x·`axis` is at most `lower` or at least `upper` [m]."""
        self._refuse_after_start("hold_ends")
        self._boundaries.append(HeldEnds(**self._ends(axis, lower, upper)))

    def absorb_ends(
        self,
        *,
        axis: Axis,
        thickness: float,
        lower: float = -UNBOUNDED,
        upper: float = UNBOUNDED,
    ) -> None:
        """As `hold_ends`, with a sponge of `thickness` [m] before each end in which waves die.

        About ten cells absorb waves as long as the sponge is thick.
        """
        self._refuse_after_start("absorb_ends")
        self._boundaries.append(
            AbsorbingEnds(
                **self._ends(axis, lower, upper), thickness=positive("thickness", thickness)
            )
        )

    def add_sensor(self, sensor: Sensor) -> str:
        """Look at something at every sample; returns the sensor's name."""
        self._refuse_after_start("add_sensor")
        if not isinstance(sensor, Sensor):
            raise ScenarioError("sensor", f"is {sensor!r}", "Give a PointSensor(position=...).")
        name = checks.free_name(sensor.name, "sensor", self._sensors)
        self._sensors[name] = sensor
        return name

    @property
    def particle_count(self) -> int:
        """How many particles there are."""
        return self._store.count

    @property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies of tissue."""
        return tuple(body.name for body in self._store.bodies)

    def _point_spacing(self, particles_per_cell: float) -> float:
        per_cell = positive("particles_per_cell", particles_per_cell)
        if not 1.0 <= per_cell <= 1000.0:
            raise ScenarioError(
                "particles_per_cell", f"is {per_cell:g}, must be 1 to 1000", "Use 8, or 27."
            )
        return self.grid_spacing / float(per_cell ** (1.0 / 3.0))

    def _refuse_after_start(self, what: str) -> None:
        if self._begun:
            raise ScenarioError(
                what, "the experiment has begun", "Add everything first, or make a new Experiment."
            )

    def _ends(self, axis: Axis, lower: float, upper: float) -> dict[str, Any]:
        low, high = finite("lower", lower), finite("upper", upper)
        if low <= -UNBOUNDED and high >= UNBOUNDED:
            raise ScenarioError("lower", "is missing, and so is upper", "Give one or both [m].")
        if not low < high:
            raise ScenarioError(
                "upper", f"is {high:g} m, must be above lower {low:g} m", "Swap them?"
            )
        more = ON_THE_PLANE * self.grid_spacing
        return {
            "axis": triple(axis_vector("axis", axis)),
            "lower": low + more,
            "upper": high - more,
        }
