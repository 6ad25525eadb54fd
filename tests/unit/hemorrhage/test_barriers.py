"""Skin and bone are watertight where they hold and open where they failed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from reference.sph_limb import BONE_CENTER, BONE_RADIUS, HALF_LENGTH, RADIUS

from vulnus.core.handoff import Tissue
from vulnus.hemorrhage import FluidParameters, FluidScene, HemorrhageParameters, PlatformParameters
from vulnus.hemorrhage.barriers import build_barriers, place_platform
from vulnus.hemorrhage.preparation import prepare

PARAMETERS = HemorrhageParameters(particle_spacing=2e-3)


@pytest.fixture(scope="module")
def closed(closed_wound):
    return build_barriers(closed_wound, PARAMETERS)


@pytest.fixture(scope="module")
def opened(open_wound):
    return build_barriers(open_wound, PARAMETERS)


def deepest_on_rays(barriers, angles, heights):
    """Least signed distance along rays from the limb's inside out of it (rays,)."""
    r = np.linspace(RADIUS - 5e-3, RADIUS + 2e-3, 36)
    a, z, s = np.meshgrid(angles, heights, r, indexing="ij")
    points = np.stack([s * np.cos(a), s * np.sin(a), z], axis=-1)
    distance, _ = barriers.grid.sample(barriers.barrier, points.reshape(-1, 3))
    return distance.reshape(a.shape).min(axis=2)


def test_intact_skin_stops_every_ray(closed):
    """4,000 rays cross solid skin, at the tract's ends too, where nothing lies under it."""
    angles = np.linspace(0.0, 2.0 * np.pi, 100, endpoint=False)
    heights = np.linspace(-0.8, 0.8, 40) * HALF_LENGTH
    assert deepest_on_rays(closed, angles, heights).max() < 0.0


def test_holes_of_the_tract_are_open(opened):
    """On the tract's axis at entry and exit there is room for blood."""
    x = np.linspace(-RADIUS - 2e-3, RADIUS + 2e-3, 60)
    axis = np.stack([x, np.full(60, -8e-3), np.zeros(60)], axis=1)
    distance, _ = opened.grid.sample(opened.barrier, axis)
    assert distance.min() > 1e-3


def test_bone_is_solid_to_its_middle(opened):
    angles = np.linspace(0.0, 2.0 * np.pi, 40)
    for share in (0.0, 0.5, 0.9):
        x = BONE_CENTER[0] + share * BONE_RADIUS * np.cos(angles)
        y = BONE_CENTER[1] + share * BONE_RADIUS * np.sin(angles)
        points = np.stack([x, y, np.full(40, 5e-3)], axis=1)
        distance, _ = opened.grid.sample(opened.barrier, points)
        assert distance.max() < 0.5e-3


def test_failed_skin_is_a_hole(closed_wound):
    """Damage alone, with no point moved, opens the skin; with `presence` it does not."""
    damage = closed_wound.damage.copy()
    away = closed_wound.position - np.array([0.0, RADIUS, 0.0])
    patch = (np.linalg.norm(away, axis=1) < 6e-3) & (closed_wound.tissue == Tissue.SKIN)
    damage[patch] = 1.0
    wound = dataclasses.replace(closed_wound, damage=damage)
    middle = np.array([[0.0, RADIUS - 1e-3, 0.0]])
    for model, is_open in (("damage", True), ("presence", False)):
        parameters = dataclasses.replace(PARAMETERS, barrier_model=model)
        barriers = build_barriers(wound, parameters)
        distance, _ = barriers.grid.sample(barriers.barrier, middle)
        assert (distance[0] > 0.0) == is_open


def test_particles_line_the_barrier_without_crowding(closed):
    """Inside the solid, none nearer than 0.85 spacings, no place of the face farther than 1.6."""
    from scipy.spatial import cKDTree

    depth, _ = closed.grid.sample(closed.barrier, closed.particles)
    assert depth.max() < -0.3 * PARAMETERS.particle_spacing
    tree = cKDTree(closed.particles)
    nearest = tree.query(closed.particles, k=2)[0][:, 1]
    assert nearest.min() > 0.85 * PARAMETERS.particle_spacing
    angles = np.linspace(0.0, 2.0 * np.pi, 400)
    face = (RADIUS - 1e-3) * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    assert tree.query(face)[0].max() < 1.6 * PARAMETERS.particle_spacing


def test_limb_counts_its_tract_as_inside(opened):
    points = np.array([[0.0, -8e-3, 0.0], [RADIUS - 2e-3, -8e-3, 0.0], [RADIUS + 4e-3, 0, 0]])
    distance, _ = opened.grid.sample(opened.limb, points)
    assert distance[0] < 0.0
    assert distance[1] < 0.0
    assert distance[2] > 0.0


def test_platform_lies_below_the_limb_across_gravity(open_wound):
    platform = place_platform(
        PlatformParameters(gap=4e-3), open_wound.reference_position, (0.0, 9.8, 0.0), 5e-3
    )
    assert platform.normal == pytest.approx((0.0, -1.0, 0.0))
    lowest = open_wound.reference_position[:, 1].max()
    assert platform.point[1] == pytest.approx(lowest + 4e-3, abs=1e-6)
    layers = platform.particles(1e-3)
    assert layers[:, 1].min() > platform.point[1]


def test_platform_catches_what_falls(open_wound):
    """A drop let go above the platform rests on it and is not counted as a crossing."""
    parameters = dataclasses.replace(
        PARAMETERS,
        gravity=(0.0, 9.8, 0.0),
        sound_speed=10.0,
        platform=PlatformParameters(gap=10e-3, half_extent=0.02),
    )
    solver = prepare(open_wound, parameters)
    face = open_wound.reference_position[:, 1].max() + 10e-3
    drop = np.array([[0.0, face - 4e-3, 0.0], [2e-3, face - 4e-3, 0.0]])
    solver.native.add_particles(solver.local(drop), np.zeros((2, 3)))
    solver.advance(0.2)
    assert solver.particle_count == 2
    assert solver.position[:, 1].max() <= face + 1e-4
    assert solver.position[:, 1].min() > face - 2.5e-3
    assert solver.barrier_crossings == 0


def test_a_particle_deep_in_a_wall_is_put_back_and_counted():
    """The count of crossings is not 0 by construction: 0.8 spacings deep counts, 0.3 does not."""
    dx = 2e-3
    for depth, crossings in ((0.3, 0), (0.8, 1)):
        scene = FluidScene(FluidParameters(particle_spacing=dx))
        scene.add_container((0.0, 0.0, 0.0), (0.02, 0.02, 0.02), safety_net=True)
        scene.add_fluid(np.array([[0.01, 0.01, -depth * dx]]))
        fluid = scene.build(double=True)
        fluid.step_chunk(1.0, step_limit=1)
        assert fluid.barrier_crossings == crossings
        assert fluid.native.pushed == 1
        # What a wall's pressure moves it within the one step of 2e-5 s is far below this.
        assert fluid.position[0, 2] == pytest.approx(0.0, abs=0.1 * dx)
