"""The short film: the projectile's passage in slow motion, then the limb bleeding."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from ..core.arrays import AnyArray, FloatArray
from ..core.errors import RenderError
from ..core.handoff import BleedOutcome, ParticleFrame
from ..core.progress import Progress, SilentProgress
from ..core.units import MILLILITRE, MILLILITRE_PER_MINUTE, MILLISECOND
from .camera import Camera
from .caption import write_text
from .frames import Frames
from .limb_view import LimbView
from .parameters import FilmParameters
from .picture import Picture, side_by_side, to_srgb, write_whole
from .render import Arrangement, Layer, LightImage, Part, Renderer, blend, develop
from .stills import GAP, bleed_cameras, section_camera, section_layers
from .surface import blood_surface
from .variant import ADVICE

_STATIC_SAMPLES = 32  # chosen: the resting limb is traced once, so it may be clean
_PASSAGE_VOXEL_RATIO = 0.75  # chosen: half the time of 0.5, not told apart at 640 px
_SHADOW = 12  # px around the blood whose light it changes


def spread_indices(count: int, limit: int) -> list[int]:
    """At most `limit` of 0 … count - 1, evenly, with the first and the last."""
    if count <= limit:
        return list(range(count))
    return sorted({round(i) for i in np.linspace(0, count - 1, limit)})


def hold(pictures: Sequence[int], film_frames: int) -> list[int]:
    """Which picture each of `film_frames` shows, each shown as evenly long as can be."""
    count = len(pictures)
    total = max(film_frames, count)
    return [pictures[index * count // total] for index in range(total)] if count else []


@dataclass(frozen=True, slots=True, eq=False)
class RestingView:
    """One camera's view of the limb without blood, traced once: opaque and without its flesh."""

    camera: Camera
    front: LightImage
    back: LightImage

    def with_blood(
        self, renderer: Renderer, arranged: Sequence[Arrangement], parts: Sequence[Part | None]
    ) -> FloatArray:
        """The translucent limb with blood, in linear light; only `parts` are traced anew.

        `arranged` and `parts` belong to the front and the back layer; None: nothing to trace.
        """
        lights = []
        for resting, scene, part in zip((self.front, self.back), arranged, parts, strict=True):
            light = resting
            if part is not None:
                samples = renderer.parameters.film.samples
                piece = renderer.render(scene, self.camera, samples=samples, part=part)
                light = resting.with_part(part, piece)
            lights.append(light)
        opacity = renderer.parameters.leg_opacity
        return develop(blend(lights[0], lights[1], opacity, self.camera), renderer.parameters)


def rest(renderer: Renderer, view: LimbView, cameras: Sequence[Camera]) -> list[RestingView]:
    """Trace both layers of the limb without blood for each camera."""
    front, back = (
        renderer.arrange(layers, view.studio, cameras[0]) for layers in (view.outside, view.inside)
    )
    views = []
    for camera in cameras:
        lights = [renderer.render(s, camera, samples=_STATIC_SAMPLES) for s in (front, back)]
        views.append(RestingView(camera, lights[0], lights[1]))
    return views


def part_around(camera: Camera, points: AnyArray) -> Part | None:
    """The part of a picture that shows `points` (n, 3) [m] and their shadows, or None."""
    if points.shape[0] == 0:
        return None
    pixels = camera.project(points)
    size = np.array([camera.width, camera.height])
    low = np.clip(np.floor(pixels.min(axis=0)) - _SHADOW, 0, size).astype(int)
    high = np.clip(np.ceil(pixels.max(axis=0)) + _SHADOW, 0, size).astype(int)
    if np.any(high <= low):
        return None
    return Part(int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))


@dataclass(frozen=True, slots=True, eq=False)
class BloodExtent:
    """Corners (n, 3) [m] of the boxes that hold the blood of every frame of a film.

    `everywhere` of all blood, `outside` of what lies outside the tissue. A film traces the same
    parts of its pictures in every frame: another part is another program to compile.
    """

    everywhere: FloatArray
    outside: FloatArray

    @classmethod
    def over(cls, view: LimbView, frames: Iterable[ParticleFrame], spacing: float) -> BloodExtent:
        """The extent over some frames; outside, drops count from one `spacing` off."""
        everywhere, outside = [], []
        for frame in frames:
            points = frame.position[np.all(np.isfinite(frame.position), axis=1)]
            everywhere.append(_box_corners(points, spacing))
            outside.append(_box_corners(points[view.is_outside(points)], spacing))
        none = [np.zeros((0, 3))]
        return cls(np.concatenate(none + everywhere), np.concatenate(none + outside))


def bleeding_pictures(
    renderer: Renderer,
    view: LimbView,
    frames: Frames,
    chosen: Sequence[int],
    *,
    outcome: BleedOutcome | None,
    spacing: float,
) -> Iterator[Picture]:
    """One picture for each chosen frame of blood, with time, flow and losses written on it."""
    film = renderer.parameters.film
    if not chosen:
        return
    extent = BloodExtent.over(view, (frames[index] for index in chosen), spacing)
    cameras = bleed_cameras(view, extent.everywhere, film.width, film.height)
    resting = rest(renderer, view, cameras)
    parts = [
        [part_around(camera, points) for points in (extent.outside, extent.everywhere)]
        for camera in cameras
    ]
    for frame in (frames[index] for index in chosen):
        blood = blood_surface(frame.position, spacing, renderer.parameters.blood_surface)
        layer = Layer(blood, "blood_opaque")
        arranged = [
            renderer.arrange([*layers, layer], view.studio, cameras[0])
            for layers in (view.outside, view.inside)
        ]
        panels = [
            panel.with_blood(renderer, arranged, pieces)
            for panel, pieces in zip(resting, parts, strict=True)
        ]
        renderer.forget(blood)
        picture = side_by_side(panels, GAP)
        yield to_srgb(write_text(picture, bleeding_caption(frame.time, outcome), "bottom_left"))


