"""The paper's chain, from the labelled limb to the blood (Chong et al. 2017, section 2)."""

from __future__ import annotations

import ctypes
import difflib
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from vulnus import anatomy, circulation, coupling, hemorrhage, imaging, injury, visualization
from vulnus.core.checkpoint import Checkpoint
from vulnus.core.errors import ScenarioError, StorageError
from vulnus.core.handoff import (
    BleedOutcome,
    BleedWaveforms,
    InjuredLimb,
    InjuryOutcome,
    LabelVolume,
    LimbModel,
)
from vulnus.core.progress import Progress, SilentProgress
from vulnus.scenario import Scenario, differences
from vulnus.storage import (
    FrameSeries,
    RunStore,
    StageBook,
    StageReachedError,
    storage_error,
    summarise,
)

STAGES = ("imaging", "anatomy", "injury", "circulation", "hemorrhage", "visualization")
"""The stages in their order; the coupling of tree and blood belongs to hemorrhage."""

Say = Callable[[str], None]


def run_scenario(
    scenario: Scenario,
    store: RunStore,
    progress: Progress | None = None,
    *,
    until: str | None = None,
    say: Say = lambda _: None,
) -> Mapping[str, Any]:
    """Run what `store` does not hold yet, up to the stage `until`; the content of `summary.json`.

    `say` receives what happens, one sentence at a time.
    """
    check_stage(until)
    refuse_another_scenario(scenario, store)
    if store.is_finished():
        say("this run is finished: nothing is left to do (vulnus render draws it again)")
        return store.read_summary()
    use_threads(scenario.threads)
    book = StageBook(store, say, until)
    try:
        with store.session(
            sys.argv, seed=scenario.seed, threads=scenario.threads, inputs=scenario.inputs
        ):
            _follow_the_paper(scenario, store, book, progress or SilentProgress(), say)
    except StageReachedError:
        say(f"stopped after {until}, as asked; --resume goes on")
    return store.read_summary()


def _follow_the_paper(
    scenario: Scenario, store: RunStore, book: StageBook, progress: Progress, say: Say
) -> None:
    """Section 2: anatomy from images (2.1), the injury (2.2), the bleeding (2.3)."""
    labels = book.stage(
        "imaging", LabelVolume, lambda _: imaging.load_labels(scenario.imaging, progress)
    )
    limb = book.stage(
        "anatomy",
        LimbModel,
        lambda _: anatomy.build_limb(labels(), scenario.anatomy, progress),
    )
    outcome = book.stage(
        "injury",
        InjuryOutcome,
        lambda kept: injury.shoot(
            limb(),
            scenario.injury,
            on_frame=store.save_injury,
            checkpoint=kept,
            progress=progress,
        ),
        report=lambda found: _write_wound(store, found, book),
    )

    def wound() -> InjuredLimb:
        return outcome().wound

    book.stage("circulation", BleedWaveforms, lambda _: _solve_tree(scenario, wound()))
    bleeding = None
    if wound().injuries:
        say(_describe_cut(wound()))
        bleeding = book.stage(
            "hemorrhage",
            BleedOutcome,
            lambda kept: _bleed(scenario, store, wound(), kept, progress),
            report=lambda bled: _write_results(store, outcome(), bled, book),
        )()
    else:
        say("the projectile cut no artery: nothing bleeds")
        _write_results(store, outcome(), None, book)
        book.skip("hemorrhage")
    book.stage("visualization", tuple, lambda _: _draw(scenario, store, progress, say))
    store.write_summary(summarise(outcome(), bleeding, book.cost))


def _write_wound(store: RunStore, injury: InjuryOutcome, book: StageBook) -> None:
    """Write the wound's files and what the summary says of it."""
    store.write_wound(injury)
    store.write_summary(summarise(injury, None, book.cost))


def _write_results(
    store: RunStore, injury: InjuryOutcome, bleeding: BleedOutcome | None, book: StageBook
) -> None:
    """Write the tables and the summary of a wound and its bleeding."""
    store.write_waveforms(bleeding.waveforms if bleeding else None)
    store.write_ledger(bleeding.ledger if bleeding else None)
    store.write_summary(summarise(injury, bleeding, book.cost))


def draw_again(
    scenario: Scenario,
    store: RunStore,
    progress: Progress | None = None,
    *,
    say: Say = lambda _: None,
) -> tuple[str, ...]:
    """Draw the pictures of the run in `store` again; the files."""
    use_threads(scenario.threads)
    return _draw(scenario, store, progress or SilentProgress(), say)


def check_stage(name: str | None) -> None:
    """Raise `ScenarioError` unless `name` is a stage or None."""
    if name is None or name in STAGES:
        return
    close = difflib.get_close_matches(name, STAGES, n=1, cutoff=0.5)
    raise ScenarioError(
        f"--until {name}",
        "there is no such stage",
        (f"Did you mean {close[0]}? " if close else "") + f"Stages: {', '.join(STAGES)}",
    )


