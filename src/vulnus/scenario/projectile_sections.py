"""The scenario's tables about what flies, and along which line."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from annotated_types import Len
from pydantic import Field, field_validator, model_validator

from vulnus.core.units import GRAM, MILLIMETRE
from vulnus.injury.parameters import (
    AimParameters,
    Motion,
    ProjectileParameters,
    ProjectileShape,
    ShotParameters,
)

from .quantity import Section, auto_quantity, choice, parameter_of, quantity, to_parameters

if TYPE_CHECKING:
    from vulnus.injury.bodies.projectiles import Projectile

Coordinate = Annotated[float, Field(ge=-5000, le=5000)]
Triple = Annotated[list[float], Len(3, 3)]

_SIZES: dict[ProjectileShape, tuple[str, ...]] = {
    "sphere": ("diameter_mm",),
    "cylinder": ("diameter_mm", "length_mm"),
    "ogive": ("diameter_mm", "length_mm", "nose_length_mm"),
    "stl": ("stl", "diameter_mm"),
    "blade": ("length_mm", "width_mm", "thickness_mm", "tip_length_mm", "depth_mm"),
}
"""Keys that a shape needs, in the order in which they are missed."""
_ALL_SIZES = tuple(dict.fromkeys(key for keys in _SIZES.values() for key in keys))


class ProjectileSection(Section):
    """[injury.projectile]: what flies; by default a ball that keeps its velocity."""

    name: str | None = choice(
        None,
        "a projectile of the table that `vulnus projectiles` prints, for example 9x19_fmj: its "
        'values stand wherever a key says "auto", and nothing of a preset\'s projectile is kept',
        min_length=1,
    )
    shape: ProjectileShape | None = choice(
        None, 'sphere, cylinder, ogive (a bullet), stl or blade; "auto": the name\'s, else sphere'
    )
    motion: Motion | None = choice(
        None,
        "kinematic keeps its velocity, dynamic is slowed and turned by the tissue and needs a "
        'mass; "auto": dynamic where a mass is known and the mode is full',
    )
    mass_g: float | None = auto_quantity("mass", "g", 'mass; "auto": the name\'s', gt=0, le=5000)
    diameter_mm: float | None = auto_quantity(
        "diameter", "mm", 'diameter; "auto": the name\'s, else 9.0', gt=0, le=40
    )
    length_mm: float | None = auto_quantity(
        "length", "mm", 'of cylinder, ogive or blade; "auto": the name\'s', gt=0, le=400
    )
    nose_length_mm: float | None = auto_quantity(
        "nose_length",
        "mm",
        "of the ogive's pointed part; \"auto\": the name's, else half of length_mm",
        gt=0,
        le=400,
    )
    width_mm: float | None = auto_quantity(
        "width", "mm", 'of the blade, back to edge; "auto": the name\'s', gt=0, le=100
    )
    thickness_mm: float | None = auto_quantity(
        "thickness", "mm", 'of the blade; "auto": the name\'s', gt=0, le=20
    )
    tip_length_mm: float | None = auto_quantity(
        "tip_length",
        "mm",
        'over which the blade narrows to its tip; "auto": the name\'s, else width_mm',
        gt=0,
        le=400,
    )
    stl: str | None = choice(
        None,
        "an STL file of a closed surface, nose towards +x, relative to the scenario file",
        min_length=1,
    )
    stl_unit_mm: float = quantity(
        ProjectileParameters, "mesh_scale", "mm", "length of the STL file's unit", gt=0, le=1000
    )
    speed_m_per_s: float | None = auto_quantity(
        "speed", "m/s", 'at first contact; "auto": the name\'s, else 350.0', gt=0, le=1500
    )
    yaw_deg: float = quantity(
        ProjectileParameters,
        "yaw",
        "deg",
        "of the long axis beside the flight at first contact, nose to the flier's right",
        ge=-180,
        le=180,
    )
    pitch_deg: float = quantity(
        ProjectileParameters,
        "pitch",
        "deg",
        "of the long axis above the flight at first contact, nose up",
        ge=-90,
        le=90,
    )
    roll_deg: float = quantity(
        ProjectileParameters,
        "roll",
        "deg",
        "about the long axis, clockwise seen from behind; a blade at 0 has its width along the "
        "limb",
        ge=-360,
        le=360,
    )
    spin_rev_per_s: float | None = auto_quantity(
        "spin",
        "rev/s",
        'about the long axis, clockwise seen from behind (a right-hand twist); "auto": that of the '
        "name's rifled barrel, else 0",
        ge=-1e4,
        le=1e4,
    )
    depth_mm: float | None = auto_quantity(
        "depth",
        "mm",
        "how deep behind the skin a blade's tip is thrust before it is drawn back",
        gt=0,
        le=400,
    )
    friction: float = quantity(
        ProjectileParameters, "friction", "", "Coulomb's, against tissue", ge=0, le=2
    )

    @field_validator("name")
    @classmethod
    def _is_in_the_table(cls, name: str | None) -> str | None:
        if name is not None:
            row_of_table(name)
        return name

    @model_validator(mode="after")
    def _fits_its_shape(self) -> ProjectileSection:
        values, shape = self._values(), self._shape()
        of_name = row_of_table(self.name).shape if self.name else shape
        if shape not in (of_name, "stl"):
            raise ValueError(f"{self.name} is a {of_name}, not a {shape}: leave out name or shape")
        for key in _ALL_SIZES:
            if key not in _SIZES[shape] and getattr(self, key) is not None:
                uses = ", ".join(_SIZES[shape])
                raise ValueError(f"{key} has no meaning for a {shape}, which takes {uses}")
        for key in _SIZES[shape]:
            if values.get(key) is None:
                raise ValueError(f"a {shape} needs {key}")
        if self.motion == "dynamic" and values.get("mass_g") is None:
            raise ValueError("a dynamic projectile needs mass_g or a name of the table")
        for part, whole in (("nose_length_mm", "length_mm"), ("tip_length_mm", "length_mm")):
            if part in _SIZES[shape] and values[part] > values[whole]:
                raise ValueError(f"{part} must not exceed {whole}")
        if shape == "blade":
            self._fits_a_hand(values)
        return self

    def _fits_a_hand(self, values: dict[str, Any]) -> None:
        """Refuse a blade that no hand could thrust so."""
        if self.motion == "dynamic":
            raise ValueError('a blade is guided by a hand: motion = "kinematic"')
        if self.spin_rev_per_s:
            raise ValueError("spin_rev_per_s has no meaning for a blade, which does not turn")
        for part, whole in (("thickness_mm", "width_mm"), ("depth_mm", "length_mm")):
            if values[part] > values[whole]:
                raise ValueError(
                    f"{part} is {values[part]:g} mm, must not exceed {whole}, {values[whole]:g} mm"
                )

    @property
    def thrust_ms(self) -> float:
        """Time [ms] that a blade needs at least to its depth and back, 0 for what flies."""
        if self._shape() != "blade":
            return 0.0
        values = self._values()
        return float(2.0 * values["depth_mm"] / values["speed_m_per_s"])

    def _shape(self) -> ProjectileShape:
        if self.shape is not None:
            return self.shape
        if self.stl is not None:
            return "stl"
        return row_of_table(self.name).shape if self.name else "sphere"

    def parameters(self, *, may_move: bool) -> ProjectileParameters:
        """What flies, in SI; `may_move`: a known mass makes it dynamic unless motion says not."""
        values = self._values()
        whole = self.model_copy(update=values)
        plain = ProjectileParameters()
        unused = {
            name: getattr(plain, name)
            for key, field in type(self).model_fields.items()
            if (name := parameter_of(field)) is not None and getattr(whole, key) is None
        }
        shape = self._shape()
        if shape == "blade":
            unused["diameter"] = values["width_mm"] * MILLIMETRE
        moves = may_move and whole.mass_g is not None and shape != "blade"
        return to_parameters(
            whole,
            ProjectileParameters,
            name=self.name,
            shape=shape,
            motion=self.motion or ("dynamic" if moves else "kinematic"),
            mesh=None if self.stl is None else Path(self.stl),
            **unused,
        )

    def _values(self) -> dict[str, Any]:
        """Speed, mass and the sizes of the shape, "auto" replaced by the table's or a default."""
        keys = ("mass_g", "speed_m_per_s", *_SIZES[self._shape()])
        table = values_of_table(self.name) if self.name else {}
        found: dict[str, Any] = {}
        for key in keys:
            given = getattr(self, key)
            found[key] = table.get(key) if given is None else given
        for key, default in _fallbacks(found).items():
            if key in found and found[key] is None:
                found[key] = default
        if self.spin_rev_per_s is None and self.name is not None:
            twist = row_of_table(self.name).twist
            found["spin_rev_per_s"] = found["speed_m_per_s"] / twist if twist else 0.0
        return found