def passage_pictures(
    renderer: Renderer, view: LimbView, frames: Frames, chosen: Sequence[int]
) -> Iterator[Picture]:
    """One picture for each chosen frame of the passage: the limb cut open along the shot."""
    film = renderer.parameters.film
    camera = section_camera(view, film.width, film.height)
    for frame in (frames[index] for index in chosen):
        layers = section_layers(view, frame, voxel_ratio=_PASSAGE_VOXEL_RATIO)
        arranged = renderer.arrange(layers, view.studio_for(camera), camera)
        light = renderer.render(arranged, camera, samples=film.samples)
        for layer in layers:
            renderer.forget(layer.surface)
        speed = view.wound.shot.speed
        text = f"passage at {speed:.0f} m/s   t = {frame.time / MILLISECOND:.2f} ms"
        yield to_srgb(write_text(develop(light, renderer.parameters), text, "bottom_left"))


def bleeding_caption(time: float, outcome: BleedOutcome | None) -> str:
    """Time, and where the run's signals are known, flow and blood loss at that time [s]."""
    text = f"t = {time:.2f} s"
    if outcome is None or outcome.waveforms.time.size == 0:
        return text
    waves, ledger = outcome.waveforms, outcome.ledger
    flow = np.interp(time, waves.time, waves.flow_injury) / MILLILITRE_PER_MINUTE
    text += f"   flow {flow:.0f} ml/min"
    if ledger.time.size == 0:
        return text
    lost = np.interp(time, ledger.time, ledger.injected) / MILLILITRE
    out = np.interp(time, ledger.time, ledger.out_of_limb + ledger.removed) / MILLILITRE
    return text + f"   lost {lost:.1f} ml, out of the limb {out:.1f} ml"


def make_film(
    path: Path,
    renderer: Renderer,
    view: LimbView,
    *,
    injury_frames: Frames = (),
    bleed_frames: Frames = (),
    outcome: BleedOutcome | None = None,
    blood_spacing: float = 0.0,
    progress: Progress | None = None,
) -> Path:
    """Render and write the film; frames are spread over the durations of the parameters."""
    bar = progress or SilentProgress()
    film = renderer.parameters.film
    passage, bleeding = _choose(film, len(injury_frames), len(bleed_frames))
    bar.begin("film", len(passage) + len(bleeding), "frames")
    parts = (
        (passage_pictures(renderer, view, injury_frames, passage), film.passage_duration),
        (
            bleeding_pictures(
                renderer, view, bleed_frames, bleeding, outcome=outcome, spacing=blood_spacing
            ),
            film.duration,
        ),
    )

    def pictures() -> Iterator[Picture]:
        done = 0
        renderer.on_pass = lambda: bar.update(done)
        for (drawn, duration), chosen in zip(parts, (passage, bleeding), strict=True):
            shown = hold(list(range(len(chosen))), round(duration * film.frames_per_second))
            for index, picture in enumerate(drawn):
                yield from [picture] * shown.count(index)
                done += 1
                bar.update(done)

    try:
        return write_film(path, pictures(), film.frames_per_second)
    finally:
        bar.end()


def write_film(path: Path, pictures: Iterable[Picture], frames_per_second: float) -> Path:
    """Encode 8-bit pictures (even sides) as H.264 in an MP4 that plays while it loads.

    Raises `RenderError` where PyAV is missing or there is no picture.
    """
    try:
        import av
    except ImportError as error:
        raise RenderError("av", "the video encoder is not installed", ADVICE) from error
    remaining = iter(pictures)
    first = next(remaining, None)
    if first is None:
        raise RenderError(str(path), "there is no frame to put into a film", "Run a stage first")

    def encode(partial: Path) -> None:
        height, width = first.shape[0] // 2 * 2, first.shape[1] // 2 * 2
        options = {"movflags": "+faststart"}
        with av.open(str(partial), "w", format="mp4", options=options) as container:
            rate = Fraction(frames_per_second).limit_denominator(1001)
            stream = container.add_stream("libx264", rate=rate)
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            stream.options = {"crf": "18", "preset": "medium"}
            for picture in _chain(first, remaining):
                pixels = np.ascontiguousarray(picture[:height, :width])
                frame = av.VideoFrame.from_ndarray(pixels, format="rgb24")
                container.mux(stream.encode(frame))
            container.mux(stream.encode())

    return write_whole(path, encode)


def _choose(film: FilmParameters, injury: int, bleed: int) -> tuple[list[int], list[int]]:
    rate = film.frames_per_second
    passage = min(round(film.passage_duration * rate), film.frame_limit)
    bleeding = min(round(film.duration * rate), film.frame_limit)
    return spread_indices(injury, passage), spread_indices(bleed, bleeding)


def _chain(first: Picture, others: Iterator[Picture]) -> Iterator[Picture]:
    yield first
    yield from others


def _box_corners(points: AnyArray, border: float) -> FloatArray:
    if points.shape[0] == 0:
        return np.zeros((0, 3))
    low, high = points.min(axis=0) - border, points.max(axis=0) + border
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
    return np.asarray(low + corners * (high - low), dtype=np.float64)
