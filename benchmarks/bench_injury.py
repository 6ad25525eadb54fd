"""Particle-steps a second of the material point method, with all laws on.

    python benchmarks/bench_injury.py --particles 1e5 1e6 --threads 2
    python benchmarks/bench_injury.py --json --peer numpy

A block of muscle with a skin shell and a bone rod is sheared so that it flows, while a sphere
enters it. The time of a step is the smallest of several repeats. With --json the last
line is one JSON object about the last size asked for; with --peer also the peer's rate.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from particle_benchmark import ParticleBenchmark

from vulnus.core.handoff import Tissue
from vulnus.injury.materials import tissue_table
from vulnus.injury.rigid_body import RigidBody
from vulnus.injury.shapes import Sphere
from vulnus.injury.solver import MpmSolver, set_threads

SPACING = 0.003
PARTICLES_PER_CELL = 8


def body(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, tissue codes and velocities of a cube of about `count` particles."""
    edge = round(count ** (1.0 / 3.0))
    step = SPACING / PARTICLES_PER_CELL ** (1.0 / 3.0)
    side = edge * step
    axis = (np.arange(edge) + 0.5) * step - 0.5 * side
    x = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    x += np.random.default_rng(0).uniform(-0.3, 0.3, x.shape) * step
    off_axis = np.hypot(x[:, 0], x[:, 1])
    tissue = np.full(len(x), Tissue.MUSCLE, np.uint8)
    tissue[off_axis > 0.45 * side] = Tissue.SKIN
    tissue[off_axis < 0.12 * side] = Tissue.BONE
    shear = 60.0 * np.sin(2.0 * np.pi / 0.015 * x[:, [1, 2, 0]])  # 2.5e4 /s: flows in some steps
    return x, tissue, shear


def loaded_solver(count: int) -> MpmSolver:
    """The block with the sphere at its face."""
    x, tissue, velocity = body(count)
    half = float(np.max(x))
    radius = min(0.0045, half / 3.0)
    ball = RigidBody(
        shape=Sphere(radius), centre=(0, -half - radius, 0), velocity=(0, 350, 0), friction=0.0
    )
    solver = MpmSolver(
        materials=tissue_table(SPACING), grid_spacing=SPACING, lower=(-half - 0.5,) * 3,
        upper=(half + 0.5,) * 3, gravity=(0.0, 0.0, -9.81),
        bodies=[ball],
    )  # fmt: skip
    volume = np.full(len(x), SPACING**3 / PARTICLES_PER_CELL)
    solver.set_particles(x, volume=volume, material=tissue, velocity=velocity)
    return solver


def measure(count: int, *, threads: int, repeats: int) -> dict[str, float]:
    """Rate, memory and share of particles that flow, of one size."""
    set_threads(threads)
    solver = loaded_solver(count)
    particles = len(solver.plastic_strain)
    steps = max(8, int(8e6 / particles))
    solver.advance(until=1.0, max_steps=16)
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        solver.advance(until=1.0, max_steps=steps)
        best = min(best, (time.perf_counter() - start) / steps)
    return {
        "particles": particles,
        "rate_per_s": particles / best,
        "step_s": best,
        "bytes_per_particle": solver.memory_bytes / particles,
        "flowing_fraction": float(np.mean(solver.plastic_strain > 0.0)),
    }


def peer_numpy(count: int) -> float:
    """Particle-steps a second of the NumPy twin (tests/reference), in float64, one thread."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
    from reference import mpm_twin

    x, tissue, velocity = body(min(count, 8000))
    material = mpm_twin.columns(tissue_table(SPACING), tissue)
    volume = np.full(len(x), SPACING**3 / PARTICLES_PER_CELL)
    state = mpm_twin.at_rest(x, velocity)
    gravity = np.array([0.0, 0.0, -9.81])
    start = time.perf_counter()
    for _ in range(2):
        state = mpm_twin.step(
            state, volume=volume, m=material, dx=SPACING, dt=1e-7, gravity=gravity
        )
    return 2.0 * len(x) / (time.perf_counter() - start)


PEERS: dict[str, Callable[[int], float]] = {"numpy": peer_numpy}
"""Same scheme, other code: name -> particle-steps a second for a number of particles."""


if __name__ == "__main__":
    ParticleBenchmark(
        description=__doc__ or "",
        particles=(1e5, 1e6),
        measure=lambda count, threads, repeats: measure(count, threads=threads, repeats=repeats),
        detail=lambda case: f"{100 * case['flowing_fraction']:.0f} % have flowed",
        peers=PEERS,
        about_peers="numpy: the slow twin of the tests, float64, one thread",
    ).run()
