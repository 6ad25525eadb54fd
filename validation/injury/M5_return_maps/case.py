"""M5: return maps of a single material point against closed forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from vulnus.core.arrays import FloatArray
from vulnus.core.progress import Progress
from vulnus.injury.bodies.rotations import rotation_about
from vulnus.injury.material_point import (
    MaterialPointHistory,
    material_point,
    pure_shear,
    simple_shear,
    tensile_test,
    uniaxial_strain,
    volumetric_strain,
)
from vulnus.injury.materials import MATERIALS, Material, drucker_prager, neo_hookean
from vulnus.validation import CaseReport, Comparison, Curve, Panel

TOLERANCE = 1e-8  # PHYSICS M5
CONSISTENCY = 1e-10  # PHYSICS M5, over the slope 3 mu
CLOSED_FORM = "closed form, README (PHYSICS M5)"
DURATION = 1.0  # [s]: none of the closed forms has a rate in it
COPPER = MATERIALS["copper"]
ROCK = drucker_prager(2600.0, 20e9, 0.25, 30e6, 0.8)  # [chosen: round numbers]
GEL = neo_hookean(1000.0, 50e3, 2e6)  # [chosen: round numbers]
RATELESS = ("copper", "cortical_bone", "cancellous_bone", "skin", "artery")
RANDOM_PATHS = 200


@dataclass(frozen=True)
class Agreement:
    """A closed form beside what the law gives; the worst of all entries counts."""

    name: str
    value: FloatArray
    expected: FloatArray

    def comparison(self) -> Comparison:
        """Largest difference over the largest expected entry."""
        value, expected = np.asarray(self.value), np.asarray(self.expected)
        error = np.max(np.abs(value - expected)) / np.max(np.abs(expected))
        return Comparison.at_most(
            self.name, error, limit=TOLERANCE, unit="rel. error", source=CLOSED_FORM
        )


def run(quick: bool, progress: Progress) -> CaseReport:  # noqa: ARG001  takes a second either way
    """All closed forms; the quick version is the whole one."""
    progress.begin("return maps", 4, "groups")
    agreements = [*von_mises_forms(), *drucker_prager_forms()]
    progress.update(1)
    agreements += [*pressure_forms(), *network_forms()]
    progress.update(2)
    comparisons = [agreement.comparison() for agreement in agreements]
    comparisons += random_paths()
    progress.update(3)
    panels = (shear_panel(), tension_panel(), cone_panel())
    progress.end()
    return CaseReport(comparisons=tuple(comparisons), panels=panels)


def von_mises_forms() -> list[Agreement]:
    """Copper: uniaxial strain, pure shear and one step of simple shear, hardening included."""
    mu, bulk, slope = COPPER.shear_modulus, COPPER.bulk_modulus, COPPER.hardening
    strain = np.linspace(0.0, 0.1, 41)
    uniaxial = material_point(COPPER, uniaxial_strain(np.exp(strain)), duration=DURATION)
    plastic = flow(2.0 * mu * strain)
    q = np.minimum(2.0 * mu * strain, COPPER.yield_stress + slope * plastic)
    axial = bulk * strain + 2.0 / 3.0 * q

    pure = material_point(COPPER, pure_shear(strain), duration=DURATION)
    q_pure = 2.0 * np.sqrt(3.0) * mu * strain
    plastic_pure = flow(q_pure)

    gamma = 0.2
    step = material_point(COPPER, simple_shear([0.0, gamma]), duration=DURATION)
    trial, angle = simple_shear_kirchhoff(gamma)
    plastic_step = flow(np.sqrt(3.0) * trial)
    shear = (COPPER.yield_stress + slope * plastic_step) / np.sqrt(3.0)
    return [
        Agreement("uniaxial strain, plastic strain", uniaxial.plastic_strain, plastic),
        Agreement("uniaxial strain, axial stress", uniaxial.kirchhoff[:, 0, 0], axial),
        Agreement("pure shear, plastic strain", pure.plastic_strain, plastic_pure),
        Agreement(
            "pure shear, equivalent stress",
            pure.von_mises_stress,
            np.minimum(q_pure, COPPER.yield_stress + slope * plastic_pure),
        ),
        Agreement("simple shear in one step, stress xy", step.kirchhoff[-1, 0, 1], shear * angle),
        Agreement(
            "simple shear in one step, plastic strain", step.plastic_strain[-1], plastic_step
        ),
    ]


def flow(q_trial: FloatArray) -> FloatArray:
    """Plastic strain of a radial path: q_trial - 3 mu alpha = Y + H alpha."""
    alpha = (q_trial - COPPER.yield_stress) / (3.0 * COPPER.shear_modulus + COPPER.hardening)
    return np.maximum(alpha, 0.0)


def simple_shear_kirchhoff(gamma: float) -> tuple[float, float]:
    """Hencky solid under simple shear: size of the principal stresses, and sin 2 theta.

    The principal stretches are exp(±asinh(gamma/2)); tan 2 theta = 2/gamma.
    """
    size = 2.0 * COPPER.shear_modulus * np.arcsinh(gamma / 2.0)
    return float(size), float(1.0 / np.sqrt(1.0 + gamma**2 / 4.0))


def drucker_prager_forms() -> list[Agreement]:
    """Sheared rock under three pressures: the cone, and its tip beyond the apex."""
    yield_stress, friction = ROCK.yield_stress, ROCK.friction
    volume = np.array([-0.02, -0.002, 0.02])  # tr(eps): far and little compressed, and torn
    turned = np.tile(np.diag(np.exp([0.02, -0.02, 0.0])), (3, 1, 1))
    path = np.stack([np.tile(np.eye(3), (3, 1, 1)), turned * np.exp(volume / 3.0)[:, None, None]])
    point = material_point(ROCK, path, duration=DURATION)
    pressure = np.maximum(-ROCK.bulk_modulus * volume, -yield_stress / friction)
    strength = np.maximum(yield_stress + friction * pressure, 0.0)
    q = point.von_mises_stress[-1]
    mean = -np.trace(point.kirchhoff[-1], axis1=1, axis2=2) / 3.0
    voids = volume[2:] - yield_stress / (friction * ROCK.bulk_modulus)
    return [
        Agreement("Drucker-Prager cone, equivalent stress", q[:2], strength[:2]),
        Agreement("Drucker-Prager tip, Y + q", yield_stress + q[2:], yield_stress + strength[2:]),
        Agreement("Drucker-Prager tip, pressure", mean[2:], pressure[2:]),
        Agreement("Drucker-Prager tip, volume of voids", point.opening[-1, 2:], voids),
    ]


def pressure_forms() -> list[Agreement]:
    """Tait's law with its cut-off (gelatin), and one crack of a brittle solid."""
    gelatin = MATERIALS["gelatin_10"]
    ratio = np.linspace(1.0, 0.9, 21)
    squeezed = material_point(gelatin, volumetric_strain(ratio), duration=DURATION)
    tait = gelatin.bulk_modulus / 7.0 * (ratio**-7 - 1.0)
    torn = material_point(gelatin, volumetric_strain([1.0, 1.1]), duration=DURATION)
    share = gelatin.pressure_cutoff / gelatin.bulk_modulus
    cut = np.log(brentq(lambda j: (j - j**-6) / 7.0 - share, 1.0, 1.1, xtol=1e-15))

    glass = Material(
        density=2500.0, bulk_modulus=40e9, shear_modulus=30e9, tensile_strength=50e6
    )  # [chosen: round numbers]
    axial = np.array([0.0, 2e-3, 4e-3])
    cracked = material_point(glass, uniaxial_strain(np.exp(axial)), duration=DURATION)
    modulus = glass.bulk_modulus + 4.0 / 3.0 * glass.shear_modulus
    return [
        Agreement("Tait's law, pressure", squeezed.pressure, tait),
        Agreement("cavitation, volume of voids", torn.opening[-1], np.log(1.1) - cut),
        Agreement("Rankine, largest stress", cracked.kirchhoff[-1, 0, 0], glass.tensile_strength),
        Agreement(
            "Rankine, strain of the crack",
            cracked.opening,
            np.maximum(axial - glass.tensile_strength / modulus, 0.0),
        ),
    ]


