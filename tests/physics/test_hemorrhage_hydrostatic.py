"""A column of blood at rest carries its weight."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.hemorrhage import FluidParameters, FluidScene

DX = 5e-3
HEIGHT = 20 * DX
GRAVITY = 9.80665
DENSITY = 1060.0


@pytest.fixture(scope="module")
def settled():
    """Profile (depths, pressures, tops) sampled ten times after 1.5 s in a tank with walls."""
    parameters = FluidParameters(particle_spacing=DX, sound_speed=15.0)
    scene = FluidScene(parameters, gravity=(0.0, 0.0, -GRAVITY))
    width = 8 * DX
    scene.set_periodic(1, 0.0, 4 * DX)
    scene.add_container((0, 0, 0), (width, 4 * DX, 0.15), open_faces=("+z", "-y", "+y"))
    scene.fill_box((0, 0, 0), (width, 4 * DX, HEIGHT))
    fluid = scene.build()
    heights, pressures, energy = [], [], []
    for sample in range(10):
        fluid.advance(1.5 + 0.05 * sample)
        heights.append(fluid.position[:, 2])
        pressures.append(fluid.pressure)
        energy.append(0.5 * float((fluid.velocity**2).sum(axis=1).mean()))
    return np.concatenate(heights), np.concatenate(pressures), energy


def layer_means(height, pressure):
    """Mean height and pressure of layers one spacing thick, but for the surface's last two."""
    layer = np.floor(height / DX).astype(int)
    rows = [(height[layer == k].mean(), pressure[layer == k].mean()) for k in range(18)]
    return np.array(rows).T


@pytest.mark.physics
def test_pressure_is_the_weight_above(settled):
    """PHYSICS S1: L2 error of p(z) at most 3 %; samples half a spacing deep count as the layer."""
    height, pressure = layer_means(settled[0], settled[1])
    exact = DENSITY * GRAVITY * (HEIGHT - height)
    error = np.sqrt(np.mean((pressure - exact) ** 2) / np.mean(exact**2))
    assert error < 0.03


@pytest.mark.physics
def test_column_comes_to_rest(settled):
    """Kinetic energy falls under 1e-4 of the potential energy g H."""
    assert settled[2][-1] < 1e-4 * GRAVITY * HEIGHT


@pytest.mark.physics
def test_column_keeps_its_height(settled):
    """Mean height is half the column's within 3 % (compression gH/2c^2 alone is 0.2 %)."""
    assert np.mean(settled[0]) == pytest.approx(0.5 * HEIGHT, rel=0.03)
