"""What is read of bodies and particles after a run agrees with what is known otherwise."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury import (
    PROJECTILES,
    Block,
    Cylinder,
    Experiment,
    ExperimentResult,
    RigidBody,
    attitude,
    elastic,
)

SOLID = elastic(1000.0, 1e6, 0.3)


@pytest.fixture(scope="module")
def struck() -> ExperimentResult:
    """A slug that lies askew hits a soft block beside its middle."""
    experiment = Experiment(grid_spacing=2e-3, precision="float64")
    experiment.add_body(Block(size=(0.016, 0.024, 0.024)), material=SOLID, name="block")
    turned = attitude((1, 0, 0), yaw=0.3)
    experiment.add_rigid_body(
        RigidBody(
            shape=Cylinder(5e-3, 0.014), centre=(-0.018, 4e-3, 0), velocity=(20.0, 0, 0),
            rotation=turned, angular_velocity=tuple(300.0 * turned[:, 0]), mass=4e-3,
            motion="dynamic", name="slug",
        )
    )  # fmt: skip
    return experiment.run(until=3e-4, sample_interval=2e-5)


def test_impulses_are_what_momenta_have_gained(struck):
    slug = struck.rigid_body("slug")
    assert slug.mass == 4e-3
    gained = slug.momentum - slug.momentum[0]
    assert gained == pytest.approx(slug.impulse, abs=1e-10 * np.abs(slug.momentum).max())
    turned = slug.angular_momentum - slug.angular_momentum[0]
    assert np.abs(slug.angular_impulse[-1]).max() > 1e-6  # it was hit beside its middle
    assert turned == pytest.approx(
        slug.angular_impulse, abs=1e-10 * np.abs(slug.angular_momentum).max()
    )
    assert (slug.force[1:] * np.diff(slug.time)[:, None]).sum(axis=0) == pytest.approx(
        slug.impulse[-1]
    )
    assert (slug.torque[1:] * np.diff(slug.time)[:, None]).sum(axis=0) == pytest.approx(
        slug.angular_impulse[-1]
    )


def test_what_is_missing_of_the_energy_is_dissipated(struck):
    energy = struck.energies
    assert energy["dissipated"] == pytest.approx(energy["total"][0] - energy["total"], abs=1e-12)
    # Contact and the scheme take energy, and can never give any.
    assert energy["dissipated"].min() > -1e-9 * energy["total"][0]
    assert energy["dissipated"][-1] > 0.0


def test_the_stress_is_that_of_the_elastic_strain(struck):
    fields = struck.final
    strain = fields.elastic_strain
    trace = np.trace(strain, axis1=1, axis2=2)
    deviator = strain - trace[:, None, None] / 3.0 * np.eye(3)
    kirchhoff = 2.0 * SOLID.shear_modulus * deviator
    kirchhoff += SOLID.bulk_modulus * trace[:, None, None] * np.eye(3)
    largest = np.abs(fields.stress).max()
    assert fields.stress == pytest.approx(
        kirchhoff / fields.volume_ratio[:, None, None], abs=1e-9 * largest
    )


def test_neighbours_tell_the_deformation_that_the_law_works_with(struck):
    """Away from faces, over a cell or so: the two differ by what varies within a cell."""
    fields = struck.final
    inner = np.all(np.abs(fields.reference_position) < [4e-3, 8e-3, 8e-3], axis=1)
    gradient = fields.deformation_gradient()[inner]
    left = gradient @ gradient.transpose(0, 2, 1)
    wanted = fields.elastic_left_cauchy_green[inner]
    spread = np.abs(wanted - np.eye(3)).max()
    assert spread > 0.01
    assert np.abs(left - wanted).mean() < 0.05 * spread


def test_a_blade_is_rolled_about_its_flight():
    knife = PROJECTILES["knife"]
    for roll, width in ((0.0, [0, 0, 1]), (90.0, [0, -1, 0])):
        experiment = Experiment(grid_spacing=4e-3)
        experiment.add_body(Block(size=(0.02, 0.02, 0.02)), material=SOLID)
        experiment.add_projectile(
            knife, speed=5.0, direction="x", target=(0, 0, 0), roll_degrees=roll, name="knife"
        )
        body = experiment.rigid_body("knife")
        assert body.rotation[:, 0] == pytest.approx([1, 0, 0], abs=1e-12)
        assert body.rotation[:, 2] == pytest.approx(width, abs=1e-12)
