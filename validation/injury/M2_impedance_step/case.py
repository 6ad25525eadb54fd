"""M2: a pressure step in muscle meets bone; part of it is reflected, the rest goes on."""

from __future__ import annotations

import numpy as np

from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, ExperimentResult, Material, RegionSensor
from vulnus.validation import CaseReport, Comparison, Curve, Panel

# Density, K and G of muscle and cortical bone (PHYSICS 1.1), of any strength and with K ln J.
MUSCLE = Material(density=1060.0, bulk_modulus=2.3e9, shear_modulus=3.5e6)
BONE = Material(density=1900.0, bulk_modulus=14.2e9, shear_modulus=6.54e9)
SPACING = 1e-3
MUSCLE_CELLS, BONE_CELLS = 100, 150  # [chosen: nothing comes back from the far ends in time]
SPEED = 0.1  # of the piston [m/s] [chosen: strains below 1e-4, so that linear theory holds]
EXPECTED = 0.617  # (Z2 - Z1) / (Z2 + Z1) for 1.56e6 and 6.6e6 Rayl (PHYSICS 3)
TOLERANCE = 0.05  # PHYSICS 3


def run(quick: bool, progress: Progress) -> CaseReport:  # noqa: ARG001  seconds either way
    """One run; the quick version is the whole one."""
    result = push(progress)
    speed, place = MUSCLE.sound_speed, MUSCLE_CELLS * SPACING
    incident = plateau(result, "muscle", 1.3 * 0.5 * place / speed, 1.45 * place / speed)
    after = plateau(result, "muscle", 1.6 * place / speed, 2.4 * place / speed)
    through = plateau(result, "bone", 1.4 * place / speed, 2.0 * place / speed)
    comparisons = (
        Comparison.within(
            "stress of the step", 1e-3 * incident,
            reference=-1e-3 * MUSCLE.density * speed * SPEED, unit="kPa", relative=TOLERANCE,
            source="rho c v",
        ),
        Comparison.within(
            "reflection", after / incident - 1.0, reference=EXPECTED, unit="1",
            relative=TOLERANCE, source="(Z2 - Z1) / (Z2 + Z1); PHYSICS 3",
        ),
        Comparison.within(
            "transmission", through / incident, reference=1.0 + EXPECTED, unit="1",
            relative=TOLERANCE, source="2 Z2 / (Z2 + Z1)",
        ),
    )  # fmt: skip
    return CaseReport(comparisons=comparisons, panels=(stress_panel(result, incident),))


def push(progress: Progress) -> ExperimentResult:
    """The run: a piston begins to push the muscle; slip walls keep the strain uniaxial."""
    experiment = Experiment(grid_spacing=SPACING, precision="float64")
    middle = 0.5 * SPACING
    first = 0.0
    for name, material, cells in (("muscle", MUSCLE, MUSCLE_CELLS), ("bone", BONE, BONE_CELLS)):
        length = cells * SPACING
        experiment.add_body(
            Block(size=(length, SPACING, SPACING), centre=(first + 0.5 * length, middle, middle)),
            material=material,
            name=name,
        )
        window = Block(size=(4 * SPACING, 1.0, 1.0), centre=(first + 50 * SPACING, 0.0, 0.0))
        experiment.add_sensor(RegionSensor(solid=window, quantities=("stress",), name=name))
        first += length
    for normal in ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0)):
        across = np.array(normal)
        experiment.add_wall(point=(0.0, 0.0, 0.0), normal=across, kind="slip")
        experiment.add_wall(point=SPACING * across, normal=-across, kind="slip")
    experiment.add_wall(point=(0.0, 0.0, 0.0), normal="x", kind="fixed", velocity=(SPEED, 0.0, 0.0))
    until = 2.45 * MUSCLE_CELLS * SPACING / MUSCLE.sound_speed
    return experiment.run(until=until, sample_interval=until / 400, progress=progress)


def plateau(result: ExperimentResult, sensor: str, first: float, last: float) -> float:
    """Mean axial stress [Pa] between two times [s]."""
    chosen = (result.time > first) & (result.time < last)
    return float(np.mean(result.sensor(sensor)["stress"][chosen, 0, 0]))


def stress_panel(result: ExperimentResult, incident: float) -> Panel:
    """Stress over time in both materials, in units of the incident step."""
    time = 1e6 * result.time
    curves = [
        Curve(x=time, y=result.sensor(name)["stress"][:, 0, 0] / incident, label=name)
        for name in ("muscle", "bone")
    ]
    ends = time[[0, -1]]
    total = Curve(x=ends, y=np.full(2, 1.0 + EXPECTED), label="1 + 0.617", kind="reference")
    return Panel(
        title="stress 50 cells behind each face", x="time / µs", y="stress / incident stress",
        curves=(*curves, total),
    )  # fmt: skip
