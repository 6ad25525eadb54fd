"""Tables of arterial segments: reading, checking, repairing and naming them.

A row has an id, a name, its parent's id (0 at the root), length, radius, wall thickness, Young's
modulus, the published quarter-wave frequency and, for paired vessels, which of the pair it is.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vulnus.core.arrays import FloatArray, IntArray
from vulnus.core.errors import CirculationError

from .levels import TreeLevels
from .vessel_names import readable_names

ROOT_PARENT = 0
QUARTER_WAVE_TOLERANCE = 0.04
"""Largest deviation of the checksum [1]: the published values are rounded to three digits."""

_CHECKSUM_DENSITY = 1050.0  # [kg/m³], with which the published column was made
_KNOWN_MISPRINTS = {"stergiopulos91": frozenset({2, 16, 22, 30, 91})}
_INTERCOSTALS, _THORACIC_AORTA = 91, 10
_POSTERIOR = "Posteriortibial artery"
_TRUNK_LENGTH = 0.036  # [m], the tibiofibular trunk of ADAN56 (Blanco 2015)
_PERONEAL_ROWS = (120, 126)  # upper and lower left segment of the 128-segment table
_PERONEAL_THICKNESS = 0.39e-3  # [m]; 0.19 mm in the lower row is a misprint (checksum)


class Segment(NamedTuple):
    """One row of a table; SI. `parent` 0 is the root; `pair_member` "first" is the left one.

    A terminal has its total resistance; `proximal_resistance` (0: matched to the vessel) and
    `bed_compliance` (nan: its share of the parameters' total) make it a given Windkessel.
    """

    id: int
    name: str
    parent: int
    length: float
    radius: float
    thickness: float
    youngs_modulus: float
    quarter_wave_frequency: float
    pair_member: str
    terminal_resistance: float
    proximal_resistance: float = 0.0
    bed_compliance: float = np.nan


@dataclass(frozen=True, eq=False)
class SegmentTable:
    """A checked tree of segments, ordered by distance from the root, siblings side by side.

    Arrays (n,): `ids`; `parent_row`, the row of the parent or -1; `depth`, 0 at the root; `length`,
    `radius`, `thickness` [m]; `youngs_modulus` [Pa]; `terminal_resistance` [Pa s/m³], infinite
    where a segment branches; `proximal_resistance` and `bed_compliance` [m³/Pa] as in `Segment`.
    `names` are readable and unique ("left anterior tibial 2").
    """

    ids: IntArray
    parent_row: IntArray
    depth: IntArray
    length: FloatArray
    radius: FloatArray
    thickness: FloatArray
    youngs_modulus: FloatArray
    terminal_resistance: FloatArray
    proximal_resistance: FloatArray
    bed_compliance: FloatArray
    names: tuple[str, ...]

    @cached_property
    def levels(self) -> TreeLevels:
        """The rows by distance from the root."""
        return TreeLevels.of(self.depth, self.parent_row)

    @cached_property
    def row_of(self) -> Mapping[int, int]:
        """Row of each segment id."""
        return {int(segment): row for row, segment in enumerate(self.ids)}

    @cached_property
    def id_of(self) -> Mapping[str, int]:
        """Id of each readable name."""
        return dict(zip(self.names, (int(segment) for segment in self.ids), strict=True))

    def row(self, segment: int) -> int:
        """Row of a segment id, or a `CirculationError` where the tree has no such segment."""
        if segment not in self.row_of:
            raise CirculationError(
                f"segment {segment}",
                f"is not one of the tree's {len(self.ids)} segments",
                "Use an id of the table or ArterialTree.locate",
            )
        return self.row_of[segment]


@cache
def stergiopulos91(*, peroneal: bool = False) -> SegmentTable:
    """The paper's 91 segments with 28 terminal resistances; SI, checked and repaired.

    The intercostals hang off the left subclavian in the published file; here they leave the first
    thoracic segment, as in the body (a documented deviation). `peroneal` adds the fibular artery
    of both sides, from the 128-segment table, as a branch of the posterior tibial.
    """
    rows = read_segments(_data("stergio91_eldredge.csv"), _terminal_resistances())
    rows = [
        row._replace(parent=_THORACIC_AORTA) if row.id == _INTERCOSTALS else row for row in rows
    ]
    for problem in checksum_deviations(rows, skip=_KNOWN_MISPRINTS["stergiopulos91"]):
        warnings.warn(problem, stacklevel=2)
    if peroneal:
        rows = _with_peroneal(rows)
    return build_table(rows, subject="tree stergiopulos91")


def read_segments(path: Path, terminal_resistance: Mapping[int, float]) -> list[Segment]:
    """Rows of a CSV file in the format of `data/stergio91_eldredge.csv`.

    `terminal_resistance` maps ids to [Pa s/m³].
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            return [_segment(row, terminal_resistance) for row in csv.DictReader(file)]
    except (OSError, KeyError, ValueError, TypeError, UnicodeDecodeError) as error:
        raise CirculationError(
            str(path),
            f"is not a table of arterial segments ({type(error).__name__}: {error})",
            "Compare its header with data/stergio91_eldredge.csv",
        ) from error


def build_table(rows: list[Segment], *, subject: str) -> SegmentTable:
    """Check the rows and order them by distance from the root.

    Raises `CirculationError` for a value that is not positive and finite, a repeated id, an
    unknown parent, no root or several, a cycle, or an end without a terminal resistance.
    """
    _check_values(rows, subject)
    order, depth = _order_from_root(rows, subject)
    _check_terminals(order, subject)
    row_of = {row.id: place for place, row in enumerate(order)}
    parents = {row.parent for row in order}
    resistance = [np.inf if row.id in parents else row.terminal_resistance for row in order]
    names = readable_names([(row.name, row.pair_member) for row in order])
    return SegmentTable(
        ids=np.array([row.id for row in order], dtype=np.int32),
        parent_row=np.array([row_of.get(row.parent, -1) for row in order], dtype=np.int32),
        depth=np.array(depth, dtype=np.int32),
        length=np.array([row.length for row in order]),
        radius=np.array([row.radius for row in order]),
        thickness=np.array([row.thickness for row in order]),
        youngs_modulus=np.array([row.youngs_modulus for row in order]),
        terminal_resistance=np.array(resistance),
        proximal_resistance=np.array([row.proximal_resistance for row in order]),
        bed_compliance=np.array([row.bed_compliance for row in order]),
        names=tuple(names),
    )


def checksum_deviations(rows: list[Segment], *, skip: frozenset[int] = frozenset()) -> list[str]:
    """What is odd about rows whose quarter-wave frequency is not 1.2 c0 / (4 L), ν = 0.

    The published column was computed from the row's other values, so that a misprint in any of
    them shows; rows in `skip` and rows without the column are passed over.
    """
    problems = []
    for row in rows:
        if row.id in skip or row.quarter_wave_frequency == 0.0:
            continue
        stiffness = row.youngs_modulus * row.thickness / (2.0 * _CHECKSUM_DENSITY * row.radius)
        expected = 1.2 * stiffness**0.5 / (4.0 * row.length)
        if abs(expected / row.quarter_wave_frequency - 1.0) > QUARTER_WAVE_TOLERANCE:
            problems.append(
                f"segment {row.id} ({row.name}): quarter-wave frequency "
                f"{row.quarter_wave_frequency:g} Hz in the table, {expected:.1f} Hz from its "
                "length, radius, thickness and modulus; one of them is a misprint"
            )
    return problems


def _data(name: str) -> Path:
    return Path(str(resources.files("vulnus.circulation").joinpath("data", name)))


def _terminal_resistances() -> dict[int, float]:
    path = _data("stergio91_terminal_resistance.csv")
    with path.open(newline="", encoding="utf-8") as file:
        return {int(row["id"]): float(row["R_total_Pa_s_m3"]) for row in csv.DictReader(file)}


def _segment(row: Mapping[str, str], terminal_resistance: Mapping[int, float]) -> Segment:
    identity = int(row["id"])
    return Segment(
        id=identity,
        name=row["name"],
        parent=int(row["parent"]),
        length=float(row["length_m"]),
        radius=float(row["radius_m"]),
        thickness=float(row["thickness_m"]),
        youngs_modulus=float(row["young_Pa"]),
        quarter_wave_frequency=float(row.get("quarter_wave_freq_Hz") or 0.0),
        pair_member=row.get("pair_member") or "",
        terminal_resistance=terminal_resistance.get(identity, 0.0),
    )


def _with_peroneal(rows: list[Segment]) -> list[Segment]:
    """The rows with a fibular artery on both sides, at the end of the tibiofibular trunk.

    The trunk is the first 3.6 cm of the posterior tibial, which is split there (a uniform line cut
    in two is the same line). The terminal resistance is the posterior tibial's, scaled by the
    cubes of the radii (Murray's law: flow follows R³), since no table gives one.
    """
    avolio = {row.id: row for row in read_segments(_data("avolio128_eldredge.csv"), {})}
    upper, lower = (
        avolio[row]._replace(thickness=_PERONEAL_THICKNESS, name="Peroneal artery")
        for row in _PERONEAL_ROWS
    )
    for side in ("first", "second"):
        posterior = [row for row in rows if row.name == _POSTERIOR and row.pair_member == side]
        trunk, distal = posterior
        free_id = max(row.id for row in rows) + 1
        middle = trunk._replace(
            id=free_id,
            parent=trunk.id,
            length=trunk.length - _TRUNK_LENGTH,
            quarter_wave_frequency=0.0,
        )
        resistance = distal.terminal_resistance * (distal.radius / lower.radius) ** 3
        changed = {
            trunk.id: trunk._replace(length=_TRUNK_LENGTH, quarter_wave_frequency=0.0),
            distal.id: distal._replace(parent=middle.id),
        }
        rows = [changed.get(row.id, row) for row in rows] + [
            middle,
            upper._replace(id=free_id + 1, parent=trunk.id, pair_member=side),
            lower._replace(
                id=free_id + 2,
                parent=free_id + 1,
                pair_member=side,
                terminal_resistance=resistance,
            ),
        ]
    return rows


def _check_values(rows: list[Segment], subject: str) -> None:
    seen: set[int] = set()
    for row in rows:
        if row.id in seen or row.id == ROOT_PARENT:
            raise CirculationError(
                f"{subject}, segment {row.id}", "is a repeated or zero id", "Number rows from 1"
            )
        seen.add(row.id)
        for name in ("length", "radius", "thickness", "youngs_modulus"):
            value = getattr(row, name)
            if not (np.isfinite(value) and value > 0.0):
                raise CirculationError(
                    f"{subject}, segment {row.id} ({row.name})",
                    f"{name} = {value:g}, must be positive and finite (SI)",
                    "Correct the row of the table",
                )


def _order_from_root(rows: list[Segment], subject: str) -> tuple[list[Segment], list[int]]:
    known = {row.id for row in rows}
    children: dict[int, list[Segment]] = {}
    for row in rows:
        if row.parent not in known and row.parent != ROOT_PARENT:
            raise CirculationError(
                f"{subject}, segment {row.id} ({row.name})",
                f"has the unknown parent {row.parent}",
                "Name the id of another row, or 0 at the root",
            )
        children.setdefault(row.parent, []).append(row)
    roots = children.get(ROOT_PARENT, [])
    if len(roots) != 1:
        raise CirculationError(
            subject,
            f"has {len(roots)} roots (rows with parent 0); a tree has one",
            "Connect every segment but one to a parent",
        )
    order, depth = [roots[0]], [0]
    for place, row in enumerate(order):  # grows while it is walked: breadth first
        below = children.get(row.id, [])
        order += below
        depth += [depth[place] + 1] * len(below)
    if len(order) != len(rows):
        lost = sorted(known - {row.id for row in order})
        raise CirculationError(
            subject,
            f"segments {lost} form a cycle that the root does not reach",
            "Correct their parents",
        )
    return order, depth


def _check_terminals(rows: list[Segment], subject: str) -> None:
    parents = {row.parent for row in rows}
    for row in rows:
        resistance = row.terminal_resistance
        if row.id not in parents and not (np.isfinite(resistance) and resistance > 0.0):
            raise CirculationError(
                f"{subject}, segment {row.id} ({row.name})",
                f"ends the tree with terminal resistance {resistance:g} Pa s/m³; must be positive",
                "Give every end a resistance",
            )
        if not 0.0 <= row.proximal_resistance < max(resistance, np.finfo(float).tiny):
            raise CirculationError(
                f"{subject}, segment {row.id} ({row.name})",
                f"proximal resistance {row.proximal_resistance:g} Pa s/m³ must be below the "
                f"terminal's total, {resistance:g}",
                "Give the total of both resistances",
            )
