"""The hole that a ball leaves in gel has the ball's radius: how the contact margin was chosen."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.injury.bodies.rigid_body import RigidBody
from vulnus.injury.bodies.shapes import Sphere
from vulnus.injury.materials import material_table, von_mises
from vulnus.injury.solver import MpmSolver

pytestmark = pytest.mark.physics

SPACING, RADIUS, SPEED = 0.002, 0.005, 100.0  # five cells a diameter
GEL = von_mises(density=1000.0, youngs_modulus=9e6, poisson_ratio=0.48, yield_stress=3e5)


def test_gel_passes_a_ball_at_its_own_radius():
    """Beside the ball's equator the particles' density rises to half within 10 % of the radius.

    The annuli are a quarter of a cell wide; a particle stands for a cube of half a cell.
    """
    middle = np.array([0.37, 0.21]) * SPACING  # no symmetry with the nodes
    across = (np.arange(30) - 14.5) * SPACING / 2.0
    along = (np.arange(40) + 0.5) * SPACING / 2.0
    x = np.stack(np.meshgrid(along, across, across, indexing="ij"), axis=-1).reshape(-1, 3)
    x += np.random.default_rng(0).uniform(-0.1, 0.1, x.shape) * SPACING
    start = -RADIUS - SPACING
    ball = RigidBody(
        shape=Sphere(RADIUS), centre=(start, *middle), velocity=(SPEED, 0.0, 0.0), friction=0.0
    )
    solver = MpmSolver(
        materials=material_table([GEL], SPACING), grid_spacing=SPACING, lower=(-0.2,) * 3,
        upper=(0.2,) * 3, bodies=[ball],
    )  # fmt: skip
    solver.set_particles(
        x, volume=np.full(len(x), (SPACING / 2.0) ** 3), material=np.zeros(len(x), np.uint8)
    )
    places = np.arange(0.014, 0.026, SPACING)
    beside = []
    for place in places:
        solver.advance(until=(place - start) / SPEED)
        position = solver.position
        near = np.abs(position[:, 0] - place) < 0.5 * SPACING
        beside.append(np.hypot(*(position[near, 1:] - middle).T))
    edges = np.arange(24) * SPACING / 4.0
    count, _ = np.histogram(np.concatenate(beside), edges)
    slices = len(places) * SPACING
    density = count * (SPACING / 2.0) ** 3 / (np.pi * np.diff(edges**2) * slices)
    rising = int(np.argmax(density > 0.5))
    below, above = density[rising - 1], density[rising]
    hole = edges[rising] - SPACING / 8.0 + SPACING / 4.0 * (0.5 - below) / (above - below)
    assert hole == pytest.approx(RADIUS, rel=0.10)
