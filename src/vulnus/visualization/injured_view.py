"""The injured geometry close by, as the paper's Fig. 3 shows it: from the front and the back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..core.arrays import FloatArray
from ..core.handoff import InjuredLimb
from ..core.units import MILLISECOND
from .camera import Camera, frame_points, frame_sphere, unit
from .caption import scale_bar, write_text
from .impact_view import ShotScene, back_title
from .limb_view import LimbView, view_limb
from .parameters import Surroundings
from .picture import Picture, to_srgb
from .render import Layer, Renderer, develop
from .sheet import compose
from .stills import section_layers

_CLOSE_WIDTH, _SECTION_WIDTH, _HEIGHT = 440, 560, 440  # px; chosen: three panels fill a page
_CLOSE_REACH = 0.042  # m around a hole that is shown; chosen: the hole and the limb's outline
_SECTION_BEFORE, _SECTION_BEHIND = 0.012, 0.030  # m shown beyond entry and exit
_LAMP = 22.0  # radiance; chosen: the tract's wall is seen, the skin keeps its shade
_LETTER = 0.04  # of a panel's height


def injured_picture(
    renderer: Renderer, states: Mapping[str, InjuredLimb], surroundings: Surroundings
) -> Picture:
    """The paper's Fig. 3, one row a state of the wound: front, section along the shot, back.

    All rows have the same cameras. Skin is drawn as skin here, torn tissue stained with blood.
    """
    rows, cameras = [], None
    for name, wound in states.items():
        view = view_limb(wound, surroundings)
        cameras = cameras or _cameras(view)
        lit = replace(view, studio=replace(view.studio, lamp=_LAMP))
        panels = [
            _panel(renderer, lit, cameras[0], view.outside),
            _panel(renderer, view, cameras[1], section_layers(view)),
            _panel(renderer, lit, cameras[2], view.outside),
        ]
        what = f"{name}, " if len(states) > 1 else ""
        label = f"{what}t = {wound.time / MILLISECOND:.1f} ms"
        panels[0] = write_text(panels[0], label, letter=_LETTER)
        rows.append([to_srgb(panel) for panel in panels])
    back = back_title(next(iter(states.values())))
    return compose(rows, titles=("front view (entry)", "section along the shot", back))


def _panel(renderer: Renderer, view: LimbView, camera: Camera, layers: list[Layer]) -> FloatArray:
    arranged = renderer.arrange(layers, view.studio_for(camera), camera)
    light = renderer.render(arranged, camera, samples=renderer.parameters.samples)
    picture = develop(light, renderer.parameters)
    return scale_bar(picture, camera, length=0.02, letter=_LETTER)


def _cameras(view: LimbView) -> tuple[Camera, Camera, Camera]:
    """Slanting views on entry and exit, and one on the plane of the shot."""
    scene = ShotScene.of(view.wound)
    shot, flight = view.wound.shot, scene.flight
    front, back = (
        frame_sphere(
            point,
            _CLOSE_REACH,
            toward_camera=unit(outward + 0.22 * scene.across + 0.16 * scene.up),
            up=scene.up,
            width=_CLOSE_WIDTH,
            height=_HEIGHT,
        )
        for point, outward in ((shot.entry_point, -flight), (shot.exit_point, flight))
    )
    entry, exit_ = scene.ends
    low, high = entry - _SECTION_BEFORE, exit_ + _SECTION_BEHIND
    half = 0.5 * (high - low) * _HEIGHT / _SECTION_WIDTH
    corners = [
        scene.middle + along * flight + above * scene.up
        for along in (low, high)
        for above in (-half, half)
    ]
    normal = unit(np.cross(flight, view.long_axis))
    section = frame_points(
        np.array(corners),
        toward_camera=unit(normal + 0.08 * flight + 0.08 * scene.up),
        up=scene.up,
        width=_SECTION_WIDTH,
        height=_HEIGHT,
        margin=0.0,
    )
    return front, section, back
