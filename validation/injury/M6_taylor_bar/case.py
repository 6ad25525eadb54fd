"""M6: Taylor's bar of copper, 227 m/s on a rigid frictionless wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, ExperimentResult, Fields, RegionSensor, Rod
from vulnus.validation import CaseReport, Comparison, Curve, Panel

LENGTH, RADIUS, SPEED = 32.4e-3, 3.2e-3, 227.0  # [m], [m], [m/s] [F: PHYSICS 3, M6]
UNTIL = 80e-6  # [s] [F: the same]
LENGTH_RANGE, RADIUS_RANGE = (21.4e-3, 21.7e-3), (6.9e-3, 7.3e-3)  # [m] of published codes [M]
SOURCE = "PHYSICS M6 [M: Kamoulakos; Zhu & Cescotto]"
OUTER = 0.75  # of the radius: particles beyond it tell where the side is [chosen: 2-3 layers]
FOOT_LAYERS = 8  # lowest layers of particles, among which the widest is the mushroom's [chosen]


@dataclass(frozen=True, eq=False)
class Bar:
    """What a run with so many cells across the radius gave."""

    cells: int
    result: ExperimentResult

    @property
    def spacing(self) -> float:
        """Grid spacing [m]."""
        return RADIUS / self.cells

    @property
    def layers(self) -> list[Fields]:
        """The particles that began in one layer, from the foot to the tail."""
        final = self.result.final
        height = np.round(final.reference_position[:, 2] / self.spacing, 3)
        return [final.where(height == z) for z in np.unique(height)]

    @property
    def length(self) -> float:
        """Distance [m] of the end faces; each lies half a layer's present distance outside."""
        layers = self.layers
        tail = [layer.position[:, 2].mean() for layer in layers[-2:]]
        foot = [layer.position[beside_axis(layer), 2].mean() for layer in layers[:2]]
        return float(1.5 * tail[1] - 0.5 * tail[0] - 1.5 * foot[0] + 0.5 * foot[1])

    @property
    def outline(self) -> tuple[FloatArray, FloatArray]:
        """Radius and height (n,) [m] of the bar's side in every layer."""
        sides = [side_of(layer) for layer in self.layers]
        radius, height = np.array(sides).T
        return radius, height

    @property
    def foot_radius(self) -> float:
        """Largest radius [m] among the lowest layers."""
        return float(np.max(self.outline[0][:FOOT_LAYERS]))


def run(quick: bool, progress: Progress) -> CaseReport:
    """8 and 12 cells across the radius; 6 alone in the quick version."""
    bars = [impact(cells, progress) for cells in ((6,) if quick else (8, 12))]
    fine = bars[-1]
    comparisons = [
        Comparison.within(
            "length", fine.length, reference=float(np.mean(LENGTH_RANGE)), unit="m",
            relative=0.02, source=SOURCE,
        ),
        Comparison.within(
            "radius of the foot", fine.foot_radius, reference=float(np.mean(RADIUS_RANGE)),
            unit="m", relative=0.06, source=SOURCE,
        ),
    ]  # fmt: skip
    if not quick:
        coarse = bars[0]
        comparisons += [
            Comparison.at_most(
                f"{name}: change from 8 to 12 cells", abs(one / other - 1.0), limit=limit, unit="1",
                source="chosen: less than the tolerance of the quantity",
            )
            for name, one, other, limit in (
                ("length", coarse.length, fine.length, 0.02),
                ("radius", coarse.foot_radius, fine.foot_radius, 0.06),
            )
        ]  # fmt: skip
    panels = (outline_panel(bars), shortening_panel(bars))
    return CaseReport(comparisons=tuple(comparisons), panels=panels)


def impact(cells: int, progress: Progress) -> Bar:
    """A quarter of the bar between two planes of symmetry, flying down onto the wall at z = 0."""
    spacing = RADIUS / cells
    experiment = Experiment(grid_spacing=spacing)
    quarter = Block(size=(RADIUS, RADIUS, LENGTH), centre=(RADIUS / 2, RADIUS / 2, LENGTH / 2))
    rod = Rod(radius=RADIUS, length=LENGTH, axis="z", centre=(0.0, 0.0, LENGTH / 2))
    experiment.add_body(rod & quarter, material="copper", velocity=(0.0, 0.0, -SPEED), name="bar")
    for normal in ("x", "y", "z"):
        experiment.add_wall(point=(0.0, 0.0, 0.0), normal=normal, kind="slip")
    tail = Block(size=(RADIUS, RADIUS, spacing), centre=(RADIUS / 2, RADIUS / 2, LENGTH))
    experiment.add_sensor(RegionSensor(solid=tail, quantities=("displacement",), name="tail"))
    return Bar(cells, experiment.run(until=UNTIL, progress=progress))


def beside_axis(layer: Fields) -> FloatArray:
    """Whether the particles (n,) began in the inner third of the radius."""
    inner: FloatArray = np.hypot(*layer.reference_position[:, :2].T) < RADIUS / 3.0
    return inner


def side_of(layer: Fields) -> tuple[float, float]:
    """Radius and height [m] of the material surface: the outer particles' map r0 -> r, z at R."""
    began = np.hypot(*layer.reference_position[:, :2].T)
    outer = began > OUTER * RADIUS
    now = np.column_stack([np.hypot(*layer.position[:, :2].T), layer.position[:, 2]])
    slope, _ = np.polyfit(began[outer], now[outer], 1)
    middle = now[outer].mean(axis=0) + slope * (RADIUS - began[outer].mean())
    return float(middle[0]), float(middle[1])


def outline_panel(bars: list[Bar]) -> Panel:
    """The side of the bar after 80 µs."""
    curves = [
        Curve(x=1e3 * bar.outline[0], y=1e3 * bar.outline[1], label=f"{bar.cells} cells a radius")
        for bar in bars
    ]
    published = Curve(
        x=1e3 * np.array(RADIUS_RANGE), y=np.zeros(2), label="foot, published", kind="reference"
    )
    return Panel(
        title="outline at 80 µs", x="radius / mm", y="height / mm",
        curves=(*curves, published),
    )  # fmt: skip


def shortening_panel(bars: list[Bar]) -> Panel:
    """The tail's height over time."""
    curves = [
        Curve(
            x=1e6 * bar.result.time,
            y=1e3 * (LENGTH + bar.result.sensor("tail")["displacement"][:, 2]),
            label=f"{bar.cells} cells a radius",
        )
        for bar in bars
    ]
    published = Curve(
        x=np.full(2, 1e6 * UNTIL), y=1e3 * np.array(LENGTH_RANGE), label="published",
        kind="reference points",
    )  # fmt: skip
    return Panel(
        title="length over time", x="time / µs", y="tail's height / mm",
        curves=(*curves, published),
    )  # fmt: skip
