"""Porosity and permeability follow the injured tissue."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from vulnus.hemorrhage import HemorrhageParameters, _native
from vulnus.hemorrhage.tissue_field import build_tissue

PARAMETERS = HemorrhageParameters()


def at(field, values, point):
    node = np.rint((np.array(point) - field.grid.origin) / field.grid.cell).astype(int)
    return values[tuple(node)]


def test_intact_muscle_keeps_its_porosity_and_is_a_wall(open_wound):
    field = build_tissue(open_wound, PARAMETERS)
    point = (0.0, -8e-3, 0.03)
    assert at(field, field.porosity, point) == pytest.approx(0.12, abs=1e-3)
    rate = np.exp(at(field, field.log_drag_rate, point))
    permeability = 0.12 * 3.5e-3 / (1060.0 * rate)
    assert permeability < 1e-11


def test_tract_and_air_are_free(open_wound):
    field = build_tissue(open_wound, PARAMETERS)
    for point in ((0.0, -8e-3, 0.0), (0.01, -8e-3, 0.0), (0.0335, 0.0, 0.02)):
        assert at(field, field.porosity, point) == 1.0
        assert at(field, field.log_drag_rate, point) == np.float32(_native.FREE_LOG_RATE)


def test_damage_opens_tissue(open_wound):
    """The same place with damage 0.7 is at least ten times as permeable."""
    point = (0.0, -8e-3, 0.03)
    torn = dataclasses.replace(open_wound, damage=np.full_like(open_wound.damage, 0.7))
    rates = [
        at(f, f.log_drag_rate, point)
        for f in (build_tissue(open_wound, PARAMETERS), build_tissue(torn, PARAMETERS))
    ]
    assert rates[1] < rates[0] - np.log(10.0)


def test_stretched_tissue_is_more_porous(open_wound):
    """Twice the volume: eps = 1 - 0.88/2, to the noise of a Poisson-disk set (10 %)."""
    scale = 2.0 ** (1.0 / 3.0)
    position = (scale * open_wound.reference_position).astype(np.float32)
    swollen = dataclasses.replace(open_wound, position=position)
    field = build_tissue(swollen, PARAMETERS)
    inner = [at(field, field.porosity, (x, 0.0, z)) for x in (-0.01, 0.01) for z in (-0.01, 0.01)]
    assert np.mean(inner) == pytest.approx(0.56, abs=0.06)


def test_constant_model_has_the_papers_permeability(open_wound):
    field = build_tissue(open_wound, dataclasses.replace(PARAMETERS, permeability_model="constant"))
    point = (0.0, -8e-3, 0.03)
    expected = at(field, field.porosity, point) * 3.5e-3 / (1060.0 * 5e-7)
    assert np.exp(at(field, field.log_drag_rate, point)) == pytest.approx(expected, rel=1e-3)