def row_of_table(name: str) -> Projectile:
    """The projectile of the table; ValueError with the nearest name where there is none."""
    from vulnus.injury.bodies.projectiles import PROJECTILES

    if name in PROJECTILES:
        return PROJECTILES[name]
    close = difflib.get_close_matches(name, PROJECTILES, n=1, cutoff=0.3)
    hint = f"did you mean {close[0]}? " if close else ""
    raise ValueError(f"is not in the table: {hint}vulnus projectiles prints it")


def values_of_table(name: str) -> dict[str, float]:
    """The values of a projectile of the table under the keys of the scenario."""
    row = row_of_table(name)
    given = {
        "mass_g": (row.mass, GRAM),
        "diameter_mm": (row.diameter, MILLIMETRE),
        "length_mm": (row.length, MILLIMETRE),
        "nose_length_mm": (row.nose_length, MILLIMETRE),
        "width_mm": (row.width, MILLIMETRE),
        "thickness_mm": (row.thickness, MILLIMETRE),
        "tip_length_mm": (row.tip_length, MILLIMETRE),
        "depth_mm": (row.depth, MILLIMETRE),
        "speed_m_per_s": (row.speed, 1.0),
    }
    return {key: float(f"{value / unit:.12g}") for key, (value, unit) in given.items() if value}


