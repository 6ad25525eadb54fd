"""Blood driven through a long column of tissue moves at Darcy's speed."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.hemorrhage import FluidParameters, FluidScene

DX = 1e-3
SIDE = 6 * DX
POROSITY = 0.3
VISCOSITY = 3.5e-3
DENSITY = 1060.0
FORCE = 100.0


def column(permeability: float, *, time_step: float):
    """Tissue everywhere, periodic in all directions, a pressure gradient rho FORCE along z."""
    parameters = FluidParameters(
        particle_spacing=DX,
        sound_speed=10.0,
        viscosity=VISCOSITY,
        density=DENSITY,
        time_step=time_step,
    )
    scene = FluidScene(parameters, gravity=(0.0, 0.0, FORCE))
    for axis in range(3):
        scene.set_periodic(axis, 0.0, SIDE)
    scene.fill_box((0, 0, 0), (SIDE, SIDE, SIDE))
    scene.add_porous_block(
        (-SIDE,) * 3, (2 * SIDE,) * 3, porosity=POROSITY, permeability=permeability
    )
    return scene.build()


@pytest.mark.physics
def test_start_up_and_steady_speed():
    """PHYSICS S7: v = v_inf (1 - exp(-t/tau)); 2 % with steps of tau/50 (first order: 1 %).

    Equation: Chong2017 (13)
    """
    permeability = 1e-9
    tau = DENSITY * permeability / (POROSITY * VISCOSITY)
    final = permeability * DENSITY * FORCE / (POROSITY * VISCOSITY)
    fluid = column(permeability, time_step=tau / 50)
    for share in (0.5, 1.0, 2.0, 6.0):
        fluid.advance(share * tau)
        exact = final * (1.0 - np.exp(-share))
        assert fluid.velocity[:, 2].mean() == pytest.approx(exact, rel=0.02)


@pytest.mark.physics
@pytest.mark.parametrize("permeability", [1e-13, 1e-14])
def test_tight_tissue_is_stable_at_steps_of_a_hundred_relaxation_times(permeability):
    """Implicit drag: steps of 100 tau, 3 % of Darcy's speed, nothing else moves."""
    tau = DENSITY * permeability / (POROSITY * VISCOSITY)
    final = permeability * DENSITY * FORCE / (POROSITY * VISCOSITY)
    fluid = column(permeability, time_step=100.0 * tau)
    fluid.advance(20_000.0 * tau)
    assert fluid.velocity[:, 2].mean() == pytest.approx(final, rel=0.03)
    assert np.abs(fluid.velocity[:, :2]).max() < 1e-3 * final
