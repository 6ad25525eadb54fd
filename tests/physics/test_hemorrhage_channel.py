"""Flow between plates, free and through tissue: Poiseuille and Brinkman."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.hemorrhage import FluidParameters, FluidScene

DX = 1e-3
HALF_WIDTH = 10 * DX
VISCOSITY = 0.1
DENSITY = 1060.0
SPEED = 0.05


def channel(force: float, *, porosity: float = 1.0, permeability: float | None = None):
    """Blood at rest between plates at y = +-a, driven along x by a body force [m/s^2]."""
    parameters = FluidParameters(
        particle_spacing=DX, sound_speed=20.0 * SPEED, viscosity=VISCOSITY, density=DENSITY
    )
    scene = FluidScene(parameters, gravity=(force, 0.0, 0.0))
    length = 4 * DX
    scene.set_periodic(0, 0.0, length)
    scene.set_periodic(2, 0.0, length)
    low, high = (0.0, -HALF_WIDTH, 0.0), (length, HALF_WIDTH, length)
    scene.add_container(low, high, open_faces=("-x", "+x", "-z", "+z"))
    scene.fill_box(low, high)
    if permeability is not None:
        reach = HALF_WIDTH + 4 * DX
        scene.add_porous_block(
            (-reach, -reach, -reach),
            (reach, reach, reach),
            porosity=porosity,
            permeability=permeability,
        )
    return scene.build()


def relative_l2(found, exact) -> float:
    return float(np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2)))


def poiseuille(y, force, time):
    nu = VISCOSITY / DENSITY
    a = HALF_WIDTH
    n = np.arange(1, 80, 2)[:, np.newaxis]
    sign = (-1.0) ** ((n - 1) // 2)
    modes = 16 * force * a**2 / (nu * n**3 * np.pi**3) * sign * np.cos(n * np.pi * y / (2 * a))
    decay = np.exp(-nu * n**2 * np.pi**2 * time / (4 * a**2))
    return force / (2 * nu) * (a**2 - y**2) - (modes * decay).sum(axis=0)


@pytest.mark.physics
def test_poiseuille_start_up_and_steady():
    """PHYSICS S3 and Chong2017 (2); 3 % of the profile at 0.2, 0.5 and 1.2 diffusion times."""
    nu = VISCOSITY / DENSITY
    force = 2.0 * nu * SPEED / HALF_WIDTH**2
    fluid = channel(force)
    for share in (0.2, 0.5, 1.2):
        time = share * HALF_WIDTH**2 / nu
        fluid.advance(time)
        exact = poiseuille(fluid.position[:, 1], force, time)
        assert relative_l2(fluid.velocity[:, 0], exact) < 0.03


@pytest.mark.physics
def test_brinkman_channel():
    """PHYSICS S6: v = (K G/(eps mu)) (1 - cosh(y/d)/cosh(a/d)), d = sqrt(K/eps) = 4 dx; 3 %.

    Equation: Chong2017 (3)
    """
    depth, porosity = 4 * DX, 0.5
    permeability = depth**2 * porosity
    force = SPEED * porosity * VISCOSITY / (DENSITY * permeability)
    fluid = channel(force, porosity=porosity, permeability=permeability)
    fluid.advance(1.2 * HALF_WIDTH**2 * DENSITY / VISCOSITY)
    y = fluid.position[:, 1]
    exact = SPEED * (1.0 - np.cosh(y / depth) / np.cosh(HALF_WIDTH / depth))
    assert relative_l2(fluid.velocity[:, 0], exact) < 0.03


@pytest.mark.physics
def test_free_flow_is_not_brinkmans():
    """The comparison can fail: without tissue the profile is another."""
    depth = 4 * DX
    force = 2.0 * VISCOSITY / DENSITY * SPEED / HALF_WIDTH**2
    fluid = channel(force)
    fluid.advance(0.5 * HALF_WIDTH**2 * DENSITY / VISCOSITY)
    y = fluid.position[:, 1]
    exact = SPEED * (1.0 - np.cosh(y / depth) / np.cosh(HALF_WIDTH / depth))
    assert relative_l2(fluid.velocity[:, 0], exact) > 0.1
