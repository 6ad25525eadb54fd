"""Path tracing with Mitsuba 3: meshes in memory in, linear light with its guides out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..core.arrays import AnyArray, Float32Array, FloatArray, Vector3
from ..core.errors import RenderError
from ..core.handoff import TriangleSurface
from .camera import Camera, unit
from .denoise import denoise
from .lighting import studio_lights
from .materials import Material, interior_medium, surface_model
from .parameters import VisualizationParameters
from .picture import backdrop
from .variant import load_mitsuba

_GUIDES = "albedo:albedo,normal:sh_normal,place:position"
_PATH_DEPTH = 5  # chosen: a sixth bounce changes no pixel by more than a grey level
_RIM_OPACITY, _RIM_POWER = 0.80, 2.0  # chosen by eye: a clear outline, a clear view inside
_RAW_OPACITY = 0.72  # chosen by eye: solid, yet the blood behind it shows
_RAW_TINT = (0.62, 0.06, 0.05)  # chosen: light through raw flesh is deep red, not grey
_FLESH_GAIN, _FLESH_TINT = (1.5, 1.05, 0.95), (1.0, 0.87, 0.82)  # chosen: warm, not grey
_SLAB_THICKNESS = 0.008  # m, chosen: a pane
_PATHS_A_PASS = 1_500_000  # about a second on two cores
_SEED_STRIDE = 7919  # a prime: passes of neighbouring seeds share no random numbers
_SAME_GUIDE = 1e-3  # far above rounding, far below what two materials differ by
_MEDIUM_DEPTH = 14  # chosen: as red as VISUALIZATION.md's 40 bounces to the eye, at half the cost


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """One mesh of a scene and what it is made of."""

    surface: TriangleSurface
    material: Material


@dataclass(frozen=True, slots=True)
class Platform:
    """The ground: the middle of its face [m] and the upward unit normal.

    A square slab of `half_extent` [m], or where that is None a floor that fades out at `radius`.
    """

    point: Vector3
    normal: Vector3
    radius: float
    half_extent: float | None = None

    @property
    def axes(self) -> FloatArray:
        """Rows: two unit vectors along the slab's sides, and the normal, (3, 3)."""
        normal = unit(self.normal)
        side = unit(np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))]))
        return np.stack([side, np.cross(normal, side), normal])

    @property
    def corners(self) -> FloatArray:
        """Corners (4, 3) [m] of the slab's face; (0, 3) for a floor without end."""
        if self.half_extent is None:
            return np.zeros((0, 3))
        signs = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]])
        return np.asarray(self.point) + self.half_extent * signs @ self.axes[:2]


@dataclass(frozen=True, slots=True)
class Studio:
    """What the studio lights are built around: the scene's centre, radius [m] and up.

    `lamp` is the radiance of a lamp beside the camera; 0: none.
    """

    centre: Vector3
    radius: float
    up: Vector3
    platform: Platform | None = None
    lamp: float = 0.0


@dataclass(frozen=True, slots=True)
class Part:
    """A rectangle of a picture [px], from its left upper corner."""

    left: int
    top: int
    width: int
    height: int

    def of(self, picture: AnyArray) -> AnyArray:
        """The rectangle of a whole picture (h, w, ...), as a view."""
        rows = slice(self.top, self.top + self.height)
        return picture[rows, self.left : self.left + self.width]


@dataclass(frozen=True, slots=True, eq=False)
class LightImage:
    """Linear light before denoising, its backdrop in place: `colour` (h, w, 3).

    `albedo` and `normal` (h, w, 3) guide the denoiser. The backdrop comes before the denoiser, so
    that silhouettes are cleaned against what lies behind them and get no dark rims.
    """

    colour: Float32Array
    albedo: Float32Array
    normal: Float32Array

    def with_part(self, part: Part, image: LightImage) -> LightImage:
        """A copy in which `part` shows `image`."""
        whole = [self.colour.copy(), self.albedo.copy(), self.normal.copy()]
        pieces = [image.colour, image.albedo, image.normal]
        for picture, piece in zip(whole, pieces, strict=True):
            part.of(picture)[...] = piece
        return LightImage(*whole)


