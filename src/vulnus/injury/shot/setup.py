"""A shot before its first step: its line, the part of the limb that is simulated, the solver."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import numpy as np

from vulnus.core.arrays import AnyArray, BoolArray, FloatArray, IndexArray, Vector3
from vulnus.core.errors import AnatomyError, ScenarioError
from vulnus.core.handoff import LimbModel, ShotLine
from vulnus.core.units import MILLIMETRE

from ..bodies.rigid_body import RigidBody
from ..boundaries import AbsorbingEnds, Boundary, HeldEnds
from ..materials import tissue_table
from ..parameters import (
    InjuryMode,
    InjuryParameters,
    ProjectileParameters,
    ShotParameters,
    WoundState,
)
from ..solver import MpmSolver
from ..wound import artery_wall as wound
from .flying_bodies import body_at_contact
from .line import aim
from .run_end import LONGEST_TIME, PASSAGE_TIME

DOMAIN_MARGIN = 0.5
"""How far [m] a particle may fly out of the limb's box in a run of 1 ms; chosen: at 500 m/s."""

POSITIVE = {
    "duration": "duration_ms",
    "grid_spacing": "grid_spacing_mm",
    "frame_interval": "frame_interval_ms",
    "relaxation_frame_interval": "relaxation_frame_interval_ms",
    "bone_modulus_scale": "bone_modulus_scale",
}
"""Parameters that must be > 0, and their keys in a scenario."""

YIELDING_SPEED = 140.0
"""Speed of waves [m/s] along a limb that bulges freely, sqrt(3 G/rho) with the muscle's 3.5 MPa is
100 m/s, with its bone more; chosen: a window of 12 cm then gives the whole leg's tract (validation
case window)."""

FAR_OFF = 1e6
"""A height [m] that nothing reaches, for the end of a boundary that has one end only."""


@dataclass(frozen=True, slots=True, eq=False)
class ShotSetup:
    """A shot ready to run: the limb, which part of it is simulated, the solver at its first step.

    `simulated` (n,) are the limb's points that the solver holds, in its order; `materials` are the
    rows of its table; `bodies` the projectiles at first contact. `tracer_range` and `tracer_inside`
    say for each artery which of the solver's tracers are its `stations`, and which stations have
    one.
    """

    limb: LimbModel
    parameters: InjuryParameters
    solver: MpmSolver
    materials: FloatArray
    bodies: tuple[RigidBody, ...]
    shots: tuple[ShotLine, ...]
    simulated: IndexArray
    stations: tuple[wound.CentrelineStations, ...]
    tracer_range: tuple[slice, ...]
    tracer_inside: tuple[BoolArray, ...]

    @property
    def shot(self) -> ShotLine:
        """The first projectile's line."""
        return self.shots[0]

    @property
    def projectiles(self) -> tuple[ProjectileParameters, ...]:
        """The projectiles in the order of `shots` and of the solver's bodies."""
        others = (shot.projectile for shot in self.parameters.other_shots)
        return (self.parameters.projectile, *others)

    @property
    def turns(self) -> tuple[float, ...]:
        """Times [s] at which guided bodies turn or stop, growing."""
        paths = [body.path for body in self.bodies if body.path is not None]
        return tuple(sorted({float(time) for path in paths for time in path.times if time > 0.0}))

    @property
    def thrust_end(self) -> float:
        """Time [s] at which the last guided body is out of the limb again, 0 without one."""
        return max(self.turns, default=0.0)

    @property
    def connected(self) -> BoolArray:
        """Whether tracers m and m + 1 belong to the same artery."""
        count = self.tracer_range[-1].stop if self.tracer_range else 0
        joined = np.ones(max(count - 1, 0), np.bool_)
        ends = [part.stop - 1 for part in self.tracer_range[:-1]]
        joined[[end for end in ends if 0 <= end < len(joined)]] = False
        return joined


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """The part of the limb that is simulated: between `lower` and `upper` [m] along `axis`.

    `cut_below` and `cut_above` say whether the limb goes on beyond.
    """

    axis: FloatArray
    lower: float
    upper: float
    cut_below: bool
    cut_above: bool


