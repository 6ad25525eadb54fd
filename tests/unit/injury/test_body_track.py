"""A track is what was noted, and its foremost point stops where the projectile does."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vulnus.injury.bodies.drawn_shapes import BladeShape, Cylinder
from vulnus.injury.bodies.flight import Outline
from vulnus.injury.bodies.shapes import Sphere
from vulnus.injury.wound.body_track import BodyTrack
from vulnus.injury.wound.tract import energy_along

AHEAD = np.array([1.0, 0.0, 0.0])


def track(places, velocities, *, work=None, turns=None) -> BodyTrack:
    made = BodyTrack()
    for number, (place, velocity) in enumerate(zip(places, velocities, strict=True)):
        body = SimpleNamespace(
            position=np.array(place, np.float64),
            velocity=np.array(velocity, np.float64),
            rotation=np.eye(3) if turns is None else turns[number],
            work=0.0 if work is None else work[number],
        )
        made.note(1e-3 * number, body)
    return made


def along(x, speed, **more) -> BodyTrack:
    return track([(v, 0.0, 0.0) for v in x], [(v, 0.0, 0.0) for v in speed], **more)


def test_the_foremost_point_of_a_ball_is_a_radius_ahead_of_its_way():
    way = [(0.0, 0.0, 0.0), (0.01, 0.0, 0.0), (0.01, 0.01, 0.0)]
    turned = track(way, [(10.0, 0.0, 0.0), (10.0, 0.0, 0.0), (0.0, 10.0, 0.0)])
    path = turned.foremost(Outline.of(Sphere(0.004)), AHEAD)
    assert path.position[:2, 0] == pytest.approx([0.004, 0.014])
    assert path.position[2] == pytest.approx((0.01, 0.014, 0.0))
    assert turned.middle.position == pytest.approx(np.array(way))


def test_a_cylinder_that_tumbles_reaches_less_far_ahead():
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turned = along([0.0, 0.01], [50.0, 50.0], turns=[np.eye(3), quarter])
    path = turned.foremost(Outline.of(Cylinder(0.002, 0.012)), AHEAD)
    # To a tenth of a millimetre: its outline is sampled.
    assert path.position[:, 0] == pytest.approx([0.006, 0.01 + 0.002], abs=3e-4)


def test_what_tissue_does_to_a_ball_at_rest_is_no_tract():
    moved = along(
        [0.0, 0.02, 0.03, 0.026, 0.03], [200.0, 50.0, 0.5, -3.0, 2.0], work=[0, 5, 6, 6.5, 7]
    )
    path = moved.foremost(Outline.of(Sphere(0.004)), AHEAD)
    assert path.position[:, 0] == pytest.approx([0.004, 0.024, 0.024, 0.024, 0.024])
    assert path.speed.tolist() == [200.0, 50.0, 0.0, 0.0, 0.0]
    assert energy_along(path).total == pytest.approx(7.0)


def test_a_blade_s_way_is_that_of_its_tip_to_where_it_is_deepest():
    """Its velocity is not known before the first step; the work on the way out counts too."""
    stab = along(
        [0.0, 0.03, 0.06, 0.03, 0.0], [0.0, 12.0, 12.0, -12.0, -12.0], work=[0, 4, 8, 9, 10]
    )
    blade = BladeShape(0.12, 0.02, 0.002, 0.02)
    path = stab.foremost(Outline.of(blade), AHEAD)
    assert path.arc_length[-1] == pytest.approx(0.06)
    assert path.position[-1, 0] == pytest.approx(0.06 + blade.upper[0], abs=1e-3)
    deposit = energy_along(path)
    assert deposit.total == pytest.approx(10.0)
    assert deposit.edges[-1] == pytest.approx(0.06)


def test_a_slow_ball_that_keeps_its_speed_is_not_at_rest():
    path = along([0.0, 0.01, 0.02], [0.5, 0.5, 0.5]).foremost(Outline.of(Sphere(0.004)), AHEAD)
    assert path.position[-1, 0] == pytest.approx(0.024)


def test_a_track_survives_its_checkpoint():
    kept = along([0.0, 0.01, 0.03], [100.0, 90.0, 80.0], work=[0.0, 1.0, 2.0])
    again = BodyTrack(kept.rows)
    assert np.array_equal(again.rows, kept.rows)
    assert np.array_equal(BodyTrack(BodyTrack().rows).rows, np.zeros((0, 17)))