def blend(front: LightImage, back: LightImage, opacity: float, camera: Camera) -> LightImage:
    """`front` over `back` as if it were translucent flesh, in linear light; guides blend alike.

    Like a hand before a lamp, the front layer closes where it is seen at a grazing angle: its
    weight grows from `opacity` towards its rim, and what lies behind it takes on its warmth. Raw
    flesh and blood in an open wound stay solid, so that the wound is seen as a wound.
    Pixels that see the same thing in both pictures (same seed, hence equal guides) are averaged;
    only shadows and mirror images differ there.
    """
    unlike = np.abs(front.albedo - back.albedo) + np.abs(front.normal - back.normal)
    covered = np.max(unlike, axis=-1, keepdims=True) > _SAME_GUIDE
    raw = _rawness(front.albedo)
    shown = np.maximum(rim_weight(front.normal, camera, opacity), _RAW_OPACITY * raw)
    weight = np.where(covered, shown, 0.5)
    gain = np.where(covered, np.asarray(_FLESH_GAIN), 1.0)
    flesh = (1.0 - raw) * np.asarray(_FLESH_TINT) + raw * np.asarray(_RAW_TINT)
    tint = np.where(covered, flesh, 1.0)

    def mix(a: AnyArray, b: AnyArray) -> Float32Array:
        return np.asarray(weight * a + (1.0 - weight) * b, dtype=np.float32)

    return LightImage(
        mix(gain * front.colour, tint * back.colour),
        mix(front.albedo, tint * back.albedo),
        mix(front.normal, back.normal),
    )


def rim_weight(normal: Float32Array, camera: Camera, opacity: float) -> Float32Array:
    """Weight (h, w, 1) from `opacity` where a surface faces the viewer up to the rim's."""
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    facing = np.abs(normal @ camera.axes[2])[..., None] / np.maximum(length, 1e-6)
    rim = np.clip(1.0 - facing, 0.0, 1.0) ** _RIM_POWER
    rim = np.where(length > 1e-3, rim, 0.0)
    return np.asarray(opacity + (_RIM_OPACITY - opacity) * rim, dtype=np.float32)


def _rawness(albedo: Float32Array) -> Float32Array:
    """How much (h, w, 1) a pixel shows red, wet flesh: skin and bone reflect far more green."""
    red, green = albedo[..., 0:1], albedo[..., 1:2]
    raw = np.clip((0.24 - green) / 0.13, 0.0, 1.0) * np.clip((red - 0.05) / 0.05, 0.0, 1.0)
    return np.asarray(raw, dtype=np.float32)


