"""What a reader of a wound report has to know about the run behind it."""

from __future__ import annotations

from collections.abc import Iterator

from vulnus.core.handoff import CavityHistory
from vulnus.core.units import MILLIMETRE, MILLISECOND

from .run_end import collapse_time
from .setup import ShotSetup

CELLS_ACROSS = 5.0
"""Cells that a projectile should span (PHYSICS 1.6)."""


def notes_of(setup: ShotSetup, history: CavityHistory) -> tuple[str, ...]:
    """Sentences about what the grid and the length of the run do to the numbers."""
    return (*_coarse(setup), *_open(setup, history))


def _coarse(setup: ShotSetup) -> Iterator[str]:
    """A blade cuts whatever cells it meets; what flies pushes aside more than its own width."""
    cell = setup.parameters.grid_spacing
    names = [body.name for body in setup.bodies]
    for name, projectile in dict(zip(names, setup.projectiles, strict=True)).items():
        cells = projectile.diameter / cell
        if projectile.shape != "blade" and cells < CELLS_ACROSS * (1.0 - 1e-9):
            yield (
                f"{name} spans {cells:.2g} cells of {cell / MILLIMETRE:g} mm; below "
                f"{CELLS_ACROSS:g} it acts as if it were thicker and leaves too much energy: "
                f"grid_spacing_mm = {projectile.diameter / CELLS_ACROSS / MILLIMETRE:.2g} "
                "would do"
            )


def _open(setup: ShotSetup, history: CavityHistory) -> Iterator[str]:
    if setup.parameters.mode == "full" and collapse_time(history) is None:
        yield (
            f"the temporary cavity has not collapsed at {history.time[-1] / MILLISECOND:.3g} ms, "
            "the end of the run: the permanent state is still in motion"
        )
