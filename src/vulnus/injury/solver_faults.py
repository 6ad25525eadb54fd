"""What a step that goes wrong is told with: particle, place, time and advice."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vulnus.core.errors import UnstableStepError

if TYPE_CHECKING:
    from .solver import MpmSolver

COLLAPSED, UNSOLVED = 16, 32
FAULTS = {
    1: "a value that is not finite",
    2: "an inverted particle",
    4: "a particle that left the domain",
    8: "a particle that moved more than a cell between two sorts",
    COLLAPSED: "a time step that has collapsed",
}
"""Bits of `native/core/fault.hpp`."""

SOLVER = "material point method"
ADVICE = "Try a smaller courant_number (0.3) or a finer grid_spacing."
COLLAPSE_ADVICE = (
    "Its waves are more than 1000 times as fast as at rest, or its velocity has no bound: look for "
    "what squeezes or stretches it without end, or give its material a strength."
)


def particle_fault(solver: MpmSolver, bits: int, particle: int) -> UnstableStepError:
    """Tell the fault of a particle, with what its step had come to where that collapsed."""
    x, y, z = (float(c) for c in solver.position[particle])
    fault = " and ".join(text for bit, text in FAULTS.items() if bits & bit)
    collapsed = bool(bits & COLLAPSED)
    if collapsed:
        ratio = float(solver.volume_ratio[particle])
        fault += f" to {solver.step_size:.3g} s (volume ratio {ratio:.3g})"
    return UnstableStepError.at(
        SOLVER,
        fault,
        COLLAPSE_ADVICE if collapsed else ADVICE,
        time=solver.time,
        step=solver.steps,
        particle=particle,
        position=(x, y, z),
    )


def body_fault(solver: MpmSolver, bits: int, number: int) -> UnstableStepError:
    """Tell the fault of a rigid body."""
    body = solver.bodies[number]
    x, y, z = (1e3 * float(c) for c in body.position)
    fault = "has a value that is not finite"
    if bits & COLLAPSED:
        fault = "is so fast that no time step is left"
    elif bits & UNSOLVED:
        fault = "has a contact whose impulses could not be found to a thousandth of its velocity"
    return UnstableStepError(
        SOLVER,
        f"{body.name} {fault} at ({x:.2f}, {y:.2f}, {z:.2f}) mm, "
        f"t = {solver.time:.6g} s, step {solver.steps}",
        "Check its mass, velocity and friction, or try a smaller courant_number (0.3).",
    )