def prepare_shot(limb: LimbModel, parameters: InjuryParameters) -> ShotSetup:
    """Aim, choose the window of the limb around the track, and fill the solver."""
    _check(parameters, limb)
    first = ShotParameters(projectile=parameters.projectile, aim=parameters.aim)
    flying = (first, *parameters.other_shots)
    shots = tuple(aim(limb, each.aim, each.projectile) for each in flying)
    position = np.asarray(limb.position, np.float64)
    axis = long_axis(position)
    height = position @ axis
    window = window_of(height, shots, axis, parameters.window_length)
    simulated = np.flatnonzero((height >= window.lower) & (height <= window.upper))
    inside = position[simulated]
    materials = tissue_table(
        parameters.grid_spacing, bone_modulus_scale=parameters.bone_modulus_scale
    )
    bodies = tuple(
        body_at_contact(
            each.projectile, shot, inside, upright=axis, grid_spacing=parameters.grid_spacing
        )
        for each, shot in zip(flying, shots, strict=True)
    )
    solver = _solver(
        parameters,
        materials=materials,
        box=domain_of(inside, shots[0], parameters),
        bodies=bodies,
        ends=ends_of(window, parameters),
    )
    solver.set_particles(inside, volume=limb.volume[simulated], material=limb.tissue[simulated])
    stations = tuple(
        wound.resample(artery, 0.5 * parameters.grid_spacing) for artery in limb.arteries
    )
    tracer_inside, tracer_range = _place_tracers(solver, stations, window)
    return ShotSetup(
        limb=limb,
        parameters=parameters,
        solver=solver,
        materials=materials,
        bodies=bodies,
        shots=shots,
        simulated=simulated,
        stations=stations,
        tracer_range=tracer_range,
        tracer_inside=tracer_inside,
    )


def _solver(
    parameters: InjuryParameters,
    *,
    materials: FloatArray,
    box: tuple[Vector3, Vector3],
    bodies: Sequence[RigidBody],
    ends: Sequence[Boundary],
) -> MpmSolver:
    """The solver without its particles."""
    return MpmSolver(
        materials=materials,
        grid_spacing=parameters.grid_spacing,
        lower=box[0],
        upper=box[1],
        courant_number=parameters.courant_number,
        gravity=parameters.gravity,
        bodies=bodies,
        boundaries=ends,
    )


def domain_of(
    points: FloatArray, shot: ShotLine, parameters: InjuryParameters
) -> tuple[Vector3, Vector3]:
    """Two corners [m] of a box around the points (n, 3) [m] with room for what flies off.

    Its middle, where the solver has its origin, is the node nearest to the entry of a lattice that
    stands still in space: how the limb lies among the nodes does not depend on the window.
    """
    cell = parameters.grid_spacing
    middle = cell * np.round(np.asarray(shot.entry_point) / cell)
    duration = LONGEST_TIME if parameters.duration is None else parameters.duration
    margin = DOMAIN_MARGIN * max(1.0, duration / PASSAGE_TIME)
    half = np.max(np.abs(points - middle), axis=0) + margin
    return _triple(middle - half), _triple(middle + half)


def long_axis(position: FloatArray) -> FloatArray:
    """Unit vector (3,) of the limb's long axis: the direction of largest spread, upwards."""
    centred = position - position.mean(axis=0)
    _, vectors = np.linalg.eigh(centred.T @ centred)
    axis: FloatArray = vectors[:, -1]
    return axis if axis[2] >= 0.0 else -axis


def window_of(
    height: FloatArray, shots: Sequence[ShotLine], axis: FloatArray, window_length: float | None
) -> Window:
    """The part that is simulated, of points at `height` (n,) [m] along the axis.

    The tracks' own extent along the axis comes on top of `window_length`, so that the holes of an
    oblique shot keep their distance from the window's ends; the limb's ends bound it.
    """
    lowest, highest = float(height.min()), float(height.max())
    if window_length is None:
        return Window(axis, lowest, highest, cut_below=False, cut_above=False)
    ends = [
        float(np.dot(point, axis))
        for shot in shots
        for point in (shot.entry_point, shot.exit_point)
    ]
    half = 0.5 * window_length
    lower, upper = min(ends) - half, max(ends) + half
    return Window(
        axis=axis,
        lower=max(lowest, lower),
        upper=min(highest, upper),
        cut_below=lower > lowest,
        cut_above=upper < highest,
    )