def network_forms() -> list[Agreement]:
    """Neo-Hookean solid under uniaxial strain; the network of skin under uniaxial stress."""
    stretch = np.linspace(1.0, 1.5, 26)
    point = material_point(GEL, uniaxial_strain(stretch), duration=DURATION)
    deviator = 2.0 / 3.0 * GEL.network_modulus * stretch ** (-2.0 / 3.0) * (stretch**2 - 1.0)
    axial = deviator + 0.5 * GEL.bulk_modulus * (stretch**2 - 1.0)

    skin = MATERIALS["skin"]
    test = tensile_test(skin, stretch, rate=1.0)
    return [
        Agreement("neo-Hookean uniaxial strain, axial stress", point.kirchhoff[:, 0, 0], axial),
        Agreement("skin, uniaxial stress", test.kirchhoff[:, 0, 0], demiray(skin, test)),
    ]


def demiray(skin: Material, test: MaterialPointHistory) -> FloatArray:
    """tau_1 - tau_2 = mu exp(beta (I - 3)) J^(-2/3) (s_1² - s_2²), with tau_2 = 0."""
    scale = test.volume_ratio ** (-2.0 / 3.0)
    squares = np.einsum("mii->mi", test.deformation) ** 2
    excess = scale * squares.sum(axis=1) - 3.0
    stiffened = skin.network_modulus * np.exp(skin.network_stiffening * excess)
    stress: FloatArray = stiffened * scale * (squares[:, 0] - squares[:, 1])
    return stress


