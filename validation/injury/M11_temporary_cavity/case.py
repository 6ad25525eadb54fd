"""M11: the temporary cavity in 10 % gelatin and in muscle, of given energy and behind 9 mm balls.

A slice of tissue whose tract is thrown open with a given energy shows what the material makes of
that energy. Shots through a block add what happens at the ball.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.progress import Progress
from vulnus.injury import Block, Experiment, Fields, RigidBody, Rod, Sphere, projectile
from vulnus.validation import CaseReport, Comparison, Curve, Panel

BALL = projectile("sphere_9mm_steel")
SPACING = BALL.diameter / 5  # [chosen: PHYSICS 1.6]
PARTICLES_PER_CELL = 4.63  # as M8a
SLOW = 200.0  # [m/s] of waves once a ball is out; true ones left cavities 1 % smaller [chosen]
ENERGIES = (400.0, 800.0, 1300.0)  # [J/m]: 9 mm balls at 150, 240, 320 m/s [D: PHYSICS 2]
SLICE, RADIUS = 3 * SPACING, 40 * SPACING  # [m], thickness and half the width [chosen]
FAST = 2.5e-4  # [s] with true waves; slowed from the start, cavities were 7 % wider [chosen]
SAMPLE = 1.25e-4  # [s] after that
SPEEDS = (200.0, 275.0, 425.0, 350.0)  # [m/s]; muscle is shot at the last [chosen]
LENGTH, WIDTH = 35 * SPACING, 30 * SPACING  # [m] of a quarter of the block [chosen]
GROWTH, COLLAPSE = 4e-3, 15e-3  # [s] at most; PHYSICS 2
CLOSED = 0.05  # of the greatest size from the last one: the end of the collapse [chosen]
LEFT, STOPPED = 1.0, 30.0  # diameters behind the block, and m/s: the end of the flight [chosen]
PRESSURE = "PHYSICS M11: 0.2-0.6 MPa (10 % gel: 0.25-0.35)"
RATIO = "swine leg 1/1.12 of 10 % gel [F: Carr 2018, PHYSICS M11]"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Cavity:
    """`volume` (m,) at `time` (m,) [s] that `energy` made: m³ and J, or m² and J/m in a slice."""

    energy: float
    time: FloatArray
    volume: FloatArray

    @property
    def greatest(self) -> float:
        """Greatest volume."""
        return float(self.volume.max())

    @property
    def growth(self) -> float:
        """When [s] the volume is greatest."""
        return float(self.time[np.argmax(self.volume)])

    @property
    def collapsed(self) -> float:
        """When [s] it has come down to what stays at the end of the run."""
        last = float(self.volume[-1]) + CLOSED * self.greatest
        after = (self.volume <= last) & (self.time >= self.growth)
        return float(self.time[np.argmax(after)])


def run(quick: bool, progress: Progress) -> CaseReport:
    """Slices and shots; `quick`: one slice until its cavity is largest."""
    if quick:
        cavity = thrown_open("gelatin_10", ENERGIES[1], 2e-3, progress)
        return CaseReport(comparisons=slice_growth((cavity,)))
    until = (GROWTH, GROWTH, COLLAPSE)
    gel = [
        thrown_open("gelatin_10", energy, end, progress)
        for energy, end in zip(ENERGIES, until, strict=True)
    ]
    muscle = thrown_open("muscle", ENERGIES[-1], GROWTH, progress)
    shots = [shoot("gelatin_10", speed, progress) for speed in SPEEDS]
    wounded = shoot("muscle", SPEEDS[-1], progress)
    comparisons = (
        *slice_growth(tuple(gel)),
        Comparison.at_least(
            "slice: R² of area = constant times energy", fit(gel), limit=0.95, unit="1",
            source="PHYSICS M11",
        ),
        Comparison.between(
            "slice: end of the collapse in gel", 1e3 * gel[-1].collapsed, lower=5.0, upper=15.0,
            unit="ms", source="PHYSICS 2: collapse 5-15 ms",
        ),
        ratio("slice", muscle, gel[-1]),
        Comparison.at_least(
            "shot: R² of volume = constant times energy", fit(shots), limit=0.95, unit="1",
            source="PHYSICS M11",
        ),
        Comparison.between(
            "shot: energy over volume in gel", 1e-6 / slope(shots), lower=0.2, upper=0.6,
            unit="MPa", source=PRESSURE,
        ),
        ratio("shot", wounded, shots[-1]),
    )  # fmt: skip
    return CaseReport(
        comparisons=comparisons,
        panels=(over_time(gel, muscle), over_energy(gel, muscle), of_shots(shots, wounded)),
    )


def slice_growth(cavities: tuple[Cavity, ...]) -> tuple[Comparison, ...]:
    """How large cavities in slices of gel become, and when."""
    return (
        Comparison.between(
            "slice: energy over area in gel", 1e-6 / slope(cavities), lower=0.2, upper=0.6,
            unit="MPa", source=PRESSURE,
        ),
        Comparison.between(
            "slice: end of the growth in gel", 1e3 * cavities[-1].growth, lower=0.5, upper=4.0,
            unit="ms", source="PHYSICS 2: growth 0.5-4 ms",
        ),
    )  # fmt: skip


def ratio(name: str, muscle: Cavity, gel: Cavity) -> Comparison:
    """Diameter in muscle over that in gel at one energy."""
    share = muscle.greatest / muscle.energy / (gel.greatest / gel.energy)
    return Comparison.within(
        f"{name}: diameter in muscle over that in gel", float(np.sqrt(share)), reference=0.89,
        unit="1", relative=0.30, source=RATIO,
    )  # fmt: skip


def slope(cavities: list[Cavity] | tuple[Cavity, ...]) -> float:
    """Volume over energy [1/Pa], by least squares through the origin."""
    energy = np.array([cavity.energy for cavity in cavities])
    volume = np.array([cavity.greatest for cavity in cavities])
    return float(energy @ volume / (energy @ energy))


def fit(cavities: list[Cavity]) -> float:
    """R² of the line through the origin."""
    volume = np.array([cavity.greatest for cavity in cavities])
    rest = volume - slope(cavities) * np.array([cavity.energy for cavity in cavities])
    return 1.0 - float(rest @ rest) / float(np.sum((volume - volume.mean()) ** 2))


def thrown_open(tissue: str, energy: float, until: float, progress: Progress) -> Cavity:
    """A tract as wide as the ball in a slice held between two walls; its wall flies outwards.

    The tissue moves as an incompressible one does around a widening tract, at a speed that falls
    with the radius, and has `energy` [J/m] along the tract.
    """
    experiment = sliced(tissue, energy)
    start = experiment.fields()
    radius = np.hypot(*start.position.T[1:])
    far = (radius > 0.5 * RADIUS) & (radius < 0.9 * RADIUS)
    volume = start.volume[far]
    times, areas = [0.0], [0.25 * np.pi * BALL.diameter**2]

    def sample(run: Experiment) -> None:
        # Tissue hardly changes its volume: what it has given way is the area of the cavity.
        moved = np.hypot(*run.fields().position.T[1:])[far] ** 2 - radius[far] ** 2
        times.append(run.time)
        areas.append(areas[0] + np.pi * float(np.average(moved, weights=volume)))

    given = 4.0 * experiment.solver.energies()["kinetic"] / SLICE
    experiment.run(FAST, sample_interval=FAST, on_sample=sample, progress=progress)
    experiment.slow_waves(SLOW)
    experiment.run(until, sample_interval=SAMPLE, on_sample=sample, progress=progress)
    return Cavity(energy=float(given), time=np.array(times), volume=np.array(areas))


def sliced(tissue: str, energy: float) -> Experiment:
    """A quarter of the slice between planes of symmetry."""
    experiment = Experiment(grid_spacing=SPACING)
    hole = Rod(radius=BALL.diameter / 2, length=4 * SLICE, axis="x", centre=(0.0, 0.0, 0.0))
    whole = Block(size=(SLICE, RADIUS, RADIUS), centre=(SLICE / 2, RADIUS / 2, RADIUS / 2))
    # Half the density times the square of flow / r, over the whole area: energy [J/m].
    density = 1045.0  # of both within 1.5 %; the energy that is compared is read from the run
    flow = np.sqrt(energy / (np.pi * density * np.log(2.0 * RADIUS / BALL.diameter)))

    def outwards(position: FloatArray) -> FloatArray:
        velocity = np.zeros_like(position)
        across = position[:, 1:]
        velocity[:, 1:] = flow * across / np.sum(across**2, axis=1, keepdims=True)
        return velocity

    experiment.add_body(
        whole - hole,
        material=tissue,
        velocity=outwards,
        particles_per_cell=PARTICLES_PER_CELL,
        name="tissue",
    )
    for normal in ("x", "y", "z"):
        experiment.add_wall(point=(0.0, 0.0, 0.0), normal=normal, kind="slip")
    experiment.add_wall(point=(SLICE, 0.0, 0.0), normal=(-1.0, 0.0, 0.0), kind="slip")
    return experiment


def shoot(tissue: str, speed: float, progress: Progress) -> Cavity:
    """A quarter of ball and block, until the cavity shrinks."""
    experiment = shot(tissue, speed)
    whole = within_block(experiment.fields())
    times, volumes = [0.0], [0.0]

    def sample(run: Experiment) -> None:
        times.append(run.time)
        volumes.append(whole - within_block(run.fields()))

    def out(run: Experiment) -> bool:
        ball = run.rigid_body("ball")
        gone = ball.position[0] > LENGTH + LEFT * BALL.diameter
        return bool(gone or ball.velocity[0] < STOPPED)

    def shrinks(run: Experiment) -> bool:  # noqa: ARG001
        return volumes[-1] < 0.98 * max(volumes)

    experiment.run(GROWTH, sample_interval=FAST / 5, stop_when=out, progress=progress)
    residual = float(experiment.rigid_body("ball").velocity[0])
    experiment.slow_waves(SLOW)
    experiment.run(
        GROWTH,
        sample_interval=SAMPLE,
        stop_when=shrinks,
        on_sample=sample,
        progress=progress,
    )
    energy = 0.5 * BALL.mass * (speed**2 - residual**2)
    return Cavity(energy=energy, time=np.array(times), volume=np.array(volumes))


def shot(tissue: str, speed: float) -> Experiment:
    """Ball and block between two planes of symmetry along the line of flight."""
    experiment = Experiment(grid_spacing=SPACING)
    experiment.add_body(
        Block(size=(LENGTH, WIDTH, WIDTH), centre=(LENGTH / 2, WIDTH / 2, WIDTH / 2)),
        material=tissue,
        particles_per_cell=PARTICLES_PER_CELL,
        name="tissue",
    )
    for normal in ("y", "z"):
        experiment.add_wall(point=(0.0, 0.0, 0.0), normal=normal, kind="slip")
    experiment.add_rigid_body(
        RigidBody(
            shape=Sphere(BALL.diameter / 2),
            centre=(-BALL.diameter / 2 - SPACING, 0.0, 0.0),
            velocity=(speed, 0.0, 0.0),
            motion="dynamic",
            mass=BALL.mass / 4,
            rail=(1.0, 0.0, 0.0),
            name="ball",
        )
    )
    return experiment


def within_block(fields: Fields) -> float:
    """Volume [m³] of tissue, all four quarters, in a cylinder around the line of flight.

    It is as long as the block and nearly as wide; what leaves it is the cavity's volume.
    """
    x, y, z = fields.position.T
    inside = (x > 0.0) & (x < LENGTH) & (np.hypot(y, z) < 0.95 * WIDTH)
    return 4.0 * float(fields.volume[inside].sum())


def over_time(gel: list[Cavity], muscle: Cavity) -> Panel:
    """Growth and collapse in slices."""
    curves = [
        Curve(x=1e3 * c.time, y=1e4 * c.volume, label=f"{name}, {c.energy:.0f} J/m")
        for name, c in (*(("gel", c) for c in gel), ("muscle", muscle))
    ]
    return Panel(title="slice: course", x="time / ms", y="area / cm²", curves=tuple(curves))


def over_energy(gel: list[Cavity], muscle: Cavity) -> Panel:
    """Greatest areas in slices."""
    curves = against_energy(gel, muscle, unit=1e4)
    return Panel(title="slice: largest", x="energy / (J/m)", y="area / cm²", curves=curves)


def of_shots(gel: list[Cavity], muscle: Cavity) -> Panel:
    """Greatest volumes behind balls."""
    curves = against_energy(gel, muscle, unit=1e6)
    return Panel(title="shots: largest", x="energy lost / J", y="volume / cm³", curves=curves)


def against_energy(gel: list[Cavity], muscle: Cavity, *, unit: float) -> tuple[Curve, ...]:
    """Greatest size over energy, between the lines of the accepted pressures."""
    energy = np.array([0.0, *(c.energy for c in gel)])
    greatest = unit * np.array([c.greatest for c in gel])
    points = [
        Curve(x=energy[1:], y=greatest, label="gel", kind="points"),
        Curve(
            x=np.array([muscle.energy]), y=unit * np.array([muscle.greatest]), label="muscle",
            kind="points",
        ),
    ]  # fmt: skip
    line = Curve(x=energy, y=unit * slope(gel) * energy, label=f"{1e-6 / slope(gel):.2f} MPa")
    bounds = [
        Curve(x=energy, y=1e-6 * unit * energy / p, label=f"{p:g} MPa", kind="reference")
        for p in (0.2, 0.6)
    ]
    return (line, *points, *bounds)
