"""Errors that a user can act on: what, where, which limit, and what to do next.

Every error that vulnus raises on purpose is a `VulnusError`. The command line prints it as one
block and exits with the class's code; a traceback means a defect in vulnus, not in the input.
"""

from __future__ import annotations


class VulnusError(Exception):
    """Base of all errors about input, files or an unstable computation.

    `subject` names the file, key or quantity, `problem` says what is wrong with its value and
    what the limit is, `advice` says what to do next.
    """

    exit_code = 1

    def __init__(self, subject: str, problem: str, advice: str) -> None:
        super().__init__(f"{subject}: {problem}. {advice}")
        self.subject = subject
        self.problem = problem
        self.advice = advice

    def __reduce__(self) -> tuple[type[VulnusError], tuple[str, str, str]]:
        return type(self), (self.subject, self.problem, self.advice)


class ScenarioError(VulnusError):
    """A scenario file, or a key in it, cannot be used."""

    exit_code = 2


class InputFileError(VulnusError):
    """An input file is missing, truncated, or does not hold what its format promises."""

    exit_code = 3


class AnatomyError(VulnusError):
    """The limb lacks something that a later stage needs (no bone, empty skin, no artery)."""

    exit_code = 4


class ProjectileError(VulnusError):
    """The projectile's line misses the limb or starts where it cannot."""

    exit_code = 5


class CirculationError(VulnusError):
    """An arterial table or an injury port is not physical."""

    exit_code = 6


class UnstableStepError(VulnusError):
    """A native solver met a value that is not finite, an inverted particle or an escape."""

    exit_code = 7

    def __init__(self, solver: str, problem: str, advice: str) -> None:
        super().__init__(solver, problem, advice)

    @classmethod
    def at(
        cls,
        solver: str,
        fault: str,
        advice: str,
        *,
        time: float,
        step: int,
        particle: int,
        position: tuple[float, float, float],
    ) -> UnstableStepError:
        """Describe a fault by its particle, place [m], time [s] and step."""
        x, y, z = (1e3 * component for component in position)
        place = f"({x:.2f}, {y:.2f}, {z:.2f}) mm"
        problem = f"{fault} at particle {particle}, {place}, t = {time:.6g} s, step {step}"
        return cls(solver, problem, advice)


class StorageError(VulnusError):
    """A run directory cannot be written or read."""

    exit_code = 8


class RenderError(VulnusError):
    """Pictures cannot be made with what is installed."""

    exit_code = 9
