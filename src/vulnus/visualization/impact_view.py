"""The passage as the paper's Fig. 2 shows it: tissue as particles, from the side and the back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..core.arrays import FloatArray
from ..core.handoff import InjuredLimb, ParticleFrame, ShotLine, Tissue, TriangleSurface
from ..core.units import MILLISECOND
from .camera import Camera, frame_points
from .caption import scale_bar, write_text
from .frames import points_in_passage
from .limb_view import triple
from .particle_balls import FIGURE_2_LIGHT, ball_surface, seen_from
from .particle_figures import shot_axes, shot_middle
from .picture import Picture, to_srgb
from .projectile_view import projectiles_in
from .render import Layer, Renderer, Studio, develop
from .sheet import LegendEntry, compose
from .surface import TissuePoints

_BEFORE, _BEHIND = 0.022, 0.070  # m shown before the entry and behind the exit
_SIDE_WIDTH, _BACK_WIDTH, _HEIGHT = 620, 400, 280  # px; chosen: five rows fit a page
_FARTHEST = 0.07  # m behind the exit; what has flown farther would hide the back view
_ROUND_FROM = 4.0  # px of a spacing; chosen: balls of fewer show no corners
_LETTER = 0.05  # of a panel's height
_NAMES = {
    Tissue.SKIN: "skin",
    Tissue.FAT: "fat",
    Tissue.MUSCLE: "muscle",
    Tissue.BONE: "bone",
    Tissue.CANCELLOUS: "cancellous bone",
    Tissue.MARROW: "marrow",
    Tissue.ARTERY: "artery",
}


@dataclass(frozen=True, slots=True, eq=False)
class ShotScene:
    """What every picture of one shot shares: the limb, unit vectors, and cameras.

    `flight`, `up` (proximal, across the flight) and `across` (towards the viewer beside the limb)
    are (3,), `middle` [m] lies half way between entry and exit.
    """

    wound: InjuredLimb
    flight: FloatArray
    up: FloatArray
    across: FloatArray
    middle: FloatArray

    @classmethod
    def of(cls, wound: InjuredLimb) -> ShotScene:
        """The scene of a wound."""
        flight, up, across = shot_axes(wound)
        return cls(wound, flight, up, across, shot_middle(wound))

    @property
    def ends(self) -> tuple[float, float]:
        """Entry and exit along the flight [m], from the middle."""
        shot = self.wound.shot
        entry, exit_ = (np.array([shot.entry_point, shot.exit_point]) - self.middle) @ self.flight
        return float(entry), float(exit_)

    @property
    def studio(self) -> Studio:
        """Light for close views of the wound."""
        return Studio(triple(self.middle), 0.10, triple(self.up))

    def side_camera(self, width: int, height: int) -> Camera:
        """From beside the limb, flight to the right: from before the entry to behind the exit."""
        entry, exit_ = self.ends
        low, high = entry - _BEFORE, exit_ + _BEHIND
        half = 0.5 * (high - low) * height / width
        corners = [
            self.middle + along * self.flight + above * self.up
            for along in (low, high)
            for above in (-half, half)
        ]
        return frame_points(
            np.array(corners),
            toward_camera=self.across,
            up=self.up,
            width=width,
            height=height,
            margin=0.0,
        )

    def back_camera(self, width: int, height: int, half_height: float) -> Camera:
        """From where the projectile flies to, on the exit."""
        exit_ = self.middle + self.ends[1] * self.flight
        half_width = half_height * width / height
        corners = [
            exit_ + beside * self.across + above * self.up
            for beside in (-half_width, half_width)
            for above in (-half_height, half_height)
        ]
        return frame_points(
            np.array(corners),
            toward_camera=self.flight,
            up=self.up,
            width=width,
            height=height,
            margin=0.0,
        )


def impact_picture(
    renderer: Renderer,
    wound: InjuredLimb,
    frames: Sequence[ParticleFrame],
    projectiles: Sequence[TriangleSurface] = (),
) -> Picture:
    """The paper's Fig. 2: one row an instant, left from the side and cut open, right the back.

    Skin is yellow, muscle red and bone white as there; torn tissue is darker.
    """
    scene = ShotScene.of(wound)
    side = scene.side_camera(_SIDE_WIDTH, _HEIGHT)
    entry, exit_ = scene.ends
    half_height = 0.5 * (exit_ - entry + _BEFORE + _BEHIND) * _HEIGHT / _SIDE_WIDTH
    back = scene.back_camera(_BACK_WIDTH, _HEIGHT, half_height)
    rows = []
    for frame in frames:
        points, reference = points_in_passage(frame, wound)
        bodies = projectiles_in(frame, wound.shot, projectiles)
        offset = points.position - scene.middle.astype(np.float32)
        ahead = offset @ scene.flight - exit_
        near = (np.abs(offset @ scene.up) < 1.6 * half_height) & (ahead < _FARTHEST)
        far_half = (reference - scene.middle.astype(np.float32)) @ scene.across < 0.0
        panels = []
        for camera, shown in ((side, near & far_half), (back, near)):
            light = _trace(renderer, scene, camera, points.only(shown), bodies)
            panels.append(scale_bar(light, camera, length=0.02, letter=_LETTER))
        time = f"t = {frame.time / MILLISECOND:.2f} ms"
        panels[0] = write_text(panels[0], time, "top_right", letter=_LETTER)
        rows.append([to_srgb(panel) for panel in panels])
    tissues = [one for one in _NAMES if np.any(wound.tissue == one)]
    return compose(
        rows,
        titles=("side view, the near half cut away", back_title(wound)),
        legend=[LegendEntry(FIGURE_2_LIGHT[one], _NAMES[one]) for one in tissues],
    )


def back_title(wound: InjuredLimb) -> str:
    """What the view against the flight shows."""
    return "back view (exit)" if wound.exit_area is not None else "back view (no exit)"


def instants(times: Sequence[float], shot: ShotLine, *, turning: float) -> list[int]:
    """Which frames tell the story: before, inside, at the exit, the largest cavity, the end.

    `turning` [s] is when the cavity is largest; where that is the end, the frame half way from the
    exit stands for it.
    """
    length = float(np.linalg.norm(np.subtract(shot.exit_point, shot.entry_point)))
    out = (length + shot.diameter) / shot.speed
    last = times[-1]
    largest = turning if out < turning < last else 0.5 * (out + last)
    wanted = (0.0, 0.5 * length / shot.speed, out, largest, last)
    return sorted({int(np.argmin(np.abs(np.subtract(times, time)))) for time in wanted})


def _trace(
    renderer: Renderer,
    scene: ShotScene,
    camera: Camera,
    points: TissuePoints,
    bodies: Sequence[TriangleSurface],
) -> FloatArray:
    """The points as balls with the projectiles, in linear light."""
    ends = scene.middle + np.array([[0.0], [points.spacing]]) * camera.axes[0]
    pixels = float(np.ptp(camera.project(ends)[:, 0]))
    shown = points.only(seen_from(points, camera))
    balls = ball_surface(shown, round_balls=pixels > _ROUND_FROM)
    layers = [Layer(balls, "tissue")]
    for body in bodies:
        flown = float(np.max((body.vertices - scene.middle) @ scene.flight)) - scene.ends[1]
        if flown < _FARTHEST:
            layers.append(Layer(body, "projectile"))
    arranged = renderer.arrange(layers, scene.studio, camera)
    light = renderer.render(arranged, camera, samples=renderer.parameters.samples)
    for layer in layers:
        renderer.forget(layer.surface)
    return develop(light, renderer.parameters)
