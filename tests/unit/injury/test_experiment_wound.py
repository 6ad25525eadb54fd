"""Tracts, holes, fragments and gradients of experiments, on particles that were moved by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vulnus.core.errors import ScenarioError
from vulnus.injury import (
    Block,
    CavitySensor,
    Experiment,
    ExperimentResult,
    Fields,
    RigidBodyRecord,
    rotation_about,
)

SPACING = 1e-3


def block(size=(0.02, 0.03, 0.03)) -> Fields:
    """A block whose face of entry is at x = 0, particles `SPACING` apart."""
    experiment = Experiment(grid_spacing=2 * SPACING)
    experiment.add_body(
        Block(size=size, centre=(0.5 * size[0], 0, 0)), material="gelatin_10", name="gel"
    )
    return experiment.fields()


def pushed_apart(fields: Fields, radius: float) -> Fields:
    """Everything moved away from the x axis as around a cylinder of this radius, like a fluid."""
    before = fields.position[:, 1:]
    distance = np.linalg.norm(before, axis=1)
    after = before * (np.sqrt(distance**2 + radius**2) / distance)[:, None]
    return replace(fields, position=np.column_stack([fields.position[:, 0], after]))


def flight(length: float, samples: int = 41) -> RigidBodyRecord:
    """A ball of 4 mm radius that leaves 60 J evenly on its way from x = 0 to x = `length`."""
    time = np.linspace(0.0, 1e-4, samples)
    depth = np.linspace(-0.01, length + 0.01, samples)
    zero = np.zeros((samples, 3))
    place = np.column_stack([depth, np.zeros((samples, 2))])
    return RigidBodyRecord(
        name="ball", time=time, mass=1e-3, position=place - [4e-3, 0, 0], foremost=place,
        velocity=zero + [400.0, 0, 0], rotation=np.tile(np.eye(3), (samples, 1, 1)),
        angular_velocity=zero, momentum=zero, angular_momentum=zero, impulse=zero - time[:, None],
        angular_impulse=zero, normal_impulse=time, work=60.0 * np.clip(depth / length, 0.0, 1.0),
        kinetic_energy=time, depth=depth,
    )  # fmt: skip


def result_of(body: RigidBodyRecord, final: Fields, *snapshots: Fields) -> ExperimentResult:
    names = [n for n in RigidBodyRecord.__dataclass_fields__ if n not in ("name", "time")]
    columns = {f"rigid/ball/{name}": getattr(body, name) for name in names}
    columns |= {"time": body.time, "rigid/ball/mass": np.full(len(body.time), body.mass)}
    return ExperimentResult(
        columns=columns, final=final, snapshots=snapshots, steps=1, stopped_early=False
    )


def test_energy_is_left_evenly_and_adds_up_to_all_work():
    deposit = flight(0.02).energy_deposit(interval=4e-3)
    assert deposit.edges[0] == 0.0
    assert deposit.total == pytest.approx(60.0, rel=1e-12)
    # A sample's step of 1 mm is all that the ends are uncertain by.
    assert deposit.energy[:5] == pytest.approx(np.full(5, 12.0), rel=1.1e-3 / 4e-3)


def test_force_is_the_mean_since_the_sample_before():
    body = flight(0.02)
    assert body.force[0] == pytest.approx([0.0, 0.0, 0.0])
    assert body.force[1:] == pytest.approx(np.full((40, 3), -1.0))
    assert body.axis == pytest.approx(np.tile([1.0, 0.0, 0.0], (41, 1)))


def test_a_body_that_touched_nothing_has_no_way():
    body = flight(0.02)
    missed = replace(body, depth=np.full(41, np.nan))
    with pytest.raises(ScenarioError, match="has not touched tissue"):
        missed.energy_deposit()


def test_a_tract_has_the_radii_of_the_cavities_and_ends_at_the_surfaces():
    whole = block()
    final, open_ = pushed_apart(whole, 3e-3), pushed_apart(whole, 6e-3)
    broken = np.where(np.linalg.norm(whole.position[:, 1:], axis=1) < 4e-3, 1.0, 0.0)
    final = replace(final, damage=broken)
    tract = result_of(flight(0.02), final, open_).tract("ball")
    assert tract.points[[0, -1], 0] == pytest.approx([0.0, 0.02], abs=1.6 * SPACING)
    middle = slice(3, -3)  # the cavity fades at its mouths
    assert tract.permanent_radius[middle] == pytest.approx(3e-3, rel=0.15)
    assert tract.temporary_radius[middle] == pytest.approx(6e-3, rel=0.1)
    assert tract.destroyed_radius[middle] == pytest.approx(4e-3, rel=0.1)


@pytest.mark.parametrize("radius", [3e-3, 6e-3, 9e-3])
def test_a_hole_in_a_face_is_measured_at_both_ends(radius):
    holed = pushed_apart(block(), radius)
    for place, normal in (((0, 0, 0), "-x"), ((0.02, 0, 0), "x")):
        area = holed.hole_area(place, normal)
        # The edge is known to half a particle.
        assert area == pytest.approx(np.pi * radius**2, rel=2 * 0.5 * SPACING / radius)


def test_sound_faces_have_no_hole_and_broken_tissue_covers_none():
    whole = block()
    assert whole.hole_area((0, 0, 0), "-x") == 0.0
    beside = np.linalg.norm(whole.position[:, 1:], axis=1)
    broken = replace(whole, damage=np.where(beside < 5e-3, 1.0, 0.0))
    assert broken.hole_area((0, 0, 0), "-x") == pytest.approx(np.pi * 25e-6, rel=0.2)
    with pytest.raises(ScenarioError, match="no tissue lay within"):
        whole.hole_area((0.5, 0, 0), "-x")


def test_fragments_are_what_was_torn_off():
    fields = block(size=(0.02, 0.02, 0.02))
    cube = np.all(fields.position > [0.014, 0.004, 0.004], axis=1)
    flown = replace(fields, position=fields.position + 0.01 * cube[:, None])
    found = flown.fragments()
    assert len(found.fragments) == 1
    assert found.fragments[0].mass == pytest.approx(fields.mass[cube].sum())
    assert found.fragments[0].points == np.count_nonzero(cube)
    assert found.mass == pytest.approx(fields.mass.sum())
    assert found.debris_mass == pytest.approx(0.0, abs=1e-12)


def test_the_gradient_of_a_stretch_and_turn_is_exact():
    fields = block(size=(0.008, 0.008, 0.008))
    gradient = rotation_about("z", 0.7) @ np.array([[1.4, 0.2, 0.0], [0, 0.9, 0], [0, 0, 1.1]])
    moved = replace(fields, position=fields.reference_position @ gradient.T)
    assert moved.deformation_gradient() == pytest.approx(
        np.broadcast_to(gradient, (len(fields), 3, 3)), abs=1e-9
    )


def test_the_mirrored_quarter_is_the_whole():
    whole = pushed_apart(block(), 5e-3)
    whole = replace(whole, velocity=whole.position * 3.0)
    quarter = whole.where((whole.position[:, 1] > 0) & (whole.position[:, 2] > 0))
    again = quarter.mirrored((0, 0, 0), "y").mirrored((0, 0, 0), "z")
    order, same = (np.lexsort(np.round(f.position, 9).T) for f in (whole, again))
    assert again.position[same] == pytest.approx(whole.position[order], abs=1e-12)
    assert again.velocity[same] == pytest.approx(whole.velocity[order], abs=1e-9)
    assert again.mass.sum() == pytest.approx(whole.mass.sum())
    assert again.cavity_volume() == pytest.approx(whole.cavity_volume(), rel=1e-6)


def test_a_cavity_sensor_of_a_quarter_counts_the_whole_hole():
    hollow = Block(size=(0.02, 0.02, 0.02)) - Block(size=(0.008, 0.008, 0.008))
    quarter = hollow & Block(size=(0.02, 0.01, 0.01), centre=(0, 0.005, 0.005))
    volumes = []
    for solid, planes in ((hollow, ()), (quarter, (((0, 0, 0), "y"), ((0, 0, 0), "z")))):
        experiment = Experiment(grid_spacing=2e-3)
        experiment.add_body(solid, material="gelatin_10")
        experiment.add_sensor(CavitySensor(name="hole", symmetry=planes))
        volumes.append(experiment.run(until=1e-7).sensor("hole")["volume"][0])
    assert volumes[0] == pytest.approx(0.008**3, rel=0.1)
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-3)


@pytest.mark.parametrize("planes", [("x",), ((0, 0, 0), "x"), (((0, 0), "x"),), (1,)])
def test_planes_that_are_none_are_refused(planes):
    with pytest.raises(ScenarioError):
        CavitySensor(symmetry=planes)


def test_few_particles_have_no_gradient_and_no_fragments():
    fields = block(size=(0.008, 0.008, 0.008))
    for count in (0, 1):
        few = fields.where(np.arange(len(fields)) < count)
        assert np.isnan(few.deformation_gradient()).all()
        assert few.fragments().fragments == ()
