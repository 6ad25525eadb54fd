"""From a projectile and its line of flight to a rigid body where it first touches the limb."""

from __future__ import annotations

import warnings

import numpy as np

from vulnus.core.arrays import FloatArray, Vector3
from vulnus.core.errors import ScenarioError
from vulnus.core.handoff import ShotLine
from vulnus.core.units import MILLIMETRE

from ..bodies.attitude import attitude
from ..bodies.contact_way import Outline
from ..bodies.drawn_shapes import BladeShape, Cylinder, Ogive
from ..bodies.mesh_shape import MeshShape
from ..bodies.rigid_body import BodyPath, RigidBody
from ..bodies.shapes import Shape, Sphere
from ..parameters import ProjectileParameters
from .line import line_point

OUT_CELLS = 2.0
"""Distance [cells] from every point of the limb at which a body is out of it; chosen: no node
feels both any more."""

CLEAR_CELLS = 3.0
"""How far [cells] a blade is drawn back beyond its first contact; chosen: out, and a cell more."""


def body_at_contact(
    projectile: ProjectileParameters,
    shot: ShotLine,
    points: FloatArray,
    *,
    upright: FloatArray,
    grid_spacing: float,
) -> RigidBody:
    """The body where it first touches one of the limb's `points` (n, 3) [m]; time begins here.

    `upright` (3,) is the limb's long axis, from which yaw, pitch and roll are counted.
    """
    shape = shape_of(projectile)
    _warn_of_small(projectile, grid_spacing)
    direction = np.asarray(shot.direction)
    rotation = attitude(
        shot.direction,
        yaw=projectile.yaw,
        pitch=projectile.pitch,
        roll=projectile.roll,
        up=_triple(upright),
    )
    start = line_point(shot) + _contact(shot, shape, rotation, points, grid_spacing) * direction
    centre = _triple(start)
    name = projectile.name or projectile.shape
    if projectile.shape == "blade":
        path = _thrust(projectile, shape, rotation, shot, start, grid_spacing=grid_spacing)
        return RigidBody(
            shape=shape, rotation=rotation, path=path, friction=projectile.friction,
            cutting=True, name=name,
        )  # fmt: skip
    return RigidBody(
        shape=shape,
        centre=centre,
        velocity=_triple(shot.speed * direction),
        rotation=rotation,
        angular_velocity=_triple(projectile.spin * rotation[:, 0]),
        motion=projectile.motion,
        mass=projectile.mass,
        friction=projectile.friction,
        name=name,
    )


def shape_of(projectile: ProjectileParameters) -> Shape:
    """The body's shape, of its true size."""
    p = projectile
    if p.shape == "sphere":
        return Sphere(0.5 * p.diameter)
    if p.shape == "cylinder":
        return Cylinder(0.5 * p.diameter, p.length)
    if p.shape == "ogive":
        return Ogive(0.5 * p.diameter, p.length, p.nose_length)
    if p.shape == "blade":
        return BladeShape(p.length, p.width, p.thickness, p.tip_length)
    if p.mesh is None:
        raise ScenarioError(
            "injury.projectile.stl", "is missing", "Name the STL file, or choose another shape."
        )
    return MeshShape.from_stl(p.mesh, scale=p.mesh_scale)


def _contact(
    shot: ShotLine,
    shape: Shape,
    rotation: FloatArray,
    points: FloatArray,
    grid_spacing: float,
) -> float:
    """Where on the line [m], from its point beside the entry, the body first touches a point."""
    direction = np.asarray(shot.direction)
    offset = points - line_point(shot)
    along = offset @ direction
    beside = np.einsum("ij,ij->i", offset, offset) - along**2
    if isinstance(shape, Sphere):
        radius = max(shape.radius, 0.9 * grid_spacing)
        near = beside < radius**2
        reach = np.sqrt(np.maximum(radius**2 - beside, 0.0))
    else:
        outline = Outline.of(shape)
        near = beside < outline.width(direction, rotation) ** 2
        reach = np.full(len(along), outline.reach(direction, rotation))
    if not near.any():
        return -float(reach.max())
    return float(np.min((along - reach)[near]))


def _thrust(
    projectile: ProjectileParameters,
    shape: Shape,
    rotation: FloatArray,
    shot: ShotLine,
    start: FloatArray,
    *,
    grid_spacing: float,
) -> BodyPath:
    """In until the tip is `depth` behind the skin, and out until it is clear, at the same speed."""
    direction = np.asarray(shot.direction)
    tip = Outline.of(shape).reach(direction, rotation)
    deepest = line_point(shot) + (projectile.depth - tip) * direction
    travel = float((deepest - start) @ direction)
    if not travel > 0.0:
        raise ScenarioError(
            "injury.projectile.depth_mm",
            f"is {projectile.depth / MILLIMETRE:g} mm: the blade does not reach the skin",
            "Give how deep its tip is thrust.",
        )
    clear = start - CLEAR_CELLS * grid_spacing * direction
    into = travel / shot.speed
    out = float((deepest - clear) @ direction) / shot.speed
    return BodyPath(
        times=np.array([0.0, into, into + out]), positions=np.array([start, deepest, clear])
    )


def _warn_of_small(projectile: ProjectileParameters, grid_spacing: float) -> None:
    """Say where a ball is so small that it acts as a larger one, lest it slip between nodes."""
    smallest = 1.8 * grid_spacing
    if projectile.shape == "sphere" and projectile.diameter < 0.999 * smallest:
        given, cell, acting = (
            v / MILLIMETRE for v in (projectile.diameter, grid_spacing, smallest)
        )
        acts = f"{given:.1f} mm on cells of {cell:.1f} mm acts as one of {acting:.1f} mm"
        warnings.warn(f"a projectile of {acts}", stacklevel=2)


def _triple(values: FloatArray) -> Vector3:
    x, y, z = (float(v) for v in values)
    return x, y, z
