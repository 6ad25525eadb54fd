"""M5: return maps of a single material point against closed forms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.progress import Progress
from vulnus.injury.material_point import (
    material_point,
    pure_shear,
    simple_shear,
    uniaxial_strain,
)
from vulnus.injury.materials import MATERIALS, drucker_prager, neo_hookean
from vulnus.validation import CaseReport, Comparison

TOLERANCE = 1e-8  # PHYSICS M5
CONSISTENCY = 1e-10  # PHYSICS M5, over the slope 3 mu
CLOSED_FORM = "closed form, README (PHYSICS M5)"
DURATION = 1.0  # [s]: none of the closed forms has a rate in it
COPPER = MATERIALS["copper"]
BONE = MATERIALS["cortical_bone"]
ROCK = drucker_prager(2600.0, 20e9, 0.25, 30e6, 0.8)  # [chosen: round numbers]
GEL = neo_hookean(1000.0, 50e3, 2e6)  # [chosen: round numbers]
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
            f"{self.name}: relative error", error, limit=TOLERANCE, unit="1", source=CLOSED_FORM
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
        Agreement("simple shear in one step, plastic strain", step.plastic_strain[-1], plastic_step),
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
    path = shear_after_volume(volume)
    point = material_point(ROCK, path, duration=DURATION)
    pressure = np.maximum(-ROCK.bulk_modulus * volume, -yield_stress / friction)
    q = np.maximum(yield_stress + friction * pressure, 0.0)
    mean = -np.trace(point.kirchhoff[-1], axis1=1, axis2=2) / 3.0
    tip = Agreement("Drucker-Prager tip, pressure", mean[2:], pressure[2:])
    return [
        Agreement("Drucker-Prager cone, equivalent stress", point.von_mises_stress[-1, :2], q[:2]),
        Agreement("Drucker-Prager tip, q + Y", point.von_mises_stress[-1, 2:] + yield_stress, q[2:] + yield_stress),
        tip,
        Agreement(
            "Drucker-Prager tip, volume of the voids",
            point.opening[-1, 2:],
            volume[2:] - yield_stress / (friction * ROCK.bulk_modulus),
        ),
    ]
