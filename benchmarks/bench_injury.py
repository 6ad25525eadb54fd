"""Particle-steps a second of the material point method, with all laws on.

    python benchmarks/bench_injury.py --particles 1e5 1e6 --threads 2
    python benchmarks/bench_injury.py --particles 1e6 --peer quadrants
    python benchmarks/bench_injury.py --roofline

A block of muscle with a skin shell and a bone rod is sheared so that it flows, while a sphere
enters it. Whole epochs are measured, from one sort of the particles to the next; the time of a
step is that of the fastest of several repeats. With --json the last line is one JSON object about
the last size asked for; with --peer also the peer's rate. The peer `quadrants` is first shown to
compute the same (peer_quadrants.py); --roofline says how far from this machine's limits the solver
is (machine_roofline.py).
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import machine_roofline
import numpy as np
from injury_scene import GRAVITY, SPACING, loaded_solver, scene
from particle_benchmark import ParticleBenchmark

from vulnus.injury.materials import tissue_table
from vulnus.injury.solver import set_threads


def measure(count: int, threads: int, repeats: int) -> dict[str, float]:
    """Rate, memory and share of particles that flow, of one size."""
    set_threads(threads)
    solver = loaded_solver(scene(count))
    particles = len(solver.plastic_strain)
    solver.advance_epoch(until=1.0)
    best = float("inf")
    for _ in range(repeats):
        start, first = time.perf_counter(), solver.steps
        while solver.steps - first < 1e6 / particles:
            solver.advance_epoch(until=1.0)
        best = min(best, (time.perf_counter() - start) / (solver.steps - first))
    return {
        "particles": particles,
        "rate_per_s": particles / best,
        "step_s": best,
        "bytes_per_particle": solver.memory_bytes / particles,
        "flowing_fraction": float(np.mean(solver.plastic_strain > 0.0)),
    }


def peer_numpy(count: int, _threads: int) -> float:
    """Particle-steps a second of the NumPy twin (tests/reference), in float64, one thread."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
    from reference import mpm_twin

    case = scene(min(count, 8000))
    material = mpm_twin.columns(tissue_table(SPACING), case.tissue)
    volume = np.full(len(case.position), case.volume)
    state = mpm_twin.at_rest(case.position, case.velocity)
    start = time.perf_counter()
    for _ in range(2):
        state = mpm_twin.step(
            state, volume=volume, m=material, dx=SPACING, dt=1e-7, gravity=np.array(GRAVITY)
        )
    return 2.0 * len(case.position) / (time.perf_counter() - start)


def peer_quadrants(count: int, threads: int) -> float:
    """Particle-steps a second of `quadrants`, after a check that it computes the same."""
    import peer_quadrants

    peer_quadrants.check_agreement()
    return peer_quadrants.best_rate(scene(count), threads)


PEERS: dict[str, Callable[[int, int], float]] = {"numpy": peer_numpy, "quadrants": peer_quadrants}
"""Same scheme, other code: name -> particle-steps a second, of (particles, threads)."""


if __name__ == "__main__":
    ParticleBenchmark(
        description=__doc__ or "",
        particles=(1e5, 1e6, 5e6),
        measure=measure,
        detail=lambda case: f"{100 * case['flowing_fraction']:.0f} % have flowed",
        peers=PEERS,
        about_peers="numpy: the slow twin of the tests, float64, one thread; quadrants: the package"
        " of that name, float32, all laws, the same threads",
        roofline=machine_roofline.report,
    ).run()
