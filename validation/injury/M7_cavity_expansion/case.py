"""M7: quasi-static expansion of a spherical cavity in an elastic, perfectly plastic solid."""

from __future__ import annotations

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.progress import Progress
from vulnus.injury import (
    Ball,
    Block,
    Experiment,
    ExperimentResult,
    Fields,
    RigidBody,
    Sphere,
    von_mises,
)
from vulnus.validation import CaseReport, Comparison, Curve, Panel

YOUNGS_MODULUS, POISSON_RATIO, YIELD_STRESS = 30e6, 0.49, 1e6  # [Pa] [chosen: E/Y = 30]
DENSITY = 1000.0  # [kg/m³] [chosen]
SPACING = 1e-3  # [m] [chosen: only ratios matter]
GROWTH = 4.0  # [m/s] [chosen: inertia 3/2 rho v² = 24 kPa, 1 % of the pressure]
LIMIT = 2.0 / 3.0 * YIELD_STRESS * (1.0 + np.log(2.0 * YOUNGS_MODULUS / (3.0 * YIELD_STRESS)))
SOURCE = "PHYSICS M7 (Bishop, Hill & Mott 1945)"
LAST = 0.8  # part of the growth after which force and radius are averaged [chosen]


def run(quick: bool, progress: Progress) -> CaseReport:
    """Cavity from 2 to 6 cells of radius in a ball of 30; 1.5 to 4 in 20 in the quick version."""
    first, last, outer = np.array((1.5, 4.0, 20.0) if quick else (2.0, 6.0, 30.0)) * SPACING
    result = expand(first, last, outer, progress)
    radius = cavity_radius(result, first, outer)
    pressure = contact_pressure(result, radius)
    late = result.time > LAST * result.time[-1]
    contact = float(np.mean(pressure[late]))
    beside = wall_pressure(result.final, radius[-1])
    comparisons = (
        Comparison.within(
            "pressure on the ball", contact, reference=LIMIT, unit="Pa", relative=0.10,
            source=SOURCE,
        ),
        Comparison.within(
            "pressure, from the stress beside", beside, reference=LIMIT, unit="Pa", relative=0.10,
            source=SOURCE,
        ),
        Comparison.within(
            "contact against stress beside", contact, reference=beside, unit="Pa", relative=0.10,
            source="the same pressure, measured twice; 10 % as for each",
        ),
    )  # fmt: skip
    panels = (
        growth_panel(first, outer, radius, pressure),
        profile_panel(result.final, radius[-1]),
    )
    return CaseReport(comparisons=comparisons, panels=panels)


def expand(first: float, last: float, outer: float, progress: Progress) -> ExperimentResult:
    """An octant of a hollow ball between planes of symmetry, and the sphere that grows in it."""
    experiment = Experiment(grid_spacing=SPACING)
    octant = Block(size=(outer,) * 3, centre=(outer / 2,) * 3)
    experiment.add_body(
        (Ball(radius=outer) - Ball(radius=first)) & octant,
        material=von_mises(DENSITY, YOUNGS_MODULUS, POISSON_RATIO, YIELD_STRESS),
        name="solid",
    )
    for normal in ("x", "y", "z"):
        experiment.add_wall(point=(0.0, 0.0, 0.0), normal=normal, kind="slip")
    experiment.add_rigid_body(
        RigidBody(
            shape=Sphere(first, expansion_speed=GROWTH),
            centre=(0.0, 0.0, 0.0),
            friction=0.0,
            name="ball",
        )
    )
    duration = (last - first) / GROWTH
    return experiment.run(
        until=duration,
        sample_interval=duration / 50,
        snapshot_interval=duration / 50,
        progress=progress,
    )


def cavity_radius(result: ExperimentResult, first: float, outer: float) -> FloatArray:
    """Radius (m,) [m] of the cavity from the volume that it has pushed outwards.

    The solid hardly changes its volume, so r³ - r0³ is that of the cavity, the same for all.
    """
    start = np.linalg.norm(result.final.reference_position, axis=1)
    far = (start > 0.7 * outer) & (start < 0.9 * outer)
    pushed = [
        np.mean(np.linalg.norm(one.position[far], axis=1) ** 3 - start[far] ** 3)
        for one in result.snapshots
    ]
    return np.cbrt(first**3 + np.array(pushed))


