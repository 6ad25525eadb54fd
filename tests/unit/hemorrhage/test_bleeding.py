"""The bleeding limb as a whole: preparation, ledger, frames, resume, threads, faults."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from reference.sph_limb import RADIUS

from vulnus.core.errors import AnatomyError, UnstableStepError
from vulnus.hemorrhage import HemorrhageParameters, prepare

PARAMETERS = HemorrhageParameters(particle_spacing=2e-3, sound_speed=15.0, threads=1)
FLOW = (np.array([0.0, 0.05, 1.0]), np.array([2e-5, 4e-5, 4e-5]))


@pytest.fixture(scope="module")
def bled(open_wound):
    """0.2 s of a fast bleeding: the tract is full and runs over."""
    solver = prepare(open_wound, PARAMETERS)
    solver.advance(0.2, FLOW)
    return solver


def moved_wound(wound, place):
    injury = dataclasses.replace(wound.injuries[0], position=place)
    return dataclasses.replace(wound, injuries=(injury,))


def same_bits(one, other):
    first, second = one.state(), other.state()
    return first.keys() == second.keys() and all(
        np.array_equal(first[name], second[name]) for name in first
    )


def test_no_cut_artery_is_refused(open_wound):
    with pytest.raises(AnatomyError, match="no artery is cut"):
        prepare(dataclasses.replace(open_wound, injuries=()), PARAMETERS)


def test_source_outside_the_limb_is_refused(open_wound):
    with pytest.raises(AnatomyError, match="outside the limb"):
        prepare(moved_wound(open_wound, (RADIUS + 0.01, 0.0, 0.0)), PARAMETERS)


def test_source_at_the_bones_edge_is_moved_out(open_wound):
    solver = prepare(moved_wound(open_wound, (0.0, 6e-3, 0.0)), PARAMETERS)
    assert 0.0 < np.linalg.norm(solver.origin - [0.0, 6e-3, 0.0]) <= 10e-3


def test_ledger_closes(bled):
    """Volumes are counted, not measured: they agree to the rounding of the sum."""
    v = bled.volumes()
    held = v.in_limb + v.out_of_limb + v.removed + v.pending
    assert v.injected == pytest.approx(held, rel=1e-12)
    fine = np.linspace(0.0, 0.2, 20001)
    assert v.injected == pytest.approx(np.trapezoid(np.interp(fine, *FLOW), fine), rel=1e-3)


def test_blood_leaves_through_the_wound_only(bled):
    """No crossing; whatever is outside came through the tract's ends."""
    assert bled.barrier_crossings == 0
    volumes = bled.volumes()
    assert volumes.out_of_limb + volumes.removed > 0.0
    position = bled.position
    side = np.hypot(position[:, 0], position[:, 1]) > RADIUS + 2e-3
    assert np.abs(position[side, 0]).min() > 0.02


def test_frame_is_ordered_and_complete(bled):
    frame = bled.frame(7)
    assert frame.index == 7
    assert frame.time == bled.time
    assert frame.position.dtype == np.float32
    assert set(frame.point_data) == {"velocity_m_per_s", "pressure_pa", "id", "in_limb"}
    assert np.all(np.diff(frame.point_data["id"]) > 0)
    assert frame.point_data["velocity_m_per_s"].shape == (bled.particle_count, 3)


def test_resumed_run_is_the_same_to_the_bit(open_wound):
    whole = prepare(open_wound, PARAMETERS)
    whole.advance(0.03, FLOW)
    kept = whole.state()
    whole.advance(0.06, FLOW)
    resumed = prepare(open_wound, PARAMETERS)
    resumed.restore(kept)
    resumed.advance(0.06, FLOW)
    assert same_bits(whole, resumed)
    assert whole.pressure_injury == resumed.pressure_injury


def test_one_and_two_threads_give_the_same_bits(open_wound):
    runs = []
    for threads in (1, 2):
        solver = prepare(open_wound, dataclasses.replace(PARAMETERS, threads=threads))
        rng = np.random.default_rng(1)
        start = rng.uniform(-1.0, 1.0, (1500, 3)) * [25e-3, 3e-3, 3e-3] + [0.0, -8e-3, 0.0]
        solver.native.add_particles(solver.local(start[::2]), np.zeros((750, 3)))
        solver.native.add_particles(solver.local(start[1::2]), np.zeros((750, 3)))
        solver.step_chunk(1.0, FLOW, step_limit=100, wall_time=60.0)
        runs.append(solver)
    assert runs[0].particle_count > 1000
    assert same_bits(*runs)


def test_chunks_do_not_change_the_result(open_wound):
    """Where wall time cuts a run into native calls is not part of the physics."""
    one = prepare(open_wound, PARAMETERS)
    one.advance(0.01, FLOW)
    other = prepare(open_wound, PARAMETERS)
    while not other.step_chunk(0.01, FLOW, step_limit=7):
        pass
    assert same_bits(one, other)


def test_fault_names_particle_place_and_time(open_wound):
    solver = prepare(open_wound, PARAMETERS)
    solver.advance(0.01, FLOW)
    kept = dict(solver.state())
    speed = np.array(kept["vx"])
    speed[3] = np.nan
    kept["vx"] = speed
    solver.restore(kept)
    with pytest.raises(UnstableStepError, match=r"particle \d+, .* mm, t = 0\.01"):
        solver.advance(0.02, FLOW)


def test_pressure_rises_in_a_closed_pocket(closed_wound):
    """A tract without holes fills; then the pressure around the source rises far above weight."""
    solver = prepare(closed_wound, PARAMETERS)
    solver.advance(0.05, (np.array([0.0]), np.array([4e-5])))
    early = solver.pressure_injury
    solver.advance(0.25, (np.array([0.0]), np.array([4e-5])))
    assert early < 500.0
    assert solver.pressure_injury > 1000.0
    assert solver.volumes().out_of_limb == 0.0


@pytest.mark.parametrize(
    "change",
    [
        {"as_printed": True},
        {"pressure_model": "unclamped"},
        {"kernels": "mueller2003"},
        {"barrier_model": "presence"},
        {"permeability_model": "constant"},
    ],
)
def test_every_option_bleeds(open_wound, change):
    """Each option runs for 0.05 s and closes the ledger."""
    solver = prepare(open_wound, dataclasses.replace(PARAMETERS, **change))
    solver.advance(0.05, FLOW)
    v = solver.volumes()
    assert v.injected == pytest.approx(v.in_limb + v.out_of_limb + v.removed + v.pending)
    assert solver.particle_count > 10
