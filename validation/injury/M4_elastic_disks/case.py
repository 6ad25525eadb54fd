"""M4: two elastic disks fly at each other, touch and bounce (Sulsky, Chen & Schreyer 1994)."""

from __future__ import annotations

import numpy as np

from vulnus.core.progress import Progress
from vulnus.injury import Experiment, ExperimentResult, Rod, elastic
from vulnus.validation import CaseReport, Comparison, Curve, Panel

DENSITY, YOUNGS_MODULUS, POISSON_RATIO = 1000.0, 1000.0, 0.3  # [F: PHYSICS 3, M4]
RADIUS, VELOCITY = 0.2, 0.1  # [m], [m/s] along x and y [F: the same]
BOUNCED, UNTIL = 2.6, 3.6  # [s] [chosen: the disks part at 2.4 s and vibrate with 0.5 s]
SOURCE = "PHYSICS 3, M4"


def run(quick: bool, progress: Progress) -> CaseReport:
    """40 cells across a disk; 20 in the quick version."""
    spacing = 0.02 if quick else 0.01
    result = collide(spacing, progress)
    energies = result.energies
    kinetic, total = energies["kinetic"], energies["total"]
    change = 100.0 * (total / total[0] - 1.0)
    momentum = result.body("one").momentum + result.body("other").momentum
    one = np.linalg.norm(result.body("one").momentum[0])
    comparisons = (
        Comparison.within(
            "kinetic energy before", kinetic[0] / spacing, reference=2.51, unit="J/m",
            relative=0.005, source=f"{SOURCE}; 0.5 % chosen: 2.51 is rounded",
        ),
        Comparison.at_most(
            "momentum gained over that of one disk",
            np.max(np.abs(momentum - momentum[0])) / one,
            limit=1e-10, unit="1", source=SOURCE,
        ),
        Comparison.between(
            "lowest change of total energy", np.min(change), lower=-15.0, upper=0.5, unit="%",
            source=f"{SOURCE}, APIC",
        ),
        Comparison.between(
            "highest change of total energy", np.max(change), lower=-15.0, upper=0.5, unit="%",
            source=f"{SOURCE}, APIC",
        ),
        Comparison.at_least(
            "kinetic energy after the bounce over before",
            kinetic[result.time > BOUNCED].mean() / kinetic[0],
            limit=0.8, unit="1", source=f"{SOURCE}; mean over the disks' vibration",
        ),
    )  # fmt: skip
    return CaseReport(comparisons=comparisons, panels=(energy_panel(result, spacing),))


def collide(spacing: float, progress: Progress) -> ExperimentResult:
    """The run: a slice of one cell between slip walls is plane strain."""
    experiment = Experiment(grid_spacing=spacing, precision="float64")
    solid = elastic(DENSITY, YOUNGS_MODULUS, POISSON_RATIO)
    for name, place, sign in (("one", 0.2, 1.0), ("other", 0.8, -1.0)):
        experiment.add_body(
            Rod(radius=RADIUS, length=spacing, axis="z", centre=(place, place, 0.5 * spacing)),
            material=solid,
            velocity=(sign * VELOCITY, sign * VELOCITY, 0.0),
            name=name,
        )
    experiment.add_wall(point=(0.0, 0.0, 0.0), normal="z", kind="slip")
    experiment.add_wall(point=(0.0, 0.0, spacing), normal=(0.0, 0.0, -1.0), kind="slip")
    return experiment.run(until=UNTIL, progress=progress)


def energy_panel(result: ExperimentResult, thickness: float) -> Panel:
    """Energies over time."""
    curves = [
        Curve(x=result.time, y=result.energies[name] / thickness, label=name)
        for name in ("kinetic", "elastic", "total")
    ]
    before = Curve(
        x=result.time[[0, -1]], y=np.array([2.51, 2.51]), label="2.51 J/m", kind="reference"
    )
    return Panel(
        title="energies of both disks", x="time / s", y="energy / (J/m)", curves=(*curves, before)
    )