def refuse_another_scenario(scenario: Scenario, store: RunStore) -> None:
    """Raise `StorageError` where the run in `store` was begun with other numbers."""
    if found := differences(store.scenario_text(), scenario.text):
        raise StorageError(
            str(store.path),
            f"the run was begun with another scenario: {'; '.join(found)}",
            "Choose another run directory with -o, or go on with the run's own scenario: "
            f"vulnus run -o {store.path} --resume",
        )


def use_threads(count: int) -> None:
    """Let the native loops of every stage use `count` threads; results do not depend on it."""
    os.environ["OMP_NUM_THREADS"] = str(count)
    try:
        ctypes.CDLL("libgomp.so.1").omp_set_num_threads(count)
    except OSError:
        return  # another OpenMP library reads the variable


def _solve_tree(scenario: Scenario, wound: InjuredLimb) -> BleedWaveforms:
    """One heartbeat of the uninjured tree, or of the first beat of bleeding (Fig. 4)."""
    if wound.injuries:
        port = circulation.open_injury_port(scenario.circulation, wound.injuries[0], wound.side)
        beat = port.bleed(scenario.coupling.initial_pressure)
        return BleedWaveforms(
            time=beat.time,
            pressure_aorta=beat.pressure_aorta,
            pressure_artery=beat.pressure_artery,
            pressure_injury=beat.pressure_injury,
            flow_injury=beat.flow_injury,
        )
    tree = circulation.build_tree(scenario.circulation, wound.side)
    segment, position = tree.locate("anterior_tibial", arc_fraction=0.5)
    nothing = np.zeros_like(tree.time)
    return BleedWaveforms(
        time=tree.time,
        pressure_aorta=tree.pressure_aorta(),
        pressure_artery=tree.pressure(segment, position),
        pressure_injury=nothing,
        flow_injury=nothing,
    )


def _bleed(
    scenario: Scenario,
    store: RunStore,
    wound: InjuredLimb,
    kept: Checkpoint,
    progress: Progress,
) -> BleedOutcome:
    port = circulation.open_injury_port(scenario.circulation, wound.injuries[0], wound.side)
    blood = hemorrhage.prepare(wound, scenario.hemorrhage, progress)
    outcome = coupling.bleed_out(
        port,
        blood,
        scenario.coupling,
        on_frame=store.save_bleed,
        checkpoint=kept,
        progress=progress,
    )
    holes = blood.openings
    return replace(outcome, skin_open_area=holes.area, skin_sparse_area=holes.sparse_area)


def _draw(scenario: Scenario, store: RunStore, progress: Progress, say: Say) -> tuple[str, ...]:
    """Draw what the run in `store` has results for, as the scenario asks; the files."""
    outcome = store.load_stage("injury", InjuryOutcome)
    if outcome is None:
        raise StorageError(
            str(store.path),
            "the run has no finished injury to draw",
            f"Go on with it first: vulnus run -o {store.path} --resume",
        )
    wound = outcome.wound
    blood, platform = scenario.hemorrhage, scenario.hemorrhage.platform
    run = visualization.RunToDraw(
        wound=wound,
        report=outcome.report,
        projectiles=injury.projectile_surfaces(scenario.injury),
        surroundings=visualization.Surroundings(
            gravity=blood.gravity,
            platform_gap=platform.gap if platform else None,
            platform_point=platform.point if platform else None,
            platform_half_extent=platform.half_extent if platform else None,
        ),
        labels=store.load_stage("imaging", LabelVolume),
        beat=store.load_stage("circulation", BleedWaveforms),
        outcome=store.load_stage("hemorrhage", BleedOutcome),
        injury_frames=frames_on_demand(store.wound_frames),
        bleed_frames=frames_on_demand(store.bleed_frames) if wound.injuries else (),
        blood_spacing=blood.particle_spacing,
    )
    try:
        drawn = visualization.draw_all(run, scenario.visualization, store.path, progress)
    except OSError as trouble:
        raise storage_error(store.path / "figures", trouble) from trouble
    for complaint in drawn.complaints:
        say(f"note: {complaint}")
    return tuple(str(path) for path in drawn.files)


def frames_on_demand(series: FrameSeries) -> visualization.Frames:
    """The frames in files, each read when it is asked for."""
    indices = list(series.times())
    return visualization.FramesOnDemand(len(indices), lambda place: series.load(indices[place]))


def _describe_cut(wound: InjuredLimb) -> str:
    cut = wound.injuries[0]
    others = ", ".join(
        f"{other.artery.replace('_', ' ')} ({other.kind})" for other in wound.injuries[1:]
    )
    how = "cut" if cut.kind == "transected" else "holed (it bleeds as if it were cut)"
    return (
        f"the {cut.artery.replace('_', ' ')} artery is {how}, {1e3 * cut.gap:.0f} mm of it, at "
        f"{100 * cut.arc_fraction:.0f} % of its length"
        + (f"; also torn, but not bled: {others}" if others else "")
    )
