"""Ray-traced stills: the wound from both sides and in section, and the bleeding limb."""

from __future__ import annotations

import numpy as np

from ..core.arrays import AnyArray, FloatArray, Vector3
from ..core.handoff import ParticleFrame, Tissue, TriangleSurface
from .camera import Camera, frame_sphere, unit
from .caption import scale_bar, write_text
from .frames import points_in_passage
from .limb_view import LimbView, triple
from .picture import side_by_side
from .projectile_view import projectiles_in
from .render import Layer, Renderer, blend, develop
from .surface import TissuePoints, tissue_surface

_EXIT_ROOM = 0.009  # m of free space behind the exit, where its rim bulges
GAP = 2  # px between two panels


def wound_view(renderer: Renderer, view: LimbView) -> FloatArray:
    """Entry, section along the shot, and exit of the wound, side by side, in linear light."""
    parameters = renderer.parameters
    width = (parameters.width - 2 * GAP) // 3
    widths = (width, parameters.width - 2 * GAP - 2 * width, width)
    wound, height = view.wound, parameters.height
    shot = wound.shot
    flight = unit(shot.direction)
    cameras = (
        _close_camera(view, shot.entry_point, -flight, (widths[0], height), wound.entry_area),
        section_camera(view, widths[1], height),
        _close_camera(view, shot.exit_point, flight, (widths[2], height), wound.exit_area or 0.0),
    )
    layers = (view.outside, section_layers(view), view.outside)
    far = "exit" if wound.exit_area is not None else "far side"
    names = ("entry", "section along the shot", far)
    panels = []
    for name, camera, shown in zip(names, cameras, layers, strict=True):
        arranged = renderer.arrange(shown, view.studio_for(camera), camera)
        light = renderer.render(arranged, camera, samples=parameters.samples)
        picture = write_text(develop(light, parameters), name)
        panels.append(scale_bar(picture, camera, length=0.01))
    return side_by_side(panels, GAP)


def bleed_view(renderer: Renderer, view: LimbView, blood: TriangleSurface) -> FloatArray:
    """The translucent limb with bones, arteries and blood, in linear light.

    A standing limb leaves the right of the picture to a close view of the bleeding wound.
    """
    parameters = renderer.parameters
    cameras = bleed_cameras(view, blood.vertices, parameters.width, parameters.height)
    layer = Layer(blood, "blood")
    front = renderer.arrange([*view.outside, layer], view.studio, cameras[0])
    back = renderer.arrange([*view.inside, layer], view.studio, cameras[0])
    panels = []
    for camera in cameras:
        lights = [
            renderer.render(arranged, camera, samples=parameters.samples)
            for arranged in (front, back)
        ]
        translucent = blend(lights[0], lights[1], parameters.leg_opacity, camera)
        panels.append(develop(translucent, parameters))
    return side_by_side(panels, GAP)


def bleed_cameras(view: LimbView, shown: AnyArray, width: int, height: int) -> list[Camera]:
    """The whole view, and for a standing limb a close view, which fill width times height."""
    if not view.is_upright:
        return [view.whole_camera(shown, width, height)]
    whole_width = int(0.40 * width) // 2 * 2
    return [
        view.whole_camera(shown, whole_width, height),
        _bleeding_close_camera(view, width - whole_width - GAP, height),
    ]


def _close_camera(
    view: LimbView, point: Vector3, outward: FloatArray, size: tuple[int, int], area: float
) -> Camera:
    """A slanting view on a hole of `area` [m²], twice as wide as it and its torn rim."""
    radius = float(np.clip(2.4 * np.sqrt(area / np.pi) + 0.008, 0.016, 0.07))
    across = unit(np.cross(view.long_axis, outward))
    toward = unit(outward + 0.30 * across + 0.18 * view.long_axis)
    up = view.up if abs(float(view.up @ toward)) < 0.9 else view.long_axis
    return frame_sphere(point, radius, toward_camera=toward, up=up, width=size[0], height=size[1])


def section_camera(view: LimbView, width: int, height: int) -> Camera:
    """A view on the plane of the shot and the limb's long axis, as wide as the wound's tract."""
    flight, normal, middle, reach = _section_plane(view)
    middle = middle + _EXIT_ROOM * flight
    along = view.long_axis
    up = -along if float(along @ view.up) < -0.5 else along  # a lying limb is shown proximal up
    up = unit(up - float(up @ normal) * normal)
    toward = unit(normal + 0.10 * flight + 0.10 * up)
    reach = reach + _EXIT_ROOM
    return frame_sphere(middle, reach, toward_camera=toward, up=up, width=width, height=height)


def section_layers(
    view: LimbView, frame: ParticleFrame | None = None, *, voxel_ratio: float = 0.5
) -> list[Layer]:
    """The limb cut open along the shot, as it is in a `frame` of the passage or at its end.

    With a frame the projectile is drawn too, at its place at that time. `voxel_ratio` is the
    mesh's voxel over the limb's spacing.
    """
    wound = view.wound
    _, normal, middle, reach = _section_plane(view)
    points, reference = TissuePoints.of(wound), wound.reference_position
    layers: list[Layer] = []
    if frame is not None:
        points, reference = points_in_passage(frame, wound)
        bodies = projectiles_in(frame, wound.shot, view.projectiles)
        layers += [Layer(body, "projectile") for body in bodies]
    place = reference - middle.astype(np.float32)
    near = (np.abs(place @ view.long_axis) < 3.0 * reach) & (place @ normal < 4.0 * wound.spacing)
    points = points.only(near & (points.tissue != Tissue.AIR))
    level_set = points.level_set(voxel_ratio).cut(triple(normal), float(normal @ middle))
    return [Layer(tissue_surface(points, level_set), "tissue"), *layers]


def _section_plane(view: LimbView) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Flight, plane normal, middle of the tract [m] and half the width to show [m]."""
    shot = view.wound.shot
    entry, exit_ = np.asarray(shot.entry_point), np.asarray(shot.exit_point)
    flight = unit(shot.direction)
    reach = 0.5 * float(np.linalg.norm(exit_ - entry)) + 0.012
    return flight, unit(np.cross(flight, view.long_axis)), 0.5 * (entry + exit_), reach


def _bleeding_close_camera(view: LimbView, width: int, height: int) -> Camera:
    wound = view.wound
    exit_ = np.asarray(wound.shot.exit_point)
    source = np.asarray(wound.injuries[0].position) if wound.injuries else exit_
    centre = 0.5 * (exit_ + source) + 0.01 * view.jet
    radius = 0.5 * float(np.linalg.norm(exit_ - source)) + 0.03
    toward = view.side(np.deg2rad(12.0))
    return frame_sphere(
        centre, radius, toward_camera=toward, up=view.up, width=width, height=height
    )