def random_paths() -> list[Comparison]:
    """What must hold on every path: the yield condition, plastic work and frame indifference."""
    path = random_deformation()
    copper = material_point(COPPER, path, duration=DURATION)
    rock = material_point(ROCK, path, duration=DURATION)
    copper_limit = COPPER.yield_stress + COPPER.hardening * copper.plastic_strain
    pressure = -np.trace(rock.kirchhoff, axis1=-2, axis2=-1) / 3.0
    rock_limit = np.maximum(ROCK.yield_stress + ROCK.friction * pressure, 0.0)
    rows = [
        ("copper", (copper.von_mises_stress - copper_limit) / (3.0 * COPPER.shear_modulus)),
        ("rock", (rock.von_mises_stress - rock_limit) / (3.0 * ROCK.shear_modulus)),
    ]
    comparisons = [
        Comparison.at_most(
            f"{name}: yield condition over 3 mu",
            np.max(excess),
            limit=CONSISTENCY,
            unit="1",
            source="PHYSICS M5",
        )
        for name, excess in rows
    ]
    least = min(least_work(name, path) for name in MATERIALS)
    worst = max(turned_error(name, path, spinning=False) for name in MATERIALS)
    spun = max(turned_error(name, path, spinning=True) for name in RATELESS)
    return [
        *comparisons,
        Comparison.at_least(
            "least plastic work of a step",
            least,
            limit=-TOLERANCE,
            unit="of the whole",
            source="PHYSICS M5",
        ),
        Comparison.at_most(
            "turned setup, stress of all materials",
            worst,
            limit=TOLERANCE,
            unit="rel. error",
            source="PHYSICS M5",
        ),
        Comparison.at_most(
            "spinning frame, stress of rateless materials",
            spun,
            limit=TOLERANCE,
            unit="rel. error",
            source="PHYSICS M5",
        ),
    ]