def develop(image: LightImage, parameters: VisualizationParameters) -> FloatArray:
    """The picture in linear light (h, w, 3), free of noise where the parameters ask for it."""
    if not parameters.denoise:
        return np.asarray(image.colour, dtype=np.float64)
    return np.asarray(denoise(image.colour, image.albedo, image.normal), dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Arrangement:
    """A scene that Mitsuba has taken in, with the integrator that it needs."""

    scene: Any
    integrator: Any
    platform: Platform | None


class Renderer:
    """One Mitsuba variant with the meshes that it has taken in; make one a process and keep it.

    `on_pass` is called about once a second while a picture is traced; Ctrl-C is answered then.
    """

    def __init__(
        self,
        parameters: VisualizationParameters,
        *,
        on_pass: Callable[[], None] = lambda: None,
    ) -> None:
        self.parameters = parameters
        self.on_pass = on_pass
        self.mitsuba = load_mitsuba(parameters.renderer)
        self._meshes: dict[tuple[int, Material], tuple[TriangleSurface, Any]] = {}

    @property
    def variant(self) -> str:
        """The name of Mitsuba's variant, e.g. llvm_ad_rgb."""
        return str(self.mitsuba.variant())

    def arrange(self, layers: Sequence[Layer], studio: Studio, camera: Camera) -> Arrangement:
        """Put meshes and platform under lights that suit `camera`; serves other cameras too."""
        mitsuba = self.mitsuba
        scene: dict[str, Any] = {"type": "scene"}
        up = unit(studio.up)
        centre = np.asarray(studio.centre)
        scene |= studio_lights(mitsuba, camera, centre, studio.radius, up, lamp=studio.lamp)
        for index, layer in enumerate(layers):
            if layer.surface.triangles.shape[0] > 0:
                scene[f"mesh_{index}"] = self._mesh(layer)
        if studio.platform is not None:
            scene["platform"] = _platform(mitsuba, studio.platform)
        has_medium = any(layer.material == "blood" for layer in layers)
        integrator = mitsuba.load_dict(_integrator(has_medium=has_medium))
        return Arrangement(mitsuba.load_dict(scene), integrator, studio.platform)

    def render(
        self, arranged: Arrangement, camera: Camera, *, samples: int, part: Part | None = None
    ) -> LightImage:
        """Trace one picture, or a `part` of it, with `samples` paths a pixel and one seed."""
        sensor = self.mitsuba.load_dict(_sensor(self.mitsuba, camera, part))
        pixels = part.width * part.height if part else camera.width * camera.height
        shares = split_samples(samples, pixels)
        channels = np.zeros(1, np.float32)
        for index, share in enumerate(shares):
            seed = self.parameters.seed + _SEED_STRIDE * index
            light = self._trace(arranged, sensor, share, seed)
            channels = channels + np.float32(share / samples) * light
            self.on_pass()
        if arranged.platform is not None and arranged.platform.half_extent is None:
            covered = np.maximum(channels[..., 3:4], 1e-3)  # places are premultiplied like light
            place = channels[..., 10:13] / covered
            channels[..., :10] *= _fade(place, arranged.platform)
        behind = backdrop(camera.width, camera.height, self.parameters.background)
        return _before_backdrop(channels, behind if part is None else part.of(behind))

    def _trace(self, arranged: Arrangement, sensor: Any, samples: int, seed: int) -> Float32Array:
        """One pass; tried twice, for another process may be writing the same compiled program."""
        trouble: BaseException | None = None
        for _ in range(2):
            try:
                traced = self.mitsuba.render(
                    arranged.scene,
                    sensor=sensor,
                    integrator=arranged.integrator,
                    spp=samples,
                    seed=seed,
                )
                return np.nan_to_num(np.array(traced, dtype=np.float32))
            except RuntimeError as error:
                trouble = error.__cause__ or error
        advice = (
            "Draw again with: vulnus render RUN; where it stays, set DRJIT_CACHE_DIR to an empty "
            "directory or renderer = 'scalar'"
        )
        raise RenderError("mitsuba", f"a picture could not be traced ({trouble})", advice)

    def forget(self, surface: TriangleSurface) -> None:
        """Drop the mesh of a surface that will not be drawn again."""
        for key in [key for key in self._meshes if key[0] == id(surface)]:
            del self._meshes[key]

    def _mesh(self, layer: Layer) -> Any:
        key = (id(layer.surface), layer.material)
        if key not in self._meshes:
            self._meshes[key] = (layer.surface, _build_mesh(self.mitsuba, layer))
        return self._meshes[key][1]


def split_samples(samples: int, pixels: int) -> list[int]:
    """Samples a pixel of each pass over a picture, so that no pass lasts much over a second."""
    passes = max(1, min(samples, -(-samples * pixels // _PATHS_A_PASS)))
    return [samples // passes + (index < samples % passes) for index in range(passes)]


def _integrator(*, has_medium: bool) -> dict[str, Any]:
    paths: dict[str, Any] = {"type": "path", "max_depth": _PATH_DEPTH, "hide_emitters": True}
    if has_medium:
        paths = {"type": "volpath", "max_depth": _MEDIUM_DEPTH, "hide_emitters": True}
    return {"type": "aov", "aovs": _GUIDES, "paths": paths}


def _sensor(mitsuba: Any, camera: Camera, part: Part | None) -> dict[str, Any]:
    shown = part or Part(0, 0, camera.width, camera.height)
    pose = mitsuba.ScalarTransform4f().look_at(
        origin=list(camera.origin), target=list(camera.target), up=list(camera.up)
    )
    distance = float(np.linalg.norm(np.subtract(camera.origin, camera.target)))
    return {
        "type": "perspective",
        "fov": float(np.rad2deg(camera.field_of_view)),
        "fov_axis": "x",
        "near_clip": 1e-3 * distance,
        "far_clip": 1e3 * distance,
        "to_world": pose,
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "crop_offset_x": shown.left,
            "crop_offset_y": shown.top,
            "crop_width": shown.width,
            "crop_height": shown.height,
            "pixel_format": "rgba",
            "component_format": "float32",
            "rfilter": {"type": "box"},  # wider filters correlate pixels and blind the denoiser
        },
        "sampler": {"type": "independent"},
    }


def _build_mesh(mitsuba: Any, layer: Layer) -> Any:
    surface = layer.surface
    properties = mitsuba.Properties()
    properties["bsdf"] = mitsuba.load_dict(surface_model(layer.material))
    medium = interior_medium(layer.material)
    if medium is not None:
        properties["interior"] = mitsuba.load_dict(medium)
    mesh = mitsuba.Mesh(
        layer.material,
        surface.vertices.shape[0],
        surface.triangles.shape[0],
        has_vertex_normals=True,
        has_vertex_texcoords=False,
        props=properties,
    )
    if layer.material == "tissue":
        count = surface.vertices.shape[0]
        colour = surface.vertex_data.get("colour", np.full((count, 3), 0.5))
        roughness = surface.vertex_data.get("roughness", np.full(count, 0.5))
        mesh.add_attribute("vertex_colour", 3, np.asarray(colour, np.float32).ravel())
        mesh.add_attribute("vertex_roughness", 1, np.asarray(roughness, np.float32).ravel())
    access = mitsuba.traverse(mesh)
    access["vertex_positions"] = np.asarray(surface.vertices, np.float32).ravel()
    access["faces"] = np.asarray(surface.triangles, np.uint32).ravel()
    access.update()
    return mesh


def _platform(mitsuba: Any, platform: Platform) -> dict[str, Any]:
    """A floor, or a slab with one side across the patient's axis that lies nearest to its face."""
    transform = mitsuba.ScalarTransform4f
    point, axes = np.asarray(platform.point), platform.axes
    pose = transform().look_at(
        origin=point.tolist(), target=(point + axes[2]).tolist(), up=axes[0].tolist()
    )
    look = {"type": "twosided", "bsdf": surface_model("platform")}
    if platform.half_extent is None:
        size = transform().scale(4.0 * platform.radius)
        return {"type": "disk", "to_world": pose @ size, "bsdf": look}
    half, depth = platform.half_extent, 0.5 * _SLAB_THICKNESS
    size = transform().translate([0.0, 0.0, -depth]) @ transform().scale([half, half, depth])
    return {"type": "cube", "to_world": pose @ size, "bsdf": look}


def _before_backdrop(channels: Float32Array, background: FloatArray) -> LightImage:
    behind = (1.0 - np.clip(channels[..., 3:4], 0.0, 1.0)) * background
    return LightImage(
        np.asarray(channels[..., 0:3] + behind, dtype=np.float32),
        np.asarray(channels[..., 4:7] + behind, dtype=np.float32),
        channels[..., 7:10],
    )


def _fade(place: AnyArray, platform: Platform) -> Float32Array:
    """What stays (h, w, 1) of a platform that dissolves into the backdrop with distance."""
    distance = np.linalg.norm(place - np.asarray(platform.point), axis=-1, keepdims=True)
    step = np.clip((distance / platform.radius - 0.45) / 0.55, 0.0, 1.0)
    return np.asarray(1.0 - step * step * (3.0 - 2.0 * step), dtype=np.float32)
