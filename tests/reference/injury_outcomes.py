"""A made-up wound report, for tests of what is done with one."""

from __future__ import annotations

import numpy as np

from vulnus.core.handoff import InjuredLimb, InjuryOutcome
from vulnus.core.wound_report import (
    BoneFragment,
    BoneReport,
    CavityHistory,
    EnergyDeposit,
    ProjectileReport,
    SkinHole,
    TissueField,
    VesselReport,
    WoundReport,
    WoundTract,
)


def wound_report() -> WoundReport:
    """A ball of 3 g at 350 m/s that left 20 J on 40 mm, and the tibial artery cut."""
    arc = np.linspace(0.0, 0.04, 5)
    ball = ProjectileReport(
        name="sphere",
        fate="left",
        position=(0.0, 0.1, 0.0),
        speed_before=350.0,
        speed_after=330.0,
        energy_before=183.75,
        energy_after=163.35,
        tract=WoundTract(
            points=np.column_stack([0 * arc, arc, 0 * arc]),
            arc_length=arc,
            temporary_radius=np.full(5, 0.02),
            permanent_radius=np.full(5, 0.004),
            destroyed_radius=np.full(5, 0.006),
        ),
        entry=SkinHole(position=(0.0, 0.0, 0.0), open_area=3e-5, destroyed_area=6e-5),
        exit=SkinHole(position=(0.0, 0.04, 0.0), open_area=4e-5, destroyed_area=8e-5),
        energy=EnergyDeposit(edges=np.array([0.0, 0.02, 0.04]), energy=np.array([12.0, 8.0])),
    )
    return WoundReport(
        projectiles=(ball,),
        vessels=(
            VesselReport("anterior_tibial", "transected", 1.0, 3.0, -0.002, 6e-6, 1),
            VesselReport("fibular", "intact", 0.0, 1.1, np.inf, 0.0, 0),
        ),
        bone=BoneReport(0.3, 0.002, (BoneFragment(0.001, (0.0, 0.0, 0.0), 12),)),
        cavity=CavityHistory(np.array([0.0, 1e-3, 2e-3]), np.array([0.0, 3e-5, 1e-6])),
        field=TissueField((0.0, 0.0, 0.0), 2e-3, *np.zeros((2, 3, 4, 5), np.float32)),
        temporary_time=1e-3,
        particle_count=8,
        steps=100,
        flight_steps=60,
    )


def injury_outcome(permanent: InjuredLimb, temporary: InjuredLimb | None = None) -> InjuryOutcome:
    """Both states of a limb, which may be the same."""
    states = {"temporary": temporary or permanent, "permanent": permanent}
    return InjuryOutcome(states=states, bleeds_from="permanent", report=wound_report())
