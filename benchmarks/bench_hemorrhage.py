"""Particle-steps a second of the bleeding solver, weakly compressible, at about 50 neighbours.

    python benchmarks/bench_hemorrhage.py --particles 1e4 1e5 --threads 2
    python benchmarks/bench_hemorrhage.py --json --peer numpy

A cube of blood stands on a floor under gravity and churns (0.2 m/s), so that neighbours change. The
time of a step, neighbour searches included, is the smallest of several repeats. With --json the
last line is one JSON object about the last size asked for; with --peer also the peer's rate.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from particle_benchmark import ParticleBenchmark

from vulnus.hemorrhage import Fluid, FluidParameters, FluidScene
from vulnus.hemorrhage.scene import box_lattice

SPACING = 1e-3
PARAMETERS = FluidParameters(particle_spacing=SPACING, sound_speed=30.0)
CHURN = 0.2
NO_WALL_LIMIT = 1e9
TWIN_LIMIT = 1000


def churning_cube(count: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Positions, velocities and side of a cube of about `count` particles."""
    edge = round(count ** (1.0 / 3.0))
    side = edge * SPACING
    points = box_lattice((0, 0, 0), (side, side, side), SPACING)
    points = points + np.random.default_rng(0).uniform(-0.05, 0.05, points.shape) * SPACING
    wave = 2.0 * np.pi / (10.0 * SPACING)
    velocity = CHURN * np.sin(wave * points[:, [2, 0, 1]])
    return points, velocity, side


def churning_fluid(count: int, threads: int) -> Fluid:
    """The cube on a floor, periodic to its sides."""
    points, velocity, side = churning_cube(count)
    scene = FluidScene(PARAMETERS, gravity=(0.0, 0.0, -9.81), threads=threads)
    for axis in range(2):
        scene.set_periodic(axis, 0.0, side)
    scene.add_container((0, 0, 0), (side, side, side), open_faces=("-x", "+x", "-y", "+y", "+z"))
    scene.add_fluid(points, velocity)
    return scene.build()


def mean_neighbours(fluid: Fluid) -> float:
    """Neighbours within h of particles away from the cube's faces."""
    from scipy.spatial import cKDTree

    h = PARAMETERS.smoothing_length
    position = fluid.position
    tree = cKDTree(position)
    inner = np.all(position > position.min(0) + h, axis=1)
    inner &= np.all(position < position.max(0) - h, axis=1)
    some = position[inner][:2000]
    return float(np.mean([len(found) - 1 for found in tree.query_ball_point(some, h)]))


def measure(count: int, *, threads: int, repeats: int) -> dict[str, float]:
    """Rate, memory and neighbours of one size."""
    fluid = churning_fluid(count, threads)
    particles = fluid.particle_count
    steps = max(8, int(1e6 / particles))
    fluid.step_chunk(1.0, step_limit=20, wall_time=NO_WALL_LIMIT)
    best = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        fluid.step_chunk(1.0, step_limit=steps, wall_time=NO_WALL_LIMIT)
        best = min(best, (time.perf_counter() - start) / steps)
    return {
        "particles": particles,
        "rate_per_s": particles / best,
        "step_s": best,
        "bytes_per_particle": fluid.native.memory_bytes / particles,
        "neighbours": mean_neighbours(fluid),
        "steps_per_search": fluid.steps / max(1, fluid.native.searches),
    }


def peer_numpy(count: int, threads: int = 1) -> float:  # noqa: ARG001
    """Particle-steps a second of the NumPy twin (tests/reference), in float64, all pairs."""
    sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
    from reference import sph_twin

    points, velocity, _ = churning_cube(min(count, TWIN_LIMIT))
    s = PARAMETERS.native()
    twin = sph_twin.TwinFluid(
        kernels=sph_twin.Kernels(PARAMETERS.kernels, s.smoothing),
        mass=s.density * SPACING**3, density=s.density, viscosity=s.viscosity,
        sound_speed=s.sound_speed, dissipation=s.dissipation, density_scale=s.density_scale,
        gradient_scale=s.gradient_scale, laplacian_scale=s.laplacian_scale,
    )  # fmt: skip
    gravity = np.array([0.0, 0.0, -9.81])
    start = time.perf_counter()
    for _ in range(2):
        points, velocity = sph_twin.steps(twin, points, velocity, gravity, dt=1e-6)
    return 2.0 * len(points) / (time.perf_counter() - start)


PEERS: dict[str, Callable[[int, int], float]] = {"numpy": peer_numpy}
"""Same equations, other code: name -> particle-steps a second for a number of particles."""


if __name__ == "__main__":
    ParticleBenchmark(
        description=__doc__ or "",
        particles=(1e4, 1e5),
        measure=lambda count, threads, repeats: measure(count, threads=threads, repeats=repeats),
        detail=lambda case: (
            f"{case['neighbours']:.0f} neighbours {case['steps_per_search']:.1f} steps/search"
        ),
        peers=PEERS,
        about_peers=f"numpy: the slow twin of the tests, float64, all pairs, at most {TWIN_LIMIT} "
        "particles",
    ).run()
