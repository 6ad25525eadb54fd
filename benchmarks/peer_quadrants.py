"""The peer `quadrants` of bench_injury.py: that it computes the same, and how fast it is."""

from __future__ import annotations

import sys
import time

import numpy as np
from injury_scene import BALL_VELOCITY, GRAVITY, SPACING, Scene, loaded_solver, scene

from vulnus.injury.materials import tissue_table
from vulnus.injury.solver import MpmSolver, Precision

try:
    import mpm_quadrants
    import quadrants as qd
except ImportError:
    sys.exit("the peer needs the package quadrants: python -m pip install --group bench")

CHECKED_PARTICLES = 30_000
CHECKED_STEPS = 100
CHECKED_STEP = 2e-7  # [s]
TOLERANCES: dict[Precision, float] = {"float64": 1e-7, "float32": 2e-3}
"""Largest difference of a quantity over its largest value. Equal equations leave rounding: of the
order of 1e-10 in float64; in float32 that of F, which the peer stores where the solver stores
b - I: 6e-8 of strain a step, of which a hundred may sum to 1e-3 of what bone yields at."""


def loaded_peer(case: Scene, layout: str) -> mpm_quadrants.QuadrantsMpm:
    """The same particles, tissues and ball."""
    return mpm_quadrants.QuadrantsMpm(
        case.position,
        velocity=case.velocity,
        volume=case.volume,
        material=case.tissue,
        table=tissue_table(SPACING),
        grid_spacing=SPACING,
        gravity=GRAVITY,
        ball_centre=case.ball_centre,
        ball_velocity=BALL_VELOCITY,
        ball_radius=case.contact_radius,
        layout=layout,
    )


def check_agreement() -> None:
    """Run both on the same small scene in both precisions; ends the program where they differ."""
    case = scene(CHECKED_PARTICLES)
    for precision, tolerance in TOLERANCES.items():
        mpm_quadrants.start(1, precision)
        solver = loaded_solver(
            case, largest_step=CHECKED_STEP, precision=precision, passage_steps=1
        )
        peer = loaded_peer(case, "dense")
        while solver.steps < CHECKED_STEPS:
            before = solver.steps
            solver.advance_epoch(until=CHECKED_STEPS * CHECKED_STEP)
            for k in range(solver.steps - before):
                peer.step(CHECKED_STEP, regroup=k == 0)
        peer.finish(CHECKED_STEP)
        apart = differences(case, solver, peer)
        listed = ", ".join(f"{name} {value:.1e}" for name, value in apart.items())
        print(f"peer quadrants, {precision}, after {CHECKED_STEPS} steps: differences {listed}")
        if not max(apart.values()) < tolerance:
            sys.exit(f"the peer computes something else: differences must be < {tolerance:.0e}")


def differences(
    case: Scene, solver: MpmSolver, peer: mpm_quadrants.QuadrantsMpm
) -> dict[str, float]:
    """Differences, each over the solver's largest value of its kind."""
    back = np.argsort(peer.source)
    density = tissue_table(SPACING)[case.tissue, mpm_quadrants.DENSITY]
    mass = density * case.volume
    v, w = solver.velocity.astype(float), peer.v.to_numpy()[back].astype(float)
    moved = solver.position - case.position
    alpha = solver.plastic_strain
    momentum = np.abs(mass @ (w - v)).max() / (mass @ np.abs(v)).max()
    energy = mass @ np.sum(w**2, axis=1) / (mass @ np.sum(v**2, axis=1)) - 1.0
    return {
        "mass": abs(peer.mass.to_numpy().sum(dtype=float) / mass.sum() - 1.0),
        "momentum": float(momentum),
        "kinetic energy": abs(float(energy)),
        "displacement": _largest(peer.x.to_numpy()[back] - case.position - moved, moved),
        "velocity": _largest(w - v, v),
        "plastic strain": _largest(peer.alpha.to_numpy()[back] - alpha, alpha),
    }


def _largest(difference: np.ndarray, values: np.ndarray) -> float:
    return float(np.abs(difference).max() / np.abs(values).max())


def best_rate(case: Scene, threads: int) -> float:
    """Particle-steps a second with the faster layout of the grid; compiled and warm."""
    rates = {layout: _rate(case, layout, threads) for layout in mpm_quadrants.LAYOUTS}
    listed = ", ".join(f"{layout} {rate / 1e6:.2f} M/s" for layout, rate in rates.items())
    print(f"peer quadrants, float32, grid's layout: {listed}; the faster one counts")
    return max(rates.values())


def _rate(case: Scene, layout: str, threads: int, repeats: int = 3) -> float:
    mpm_quadrants.start(threads)
    peer = loaded_peer(case, layout)
    steps = max(2, int(1e6 / len(case.position)))
    best = float("inf")
    for _ in range(repeats + 1):  # the first compiles
        start = time.perf_counter()
        for k in range(steps):
            peer.step(CHECKED_STEP, regroup=k == 0)
        qd.sync()
        best = min(best, (time.perf_counter() - start) / steps)
    return len(case.position) / best
