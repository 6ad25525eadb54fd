"""The same shot gives the same bits: with 1 and 2 threads, in one go and resumed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference.mpm_limb import synthetic_limb
from reference.same_bits import MemoryCheckpoint, assert_same_bits

from vulnus.core.errors import StorageError
from vulnus.injury import AimParameters, InjuryParameters, ProjectileParameters, shoot
from vulnus.injury.parameters import ShotParameters

pytestmark = pytest.mark.physics

PARAMETERS = InjuryParameters(
    projectile=ProjectileParameters(diameter=0.008, speed=300.0),
    aim=AimParameters(artery="anterior_tibial", fraction=0.5),
    grid_spacing=0.004,
    duration=8e-5,
    frame_interval=2e-5,
    window_length=0.05,
    bone_modulus_scale=1.0,
    threads=1,
)


@pytest.fixture(scope="module")
def limb():
    return synthetic_limb(spacing=0.002, length=0.07)


@pytest.fixture(scope="module")
def reference_run(limb):
    frames = []
    return shoot(limb, PARAMETERS, on_frame=frames.append), frames


def test_two_threads_give_the_bits_of_one(limb, reference_run):
    wound = shoot(limb, replace(PARAMETERS, threads=2))
    assert_same_bits(wound, reference_run[0])
    assert np.any(wound.permanent.damage > 0)


def test_a_killed_run_resumes_to_the_same_bits_and_frames(limb, reference_run):
    first, second = [], []
    checkpoint = MemoryCheckpoint(stop_after=3)
    with pytest.raises(KeyboardInterrupt):
        shoot(limb, PARAMETERS, on_frame=first.append, checkpoint=checkpoint)
    resumed = MemoryCheckpoint(newest=checkpoint.saved[-1])
    wound = shoot(limb, PARAMETERS, on_frame=second.append, checkpoint=resumed)
    assert 0.0 < checkpoint.saved[-1]["time"] < PARAMETERS.duration
    assert_same_bits(wound, reference_run[0])
    both = {frame.index: frame for frame in [*first, *second]}
    assert sorted(both) == [frame.index for frame in reference_run[1]] == [0, 1, 2, 3, 4]
    for frame in reference_run[1]:
        assert frame.time == both[frame.index].time
        assert np.array_equal(frame.position, both[frame.index].position)
        for name, values in frame.point_data.items():
            assert np.array_equal(values, both[frame.index].point_data[name]), name


@pytest.mark.parametrize("saves", [2, 5])
def test_a_run_killed_in_either_phase_resumes_to_the_same_bits(limb, saves):
    """Two slow dynamic balls: the second phase begins at 0.1 of 1.6 ms; killed before and after."""
    ball = ProjectileParameters(diameter=0.008, speed=25.0, motion="dynamic", mass=0.002)
    parameters = replace(
        PARAMETERS,
        projectile=ball,
        duration=1.6e-3,
        phase_one=1e-4,
        frame_interval=1e-4,
        relaxation_frame_interval=7.5e-4,
        other_shots=(ShotParameters(projectile=ball, aim=AimParameters(target=(0.0, 0.0, 0.01))),),
    )
    whole = shoot(limb, parameters)
    assert 0 < whole.report.flight_steps < whole.report.steps
    checkpoint = MemoryCheckpoint(stop_after=saves)
    with pytest.raises(KeyboardInterrupt):
        shoot(limb, parameters, checkpoint=checkpoint)
    newest = checkpoint.saved[-1]
    assert bool(newest["record.relaxed"]) == (saves == 5)
    assert_same_bits(shoot(limb, parameters, checkpoint=MemoryCheckpoint(newest=newest)), whole)


def test_a_checkpoint_of_another_limb_is_refused(limb):
    checkpoint = MemoryCheckpoint(stop_after=1)
    with pytest.raises(KeyboardInterrupt):
        shoot(limb, PARAMETERS, checkpoint=checkpoint)
    other = synthetic_limb(spacing=0.0025, length=0.07)
    with pytest.raises(StorageError, match="particles"):
        shoot(other, PARAMETERS, checkpoint=MemoryCheckpoint(newest=checkpoint.saved[0]))


def test_different_shots_differ(limb, reference_run):
    """The comparison of bits can fail: 1 m/s more is seen."""
    faster = replace(PARAMETERS, projectile=ProjectileParameters(diameter=0.008, speed=301.0))
    assert not np.array_equal(
        shoot(limb, faster).permanent.position, reference_run[0].permanent.position
    )