def random_deformation() -> FloatArray:
    """Paths (6, n, 3, 3) of five steps with strains of some per cent each."""
    rng = np.random.default_rng(5)
    path = [np.tile(np.eye(3), (RANDOM_PATHS, 1, 1))]
    for _ in range(5):
        path.append((np.eye(3) + rng.normal(0.0, 0.04, (RANDOM_PATHS, 3, 3))) @ path[-1])
    return np.array(path)


def least_work(name: str, path: FloatArray) -> float:
    """Least plastic work of any step over the greatest of any path."""
    work = material_point(name, path, duration=DURATION).plastic_work
    return float(np.min(np.diff(work, axis=0)) / max(np.max(work), 1.0))


def turned_error(name: str, path: FloatArray, *, spinning: bool) -> float:
    """Stress of the turned path against the turned stress, over the greatest stress.

    The whole setup stands turned, or the frame turns by 20 degrees more in every step.
    """
    angle = np.radians(20.0) * np.arange(len(path)) if spinning else np.ones(len(path))
    turn = np.array([rotation_about((1.0, 2.0, 3.0), a) for a in angle])[:, None]
    back = np.eye(3) if spinning else turn.swapaxes(-1, -2)
    still = material_point(name, path, duration=DURATION).kirchhoff
    turned = material_point(name, turn @ path @ back, duration=DURATION).kirchhoff
    expected = turn @ still @ turn.swapaxes(-1, -2)
    return float(np.max(np.abs(turned - expected)) / np.max(np.abs(expected)))


def shear_panel() -> Panel:
    """Copper under pure shear."""
    strain = np.linspace(0.0, 0.02, 41)
    point = material_point(COPPER, pure_shear(strain), duration=DURATION)
    trial = 2.0 * np.sqrt(3.0) * COPPER.shear_modulus * strain
    q = np.minimum(trial, COPPER.yield_stress + COPPER.hardening * flow(trial))
    return Panel(
        title="Copper, pure shear",
        x="Hencky strain (%)",
        y="equivalent stress (MPa)",
        curves=(
            Curve(
                x=1e2 * strain, y=point.von_mises_stress / 1e6, label="return map", kind="points"
            ),
            Curve(x=1e2 * strain, y=q / 1e6, label="closed form", kind="reference"),
        ),
    )


def tension_panel() -> Panel:
    """Skin under uniaxial stress, with its failure."""
    stretch = np.linspace(1.0, 2.0, 201)
    skin = MATERIALS["skin"]
    test = tensile_test(skin, stretch, rate=1.0, grid_spacing=2e-3)
    whole = stretch <= skin.failure_stretch
    return Panel(
        title="Skin, uniaxial stress (cell 2 mm)",
        x="stretch (1)",
        y="nominal stress (MPa)",
        curves=(
            Curve(x=stretch, y=test.nominal_stress / 1e6, label="return map"),
            Curve(
                x=stretch[whole],
                y=demiray(skin, test)[whole] / stretch[whole] / 1e6,
                label="Demiray's law, intact",
                kind="reference",
            ),
            Curve(
                x=np.array([1.54]),
                y=np.array([21.6]),
                error=np.array([8.4]),
                label="Ní Annaidh 2012, strength",
                kind="reference points",
            ),
        ),
    )


def cone_panel() -> Panel:
    """Where random paths of rock end."""
    rock = material_point(ROCK, random_deformation(), duration=DURATION)
    pressure = -np.trace(rock.kirchhoff[-1], axis1=-2, axis2=-1) / 3.0
    line = np.linspace(-ROCK.yield_stress / ROCK.friction, 1e9, 3)
    shown = pressure <= 1e9
    return Panel(
        title="Rock, 200 random paths",
        x="pressure (MPa)",
        y="equivalent stress (MPa)",
        curves=(
            Curve(
                x=pressure[shown] / 1e6,
                y=rock.von_mises_stress[-1, shown] / 1e6,
                label="return map",
                kind="points",
            ),
            Curve(
                x=line / 1e6,
                y=(ROCK.yield_stress + ROCK.friction * line) / 1e6,
                label="Drucker-Prager",
                kind="reference",
            ),
        ),
    )
