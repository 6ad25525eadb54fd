"""Carotid artery and iliac bifurcation against the nonlinear 1-D solver openBF.

The published benchmark networks (Boileau 2015) as kept with their reference waveforms. The linear
tree keeps its tubes' geometry; it is given the radius and the wave speed that the nonlinear tubes
have at their mean pressure, so what remains is the nonlinearity of a beat.
"""

from __future__ import annotations

import csv

import numpy as np
import pytest

from vulnus.circulation import ArterialTree, CirculationParameters
from vulnus.circulation.aortic_signal import AorticSignal
from vulnus.circulation.segments import Segment, build_table

pytestmark = pytest.mark.physics

SAMPLES = 256
# vessel: parent, length, radius, thickness, Young's modulus, R1, R2, C (cca.yaml, ibif.yaml)
CAROTID = {
    "common_carotid_artery": (0, 0.126, 2.6485e-3, 0.24e-3, 7e5, 2.4875e8, 1.8697e9, 1.7529e-10)
}
ILIAC = {
    "parent": (0, 0.086, 7.581e-3, 0.9e-3, 5e5, 0.0, 0.0, np.nan),
    "d1": (1, 0.085, 5.492e-3, 0.68e-3, 7e5, 6.8123e7, 3.1013e9, 3.6664e-10),
    "d2": (1, 0.085, 5.492e-3, 0.68e-3, 7e5, 6.8123e7, 3.1013e9, 3.6664e-10),
}


def reference_waves(path):
    """(vessel, quantity) -> rows of time and five nodes along the vessel."""
    waves = {}
    with path.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            nodes = [float(row[name]) for name in ("t_s", "node1", "node3", "nodeM")]
            waves.setdefault((row["vessel"], row["quantity"]), []).append(nodes)
    return {key: np.array(rows) for key, rows in waves.items()}


def linearised(identity, name, vessel, mean_area):
    """A segment with the radius and wave speed of the nonlinear tube at its mean area.

    openBF: P = β (√A - √A0), β = √π E h / (0.75 A0), c² = β √A / (2ρ).
    """
    parent, length, radius, thickness, modulus, r1, r2, compliance = vessel
    dilated = np.sqrt(mean_area / np.pi)
    # c² = E h √A √π / (1.5 ρ A0) equals Moens-Korteweg's for this modulus at the dilated radius
    stiffer = modulus * (dilated / radius) ** 2
    return Segment(
        id=identity,
        name=name,
        parent=parent,
        length=length,
        radius=dilated,
        thickness=thickness,
        youngs_modulus=stiffer,
        quarter_wave_frequency=0.0,
        pair_member="",
        terminal_resistance=r1 + r2,
        proximal_resistance=r1,
        bed_compliance=compliance,
    )


def solve_case(folder, case, vessels):
    waves = reference_waves(folder / f"openbf_ref_{case}.csv")
    inlet = np.loadtxt(folder / f"{case}_inlet.dat")
    period = float(inlet[-1, 0])
    flow = np.interp(np.arange(SAMPLES) * period / SAMPLES, inlet[:, 0], inlet[:, 1])
    rows = [
        linearised(number, name, vessel, float(np.mean(waves[name, "A"][:, 1:])))
        for number, (name, vessel) in enumerate(vessels.items(), start=1)
    ]
    parameters = CirculationParameters(source="flow", wall_phase=0.0, venous_pressure=0.0)
    signal = AorticSignal(period=period, pressure=np.zeros(SAMPLES), flow=flow)
    return ArterialTree(build_table(rows, subject=case), signal, parameters), waves


@pytest.mark.parametrize(
    ("case", "vessels", "pressure_error", "flow_error"),
    [
        # r.m.s. over the cycle as a share of the pulse. Measured: carotid 1.1 % and 0.5 %, iliac
        # 2.2 % and 0.6 %; the limits leave a quarter of that for a change of the method
        ("cca", CAROTID, 0.014, 0.006),
        ("ibif", ILIAC, 0.028, 0.008),
    ],
)
def test_waves_agree_with_the_nonlinear_solver(
    shared_data, case, vessels, pressure_error, flow_error
):
    folder = shared_data / "reference" / "circulation"
    tree, waves = solve_case(folder, case, vessels)
    time = np.append(tree.time, tree.period)
    for number, (name, vessel) in enumerate(vessels.items(), start=1):
        for column, share in enumerate((0.0, 0.5, 1.0), start=1):
            for quantity, signal, limit in (
                ("P", tree.pressure, pressure_error),
                ("Q", tree.flow, flow_error),
            ):
                reference = waves[name, quantity]
                ours = signal(number, share * vessel[1])
                ours = np.interp(reference[:, 0] % tree.period, time, np.append(ours, ours[0]))
                error = np.sqrt(np.mean((ours - reference[:, column]) ** 2))
                assert error < limit * np.ptp(reference[:, column]), (name, quantity, share)