def ends_of(window: Window, parameters: InjuryParameters) -> list[Boundary]:
    """What holds the simulated part: the limb's own ends are held, cut ones yield and calm waves.

    Tissue that a cavity displaces pushes along the limb, which gives way as a bar does: a cut end
    resists over `absorbing_length` like a bar with waves of `YIELDING_SPEED`.
    """
    axis, held, length = _triple(window.axis), parameters.held_length, parameters.absorbing_length
    below, above = window.cut_below and length > 0.0, window.cut_above and length > 0.0
    ends: list[Boundary] = []
    if not (below and above):
        ends.append(
            HeldEnds(
                axis=axis,
                lower=-FAR_OFF if below else window.lower + held,
                upper=FAR_OFF if above else window.upper - held,
            )
        )
    if below or above:
        ends.append(
            AbsorbingEnds(
                axis=axis,
                lower=window.lower if below else -FAR_OFF,
                upper=window.upper if above else FAR_OFF,
                thickness=length,
                sound_speed=YIELDING_SPEED,
            )
        )
    return ends


def _place_tracers(
    solver: MpmSolver, stations: tuple[wound.CentrelineStations, ...], window: Window
) -> tuple[tuple[BoolArray, ...], tuple[slice, ...]]:
    inside, ranges, points = [], [], [np.zeros((0, 3))]
    first = 0
    for artery in stations:
        height = artery.points @ window.axis
        within = (height >= window.lower) & (height <= window.upper)
        inside.append(within)
        points.append(artery.points[within])
        ranges.append(slice(first, first + int(np.count_nonzero(within))))
        first = ranges[-1].stop
    solver.set_tracers(np.concatenate(points))
    return tuple(inside), tuple(ranges)


def _check(parameters: InjuryParameters, limb: LimbModel) -> None:
    if len(limb.position) == 0:
        raise AnatomyError("limb", "has no particles", "Check the label volume.")
    if parameters.mode not in get_args(InjuryMode):
        raise ScenarioError("injury.mode", f"is {parameters.mode!r}", 'Use "full" or "paper".')
    if parameters.bleeds_from not in get_args(WoundState):
        raise ScenarioError(
            "injury.bleeds_from",
            f"is {parameters.bleeds_from!r}",
            'Use "permanent" or "temporary".',
        )
    _check_lengths(parameters, limb)
    if parameters.laceration_threshold > parameters.damage_threshold:
        raise ScenarioError(
            "injury.laceration_threshold",
            f"is {parameters.laceration_threshold:g}, more than damage_threshold, "
            f"{parameters.damage_threshold:g}, from which an artery is transected",
            "Give less.",
        )
    for name, scenario_key in POSITIVE.items():
        value = getattr(parameters, name)
        if value is not None and not (math.isfinite(value) and value > 0.0):
            raise ScenarioError(
                f"injury.{scenario_key}",
                f"is {value:g} in SI units, must be > 0",
                "Give a positive number.",
            )
    for name in ("phase_one", "relaxation_sound_speed"):
        value = getattr(parameters, name)
        if not (math.isfinite(value) and value >= 0.0):
            raise ScenarioError(
                f"injury.{name}", f"is {value:g} in SI units, must be >= 0", "Give 0 or more."
            )
    if not 0.0 < parameters.courant_number <= 1.0:
        raise ScenarioError(
            "injury.courant_number",
            f"is {parameters.courant_number:g}, must be > 0 and <= 1",
            "Use 0.3 to 0.4.",
        )


def _check_lengths(parameters: InjuryParameters, limb: LimbModel) -> None:
    cell = parameters.grid_spacing
    if not cell >= limb.spacing:
        raise ScenarioError(
            "injury.grid_spacing_mm",
            f"is {cell / MILLIMETRE:g} mm, less than the points' spacing of "
            f"{limb.spacing / MILLIMETRE:g} mm",
            "Use about twice anatomy.particle_spacing_mm, or the tissue falls apart between cells.",
        )
    window = parameters.window_length
    ends = max(parameters.held_length, parameters.absorbing_length)
    if window is not None and not window > 2.0 * ends:
        raise ScenarioError(
            "injury.window_length_mm",
            f"is {window / MILLIMETRE:g} mm, must exceed what both ends take "
            f"({ends / MILLIMETRE:g} mm each)",
            "Use at least ten projectile diameters, or 0 for the whole limb.",
        )


def _triple(values: AnyArray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