def contact_pressure(result: ExperimentResult, radius: FloatArray) -> FloatArray:
    """Normal force of the ball over the area of the octant's cavity (m,) [Pa]."""
    force = np.gradient(result.rigid_body("ball").normal_impulse, result.time)
    pressure: FloatArray = force / (0.5 * np.pi * radius**2)
    return pressure


def wall_pressure(final: Fields, radius: float) -> float:
    """Radial stress [Pa] carried inwards to the cavity through the plastic shell.

    There -sigma_r = p - 2 Y ln(r/a); the mean of p over the particles from 1.2 to 2 radii.
    """
    place, stress = radial_stress(final)
    shell = (place > 1.2 * radius) & (place < 2.0 * radius)
    return float(np.mean(-stress[shell] + 2.0 * YIELD_STRESS * np.log(place[shell] / radius)))


def radial_stress(final: Fields) -> tuple[FloatArray, FloatArray]:
    """Distance (n,) [m] from the centre and sigma_r (n,) [Pa] of all particles."""
    place = np.linalg.norm(final.position, axis=1)
    direction = final.position / place[:, None]
    return place, np.einsum("ni,nij,nj->n", direction, final.stress, direction)


def closed_form(radius: FloatArray, first: float, outer: float) -> FloatArray:
    """Pressure (m,) [Pa] in a ball of finite size, plastic out to the radius c; Hill 1950.

    c³ = (2E/3Y)(a³ - a0³);  p = (2Y/3)(1 + 3 ln(c/a) - c³/b³),  b³ = b0³ + a³ - a0³.
    """
    grown = radius**3 - first**3
    plastic = 2.0 * YOUNGS_MODULUS / (3.0 * YIELD_STRESS) * grown
    ratio = np.maximum(plastic / radius**3, 1.0)
    pressure: FloatArray = (
        2.0 * YIELD_STRESS / 3.0 * (1.0 + np.log(ratio) - plastic / (outer**3 + grown))
    )
    return np.where(plastic > radius**3, pressure, np.nan)


def growth_panel(
    first: float,
    outer: float,
    radius: FloatArray,
    pressure: FloatArray,
) -> Panel:
    """Pressure over the radius of the cavity."""
    fine = np.linspace(1.02 * first, radius[-1], 200)
    return Panel(
        title="pressure on the ball", x="radius of the cavity / cell", y="pressure / MPa",
        curves=(
            Curve(x=radius[1:] / SPACING, y=1e-6 * pressure[1:], label="normal impulse"),
            Curve(
                x=fine / SPACING, y=1e-6 * closed_form(fine, first, outer),
                label="Hill, ball of this size", kind="reference",
            ),
            Curve(
                x=np.array([first, radius[-1]]) / SPACING, y=np.full(2, 1e-6 * LIMIT),
                label="limit", kind="reference",
            ),
        ),
    )  # fmt: skip


def profile_panel(final: Fields, radius: float) -> Panel:
    """Radial stress over the distance from the centre, at the end."""
    place, stress = radial_stress(final)
    edges = np.arange(0.8 * radius, place.max(), 0.5 * SPACING)
    which = np.digitize(place, edges)
    full = [k for k in np.unique(which) if 0 < k < len(edges)]
    middle = np.array([place[which == k].mean() for k in full])
    mean = np.array([stress[which == k].mean() for k in full])
    spread = np.array([stress[which == k].std() for k in full])
    inside = np.linspace(radius, 2.5 * radius, 50)
    plastic = LIMIT - 2.0 * YIELD_STRESS * np.log(inside / radius)
    return Panel(
        title="radial stress at the end", x="distance / cell", y="-sigma_r / MPa",
        curves=(
            Curve(
                x=middle / SPACING, y=-1e-6 * mean, error=1e-6 * spread,
                label="mean over half cells, spread", kind="points",
            ),
            Curve(
                x=inside / SPACING, y=1e-6 * plastic, label="limit - 2 Y ln(r/a)",
                kind="reference",
            ),
        ),
    )  # fmt: skip
