"""How far the material point solver is from the limits of this machine (Williams et al. 2009).

Two small C++ programs, compiled here with the compiler that built the solver, measure the machine
(machine_peaks.cpp) and count the operations of a particle-step (count_flops.cpp). The bytes follow
from the solver's arrays: every array that a step touches moves once between memory and processor.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from injury_scene import SPACING, loaded_solver, scene

FOLDER = Path(__file__).resolve().parent
REAL = 4  # bytes of a float
RESTING_FIELDS = (
    12  # v and C: they live in registers and caches within an epoch (particle_pass.hpp)
)
CONSTANT_FIELDS = 1  # the volume is read only
MATERIAL_CODE = 1  # byte, read only
TILE_NODES, BLOCK_NODES, NODE = 512, 64, 4 * REAL  # block_grid.hpp: mass and three components
TILE_PASSES, NODE_PASSES = 2, 2  # tiles: scattered, then summed; nodes: summed, then gathered


def run_program(name: str, threads: int) -> dict[str, float]:
    """Compile benchmarks/`name`.cpp, run it, and read its "name value" lines."""
    compiler = os.environ.get("CXX") or shutil.which("c++") or shutil.which("g++")
    if compiler is None:
        sys.exit("--roofline needs a C++20 compiler: install g++ or set CXX")
    environment = os.environ | ({"OMP_NUM_THREADS": str(threads)} if threads else {})
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / name
        flags = (
            "-std=c++20",
            "-O3",
            "-march=native",
            "-fopenmp",
            "-Wno-psabi",
            f"-I{FOLDER.parent / 'native'}",
        )
        source = FOLDER / f"{name}.cpp"
        subprocess.run([compiler, *flags, str(source), "-o", str(program)], check=True)
        lines = subprocess.run([program], check=True, capture_output=True, text=True,
                               env=environment).stdout.splitlines()  # fmt: skip
    return {key: float(value) for key, value in (line.split() for line in lines)}


def bytes_per_particle_step(count: int) -> dict[str, float]:
    """Bytes between memory and processor: particles read and written, and the grid's share."""
    case = scene(count)
    solver = loaded_solver(case)
    fields = len(solver.state()["fields"])
    moved = fields - RESTING_FIELDS
    blocks = len(np.unique(np.floor(case.position / SPACING - 0.5).astype(int) // 4, axis=0))
    grid = NODE * (TILE_PASSES * TILE_NODES + NODE_PASSES * BLOCK_NODES)
    return {
        "read": REAL * moved + MATERIAL_CODE,
        "written": REAL * (moved - CONSTANT_FIELDS),
        "grid": blocks * grid / len(case.position),
    }


def report(case: Mapping[str, Any], threads: int) -> list[str]:
    """Lines about a measured case: the machine, a particle-step, and the distance to the roof."""
    machine = run_program("machine_peaks", threads)
    flops = run_program("count_flops", threads)
    traffic = bytes_per_particle_step(int(case["particles"]))
    memory, arithmetic = sum(traffic.values()), sum(flops.values())
    by_memory = machine["memory_bytes_per_s"] / memory
    by_flops = machine["flops_per_s"] / arithmetic
    bound = "memory" if by_memory < by_flops else "arithmetic"
    rate = case["rate_per_s"]
    return [
        f"machine: {machine['memory_bytes_per_s'] / 1e9:.0f} GB/s from memory (triad),"
        f" {machine['l2_bytes_per_s'] / 1e9:.0f} GB/s from the second cache,"
        f" {machine['flops_per_s'] / 1e9:.0f} Gflop/s (fused multiply-adds, float32)",
        f"a particle-step: {memory:.0f} bytes ({traffic['read']:.0f} read, {traffic['written']:.0f}"
        f" written, {traffic['grid']:.0f} of the grid), {arithmetic:.0f} flop"
        f" (gather {flops['gather']:.0f}, laws {flops['laws']:.0f},"
        f" scatter {flops['scatter']:.0f}):"
        f" {arithmetic / memory:.1f} flop/byte, the ridge is at"
        f" {machine['flops_per_s'] / machine['memory_bytes_per_s']:.1f}",
        f"roof: {by_memory / 1e6:.0f} M/s by memory, {by_flops / 1e6:.0f} M/s by arithmetic"
        f" (bound by {bound}); measured {rate / 1e6:.1f} M/s: {100 * rate / by_memory:.0f} % of the"
        f" bandwidth, {100 * rate / by_flops:.0f} % of the peak",
    ]