def _fallbacks(found: dict[str, Any]) -> dict[str, float | None]:
    """What stands where neither the scenario nor the table says anything."""
    length = found.get("length_mm")
    return {
        "speed_m_per_s": ProjectileParameters().speed,
        "diameter_mm": None if "length_mm" in found else 9.0,
        "nose_length_mm": None if length is None else 0.5 * length,
        "tip_length_mm": found.get("width_mm"),
    }


class AimSection(Section):
    """[injury.aim]: one point on the line of flight and one direction."""

    artery: str | None = choice(
        None,
        "the line of flight meets this artery's centre-line (popliteal, anterior_tibial, "
        'posterior_tibial, fibular); "auto": anterior_tibial, or target_mm where it is given',
        min_length=1,
    )
    fraction: float = quantity(
        AimParameters,
        "fraction",
        "",
        "where on the artery, as a part of its length from its proximal end",
        ge=0,
        le=1,
    )
    target_mm: Annotated[list[Coordinate], Len(3, 3)] | None = quantity(
        AimParameters,
        "target",
        "mm",
        "a point on the line of flight, instead of an artery: x to the patient's left, "
        'y posterior, z superior; "auto": the artery\'s point',
    )
    azimuth_deg: float = quantity(
        AimParameters,
        "azimuth",
        "deg",
        "side the projectile comes from, seen from above: 0 anterior, 90 the patient's left, "
        "180 posterior, 270 the patient's right",
        ge=-360,
        le=360,
    )
    elevation_deg: float = quantity(
        AimParameters,
        "elevation",
        "deg",
        "height the projectile comes from: > 0 from above",
        ge=-90,
        le=90,
    )
    direction: Triple | None = quantity(
        AimParameters,
        "direction",
        "",
        'direction of flight (x, y, z), instead of the two angles; "auto": the angles',
    )

    start_mm: Annotated[list[Coordinate], Len(3, 3)] | None = quantity(
        AimParameters,
        "start",
        "mm",
        "where the projectile's middle is before the shot, outside the limb, as the muzzle of a "
        'contact shot: it flies from here through the point; "auto": far enough away',
    )

    @field_validator("direction")
    @classmethod
    def _points_somewhere(cls, direction: list[float] | None) -> list[float] | None:
        if direction is not None and not any(direction):
            raise ValueError("must not be [0, 0, 0]: a direction has a length")
        return direction

    @model_validator(mode="after")
    def _one_point(self) -> AimSection:
        if self.artery is not None and self.target_mm is not None:
            raise ValueError("give artery or target_mm, not both: each fixes the line of flight")
        if self.start_mm is not None and self.direction is not None:
            raise ValueError("give start_mm or direction, not both: each fixes the line of flight")
        return self

    def parameters(self) -> AimParameters:
        """Artery or target, and direction, in SI."""
        chosen: dict[str, Any] = {"artery": self.artery}
        if self.artery is None and self.target_mm is None:
            chosen = {}
        return to_parameters(self, AimParameters, **chosen)


class ShotSection(ProjectileSection):
    """[[injury.projectiles]]: one of several projectiles at once."""

    aim: AimSection = AimSection()

    def shot(self, *, may_move: bool) -> ShotParameters:
        """The projectile and its line, in SI."""
        return ShotParameters(
            projectile=self.parameters(may_move=may_move), aim=self.aim.parameters()
        )
