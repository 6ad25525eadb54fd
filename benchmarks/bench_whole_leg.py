"""What a shot through the built-in leg costs: a 9 mm ball at 350 m/s, cells of 2 mm, 1 ms.

    python benchmarks/bench_whole_leg.py                         the whole leg, to the end
    python benchmarks/bench_whole_leg.py --window 0.12           12 cm of it around the track
    python benchmarks/bench_whole_leg.py --part 0.1              a tenth, and what the whole takes

Paper mode: the passage alone. The steps of the solver are timed, sorting included, without the
frames that a run writes. With --part the solver runs that part of the simulated time; the whole is
then its particle-steps at the measured rate.
"""

from __future__ import annotations

import argparse
import time

from vulnus.anatomy import AnatomyParameters, build_limb
from vulnus.core.handoff import LimbModel
from vulnus.imaging import generate_leg
from vulnus.injury.parameters import InjuryParameters, ProjectileParameters
from vulnus.injury.shot.setup import prepare_shot
from vulnus.injury.solver import set_threads

GRID_SPACING = 0.002  # [m]
PARTICLE_SPACING = 0.001  # [m]: 8 particles a cell
DURATION = 1e-3  # [s]


def options() -> argparse.Namespace:
    """The command line's options, checked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--part", type=float, default=1.0, help="part of the simulated time to run, 0-1")
    add(
        "--window", type=float, nargs="+", default=[0.0], help="length [m] around the track, 0: all"
    )
    scale = InjuryParameters().bone_modulus_scale
    about = f"factor on cortical bone's moduli (default {scale}), 1: the true ones, smaller steps"
    add("--bone-modulus-scale", type=float, default=scale, help=about)
    add("--threads", type=int, default=0, help="0: all processors (default)")
    parsed = parser.parse_args()
    if not 0.0 < parsed.part <= 1.0:
        parser.error("--part must be more than 0 and at most 1")
    return parsed


def measure(limb: LimbModel, window: float, args: argparse.Namespace) -> None:
    """Run one case and print its cost."""
    parameters = InjuryParameters(
        projectile=ProjectileParameters(diameter=0.009, speed=350.0),
        grid_spacing=GRID_SPACING,
        mode="paper",
        duration=DURATION,
        window_length=window or None,
        bone_modulus_scale=args.bone_modulus_scale,
    )
    solver = prepare_shot(limb, parameters).solver
    particles = len(solver.plastic_strain)
    start = time.perf_counter()
    solver.advance(until=args.part * DURATION)
    wall = time.perf_counter() - start
    rate = particles * solver.steps / wall
    steps = solver.steps / args.part
    extrapolated = "" if args.part == 1.0 else f" (extrapolated from {solver.steps} steps)"
    print(
        f"{f'{100 * window:.0f} cm window' if window else 'whole leg'}: {particles:,} particles,"
        f" {solver.memory_bytes / particles:.0f} bytes each, {rate / 1e6:.1f} M particle-steps/s,"
        f" {steps:.0f} steps of {1e6 * DURATION / steps:.3f} µs:"
        f" {particles * steps / rate / 60:.1f} min{extrapolated}",
        flush=True,
    )


if __name__ == "__main__":
    arguments = options()
    set_threads(arguments.threads)
    begin = time.perf_counter()
    leg = build_limb(generate_leg(), AnatomyParameters(particle_spacing=PARTICLE_SPACING))
    print(f"the built-in leg: {len(leg.position):,} particles, made in"
          f" {time.perf_counter() - begin:.0f} s", flush=True)  # fmt: skip
    for length in arguments.window:
        measure(leg, length, arguments)
