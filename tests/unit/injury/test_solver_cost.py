"""Memory of the solver, and the face of its benchmark."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vulnus.injury.materials import MUSCLE, material_table
from vulnus.injury.solver import MpmSolver

BENCHMARK = Path(__file__).resolve().parents[3] / "benchmarks" / "bench_injury.py"


def cubes(count: int, apart: float) -> MpmSolver:
    """`count` cubes of 20³ points, 8 a cell, in a row along x."""
    solver = MpmSolver(
        materials=material_table([MUSCLE], 0.002), grid_spacing=0.002, lower=(-5.0,) * 3,
        upper=(5.0,) * 3,
    )  # fmt: skip
    edge = np.arange(20) * 0.001
    cube = np.stack(np.meshgrid(edge, edge, edge, indexing="ij"), axis=-1).reshape(-1, 3)
    x = np.concatenate([cube + np.array([k * apart, 0.0, 0.0]) for k in range(count)])
    solver.set_particles(x, volume=np.full(len(x), 1e-9), material=np.zeros(len(x), np.uint8))
    solver.advance(until=1.0, max_steps=2)
    return solver


def test_memory_follows_the_occupied_blocks_not_the_box():
    """Bodies four metres apart cost what they cost side by side; 10 %: shared halo blocks."""
    near, far = cubes(2, 0.04), cubes(2, 4.0)
    assert far.memory_bytes < 1.1 * near.memory_bytes


def test_a_particle_costs_less_than_250_bytes():
    """In a body of 64 000 points; the grid's halo is part of the sum."""
    solver = cubes(8, 0.02)
    assert solver.memory_bytes / 64000 <= 250


def test_the_benchmark_ends_with_one_json_object():
    options = ("--json", "--repeats", "1", "--threads", "1", "--particles", "2000")
    command = [sys.executable, str(BENCHMARK), *options]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    result = json.loads(output.splitlines()[-1])
    assert result["particles"] == pytest.approx(2000, rel=0.15)
    assert result["rate_per_s"] > 0.0
    assert result["bytes_per_particle"] > 0.0


def test_the_benchmark_refuses_an_unknown_peer_by_name():
    run = subprocess.run(
        [sys.executable, str(BENCHMARK), "--peer", "abacus"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode != 0
    assert "abacus" in run.stderr
    assert "numpy" in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.skipif(shutil.which("c++") is None, reason="needs a compiler")
def test_the_roofline_counts_the_operations_of_the_laws_as_they_stand(monkeypatch):
    """The counting program compiles against the laws' headers; the order of its sums is known.

    A gather and a scatter touch 27 nodes with 4 values, a multiply-add each, so at least 216; an
    eigen-solution of three sweeps alone takes nine rotations of some 50.
    """
    monkeypatch.syspath_prepend(str(BENCHMARK.parent))
    import machine_roofline

    flops = machine_roofline.run_program("count_flops", threads=1)
    assert flops["gather"] > 216
    assert flops["scatter"] > 216
    assert 450 < flops["laws"] < 5000


def test_the_roofline_counts_the_bytes_of_the_particles_that_move(monkeypatch):
    """A step reads what it keeps of a particle, and writes it but for volume and material."""
    monkeypatch.syspath_prepend(str(BENCHMARK.parent))
    import injury_scene
    import machine_roofline

    traffic = machine_roofline.bytes_per_particle_step(8000)
    fields = len(injury_scene.loaded_solver(injury_scene.scene(1000)).state()["fields"])
    assert traffic["read"] == 4 * (fields - 12) + 1
    assert traffic["written"] == traffic["read"] - 5
    assert traffic["grid"] > 0.0
