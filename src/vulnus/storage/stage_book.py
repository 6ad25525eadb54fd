"""Which stages of a run are finished, what they handed on, and what they cost."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from typing import TypeVar

from .checkpoint_file import FileCheckpoint
from .run_store import RunStore, StageReachedError

HandOff = TypeVar("HandOff")
Cost = dict[str, float]


class StageBook:
    """Runs each stage once in the life of a run directory, and keeps its result there.

    `say` receives one sentence a stage; `until` names the last stage to run, None for all.
    """

    def __init__(self, store: RunStore, say: Callable[[str], None], until: str | None) -> None:
        self.store = store
        self.cost: dict[str, Cost] = {}
        """Stage to `wall` [s], over all sessions, and `peak_memory` [byte] until its end."""
        self._say = say
        self._until = until

    def stage(
        self,
        name: str,
        kind: type[HandOff],
        compute: Callable[[FileCheckpoint], HandOff],
        report: Callable[[HandOff], None] | None = None,
    ) -> Callable[[], HandOff]:
        """The result of stage `name`, to be called for: kept from before, or computed now.

        A kept result is only read where a later stage or `report` asks for it. `report` writes
        what the user reads of the result, also where the run ends with this stage.
        """
        known: list[HandOff] = []
        cost = self.store.stage_cost(name)
        if cost is None:
            known.append(self._run(name, compute))
        else:
            self.cost[name] = cost
            self._say(f"{name}: kept from before")

        def result() -> HandOff:
            if not known:
                kept = self.store.load_stage(name, kind)
                self._tell_notices()
                known.append(self._run(name, compute) if kept is None else kept)
            return known[0]

        if report is not None:
            report(result())
        self.skip(name)
        return result

    def skip(self, name: str) -> None:
        """Go past stage `name`; the run ends here if it was to."""
        if name == self._until:
            raise StageReachedError(name)

    def _run(self, name: str, compute: Callable[[FileCheckpoint], HandOff]) -> HandOff:
        checkpoint = self.store.checkpoint(name)
        result = compute(checkpoint)
        self._tell_notices()
        self.cost[name] = {"wall": checkpoint.wall, "peak_memory": peak_memory()}
        self.store.save_stage(name, result, self.cost[name])
        self._say(f"{name}: {_duration(checkpoint.wall)}")
        return result

    def _tell_notices(self) -> None:
        while self.store.notices:
            self._say(f"note: {self.store.notices.pop(0)}")


def peak_memory() -> float:
    """The most memory [byte] that this process, or one that it started, has held so far."""
    most = max(resource.getrusage(who).ru_maxrss for who in (0, resource.RUSAGE_CHILDREN))
    return 1024.0 * most


def _duration(seconds: float) -> str:
    if seconds < 60.0:
        return f"{seconds:.1f} s"
    return time.strftime("%M min %S s" if seconds < 3600 else "%H h %M min", time.gmtime(seconds))
