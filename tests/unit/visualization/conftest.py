"""A thick rod of skin, muscle and bone with a hole through it, and blood: small, but a limb."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.handoff import (
    BleedLedger,
    BleedOutcome,
    BleedWaveforms,
    BoneFragment,
    BoneReport,
    CavityHistory,
    EnergyDeposit,
    InjuredArtery,
    InjuredLimb,
    LabelVolume,
    ParticleFrame,
    ProjectileReport,
    ShotLine,
    SkinHole,
    Tissue,
    TissueField,
    VesselInjury,
    VesselReport,
    WoundReport,
    WoundTract,
)

SPACING = 0.004  # m
RADIUS = 0.03
LENGTH = 0.16


def _rod() -> tuple[np.ndarray, np.ndarray]:
    """Points on a lattice inside a cylinder along z and their tissue."""
    count = int(RADIUS / SPACING) + 1
    levels = SPACING * (0.5 + np.arange(int(LENGTH / SPACING)))  # none on the shot's axis
    across = SPACING * np.arange(-count, count + 1)
    points = np.stack(np.meshgrid(across, across, levels, indexing="ij"), -1).reshape(-1, 3)
    distance = np.hypot(points[:, 0], points[:, 1])
    points, distance = points[distance < RADIUS], distance[distance < RADIUS]
    tissue = np.full(len(points), Tissue.MUSCLE, np.uint8)
    tissue[distance > RADIUS - 1.2 * SPACING] = Tissue.SKIN
    tissue[distance < 0.007] = Tissue.BONE
    return points.astype(np.float32), tissue


@pytest.fixture(scope="session")
def wound() -> InjuredLimb:
    reference, tissue = _rod()
    middle = 0.5 * LENGTH
    flight = np.array([0.0, 1.0, 0.0])
    from_axis = reference - np.array([0.012, 0.0, middle])
    radial = from_axis - (from_axis @ flight)[:, None] * flight
    distance = np.maximum(np.linalg.norm(radial, axis=1, keepdims=True), 1e-6)
    push = np.where(distance < 0.02, np.sqrt(distance**2 + 0.006**2) - distance, 0.0)
    position = (reference + push * radial / distance).astype(np.float32)
    damage = (distance[:, 0] < 0.006).astype(np.float32)
    line = np.column_stack([np.full(40, 0.012), np.zeros(40), np.linspace(LENGTH, 0.0, 40)])
    torn = (np.abs(line[:, 2] - middle) < 0.006).astype(float)
    artery = InjuredArtery("anterior_tibial", line, line, np.full(40, 0.0015), torn)
    return InjuredLimb(
        position=position,
        reference_position=reference,
        tissue=tissue,
        volume=np.full(len(reference), SPACING**3, np.float32),
        damage=damage,
        spacing=SPACING,
        arteries=(artery,),
        injuries=(
            VesselInjury(
                "anterior_tibial",
                middle,
                0.5,
                0.012,
                0.0015,
                (0.012, 0.0, middle),
                (0.012, 0.0, middle + 0.006),
                (0.012, 0.0, middle - 0.006),
                (0.0, 0.0, -1.0),
                (0.0, 0.0, 1.0),
            ),
        ),
        shot=ShotLine(
            (0.012, -RADIUS, middle), (0.012, RADIUS, middle), (0.0, 1.0, 0.0), 6e-3, 300
        ),
        entry_area=3e-5,
        exit_area=1e-4,
        time=1e-3,
        steps=10,
        particle_steps_per_second=1e6,
        surfaces={},
        side="left",
    )


@pytest.fixture(scope="session")
def wound_report() -> WoundReport:
    place = np.linspace(0.0, 0.06, 13)
    tract = WoundTract(
        points=np.column_stack([np.full(13, 0.012), place - RADIUS, np.full(13, 0.08)]),
        arc_length=place,
        temporary_radius=np.full(13, 0.02),
        permanent_radius=np.full(13, 0.004),
        destroyed_radius=np.full(13, 0.006),
    )
    energy = np.linspace(15.0, 5.0, 10)
    bullet = ProjectileReport(
        name="9x19_fmj",
        fate="left",
        position=(0.012, 0.1, 0.08),
        speed_before=360.0,
        speed_after=210.0,
        energy_before=518.0,
        energy_after=176.0,
        tract=tract,
        entry=SkinHole((0.012, -RADIUS, 0.08), 2e-5, 5e-5),
        exit=SkinHole((0.012, RADIUS, 0.08), 8e-5, 1.5e-4),
        energy=EnergyDeposit(np.linspace(0.0, 0.06, 11), energy),
    )
    vessel = VesselReport("posterior_tibial", "transected", 1.0, 1.7, -1e-3, 7e-6, 1)
    time = np.linspace(0.0, 15e-3, 16)
    volume = np.interp(time, [0.0, 3e-3, 15e-3], [0.0, 50e-6, 5e-6])
    none = np.zeros((2, 2, 2), np.float32)
    pieces = tuple(BoneFragment(mass, (0.0, 0.0, 0.08), 20) for mass in (2e-3, 1e-3))
    return WoundReport(
        projectiles=(bullet,),
        vessels=(vessel,),
        bone=BoneReport(0.1, 4e-3, pieces),
        cavity=CavityHistory(time, volume),
        field=TissueField((0.0, 0.0, 0.0), 2e-3, none, none),
        temporary_time=3e-3,
        particle_count=1000,
        steps=100,
        flight_steps=50,
    )


@pytest.fixture(scope="session")
def labels() -> LabelVolume:
    axes = np.meshgrid(np.arange(-18, 18), np.arange(-18, 18), np.arange(40), indexing="ij")
    distance = 2e-3 * np.hypot(axes[0], axes[1])
    volume = np.zeros(distance.shape, np.uint8)
    volume[distance < RADIUS] = Tissue.SKIN
    volume[distance < RADIUS - 3e-3] = Tissue.MUSCLE
    volume[distance < 7e-3] = Tissue.BONE
    origin = np.array([-0.036, -0.036, 0.0])
    spacing = np.array([2e-3, 2e-3, 4e-3])
    return LabelVolume(volume, origin, spacing, np.eye(3), (), "rod")


@pytest.fixture(scope="session")
def injury_frames(wound: InjuredLimb) -> list[ParticleFrame]:
    frames = []
    for index, share in enumerate((0.0, 0.5, 1.0)):
        near = np.abs(wound.reference_position[:, 2] - 0.5 * LENGTH) < 0.04
        moved = share * (wound.position - wound.reference_position)[near]
        data = {
            "displacement_m": moved,
            "damage": share * wound.damage[near],
            "tissue": wound.tissue[near],
        }
        position = (wound.reference_position[near] + moved).astype(np.float32)
        frames.append(ParticleFrame(index, 1e-3 * share, position, data))
    return frames


@pytest.fixture(scope="session")
def bleed_frames() -> list[ParticleFrame]:
    rng = np.random.default_rng(5)
    start = np.array([0.012, RADIUS, 0.5 * LENGTH])
    frames = [ParticleFrame(0, 0.0, np.zeros((0, 3), np.float32), {})]
    for index in range(1, 4):
        along = np.linspace(0.0, 0.02 * index, 15 * index)[:, None]
        jet = start + along * [0.0, 1.0, 0.0] - 8.0 * along**2 * [0.0, 0.0, 1.0]
        position = (jet + 1e-3 * rng.standard_normal(jet.shape)).astype(np.float32)
        frames.append(ParticleFrame(index, 0.1 * index, position, {}))
    return frames


@pytest.fixture(scope="session")
def outcome() -> BleedOutcome:
    time = np.linspace(0.0, 1.6, 161)
    beat = np.sin(2.0 * np.pi * time / 0.8)
    flow = 5e-6 * (1.0 + 0.3 * beat)
    waves = BleedWaveforms(
        time=time,
        pressure_aorta=13e3 + 2e3 * beat,
        pressure_artery=12e3 + 1.5e3 * beat,
        pressure_injury=1e3 * time,
        flow_injury=flow,
    )
    injected = np.concatenate([[0.0], np.cumsum(0.5 * (flow[1:] + flow[:-1]) * np.diff(time))])
    ledger = BleedLedger(
        time=time,
        injected=injected,
        in_limb=0.6 * injected,
        out_of_limb=0.3 * injected,
        removed=0.1 * injected,
        pending=0.0 * injected,
    )
    return BleedOutcome(waves, ledger, 0.8, np.array([5e-6, 4.9e-6]), 0, 100, 1000, 1e6)
