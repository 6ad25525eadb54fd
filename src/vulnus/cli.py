"""The command `vulnus`: run scenarios, draw pictures again, look at what is installed."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import cyclopts
from cyclopts import App, Parameter

from vulnus import __version__
from vulnus.core.errors import StorageError, VulnusError
from vulnus.core.units import GRAM, MILLIMETRE

if TYPE_CHECKING:
    from rich.console import Console

    from vulnus.core.progress import Progress

USAGE_EXIT_CODE = 2
DEFECT_EXIT_CODE = 70
"""sysexits.h EX_SOFTWARE: an internal error."""

app = App(
    name="vulnus",
    help="What a penetrating injury does to a limb, from the CT scan to the blood on the floor.\n\n"
    "Start with `vulnus demo`; `vulnus scenario show demo` prints all that can be changed.",
    version=__version__,
    default_parameter=Parameter(negative=()),
    suppress_keyboard_interrupt=False,
)
scenario_app = App(name="scenario", help="List and print scenarios.")
app.command(scenario_app)
gallery_app = App(name="gallery", help="Make the pictures of the handbook anew.")
app.command(gallery_app)

RunDirectory = Annotated[
    Path | None,
    Parameter(name=("--output", "-o"), help="Run directory; it is made if it is not there."),
]
Resume = Annotated[
    bool, Parameter(help="Go on with the run in the directory, from what it has finished.")
]


@app.command
def demo(*, output: RunDirectory = None, resume: Resume = False) -> None:
    """Shoot the built-in leg and let it bleed: pictures, film, curves and numbers in minutes.

    The run goes to runs/demo (or runs/demo-2 and so on where that is taken).
    """
    _run("demo", output or _free_directory(Path("runs"), "demo"), resume=resume, until=None)


@app.command
def run(
    scenario: Annotated[
        str | None,
        Parameter(help="Scenario file (.toml) or preset. Default with --resume: the run's own."),
    ] = None,
    *,
    output: RunDirectory = None,
    resume: Resume = False,
    until: Annotated[
        str | None,
        Parameter(
            help="Last stage to run: imaging, anatomy, injury, circulation, hemorrhage or "
            "visualization."
        ),
    ] = None,
) -> None:
    """Run a scenario, every stage of it, into a run directory."""
    if output is None:
        raise StorageError("-o", "no run directory was given", "Add -o DIRECTORY")
    if scenario is None:
        kept = output / "scenario.toml"
        if not (resume and kept.is_file()):
            raise StorageError(
                str(output),
                "no scenario was given, and there is no run here to go on with",
                "Name a scenario file or a preset (vulnus scenario list)",
            )
        scenario = str(kept)
    _run(scenario, output, resume=resume, until=until)


@app.command
def render(
    run_directory: Annotated[Path, Parameter(help="What `vulnus run ... -o DIRECTORY` wrote.")],
) -> None:
    """Draw the pictures, figures and film of a run again, without simulating."""
    from vulnus.pipeline import draw_again
    from vulnus.scenario import scenario_from_text
    from vulnus.storage import RunStore
    from vulnus.terminal import notes_said

    console = _console()
    with (
        RunStore.open(run_directory) as store,
        _stoppable(f"vulnus render {run_directory}"),
        notes_said(_speaker(console)),
    ):
        file = run_directory / "scenario.toml"
        scenario = scenario_from_text(file.read_text(encoding="utf-8"), file=str(file))
        drawn = draw_again(scenario, store, _progress(console), say=_speaker(console))
    for path in drawn:
        print(path)


@app.command
def doctor() -> int:
    """Say what is installed, what is missing and how to get it; exit code 0 when the core works."""
    from rich.console import Console
    from rich.table import Table

    from vulnus.doctor import examine

    signs = {True: "[green]ok", False: "[red]missing", None: "[yellow]optional"}
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in ("", "what", "found", "what to do"):
        table.add_column(title, overflow="fold")
    console = Console()
    well = True
    with console.status("looking around"):
        for finding in examine():
            table.add_row(signs[finding.good], finding.name, finding.found, finding.advice)
            well = well and finding.good is not False
    console.print(table)
    console.print(
        "[green]The core works." if well else "[red]The core does not work; see the lines above."
    )
    return 0 if well else 1


@app.command
def validate(
    stage: Annotated[str, Parameter(help="Stage to validate: injury.")],
    *,
    case: Annotated[
        list[str] | None,
        Parameter(help="Cases to run, such as M1 M4; default all.", consume_multiple=True),
    ] = None,
    quick: Annotated[bool, Parameter(help="Coarser and shorter, to try it out.")] = False,
    list_: Annotated[bool, Parameter(name="--list", help="Only list the cases.")] = False,
    plots: Annotated[
        bool, Parameter(help="Write plot.png into each case's folder (or the -o directory).")
    ] = False,
    output: Annotated[
        Path | None, Parameter(name=("--output", "-o"), help="Write results.json and plots here.")
    ] = None,
    json: Annotated[bool, Parameter(help="Print JSON instead of the table.")] = False,
) -> int:
    """Compare a stage with closed forms and published experiments; exit code 1 if one fails."""
    from vulnus.terminal import notes_said
    from vulnus.validation.command import ValidationWishes, list_cases, run_validation

    if list_:
        list_cases(stage)
        return 0
    wishes = ValidationWishes(
        stage=stage, ids=tuple(case or ()), quick=quick, plots=plots, output=output, json=json
    )
    console = _console()
    with _stoppable(f"vulnus validate {stage} --case ..."), notes_said(_speaker(console)):
        return run_validation(wishes, _progress(console), console)


@gallery_app.command(name="injury")
def draw_injury(
    *,
    output: RunDirectory = None,
    labels: Annotated[
        Path | None, Parameter(help="A label volume to shoot beside the built-in leg.")
    ] = None,
    mode: Annotated[str | None, Parameter(help="full or paper; the preset's is full.")] = None,
    grid_spacing_mm: Annotated[
        float | None, Parameter(help="Edge of a grid cell [mm]; the preset's is 2.")
    ] = None,
) -> None:
    """Shoot the built-in leg (and a label volume) and draw the paper's Figs. 2 and 3 of it.

    Pictures are passage_NAME.jpg (Fig. 2), wound_NAME.jpg (Fig. 3) and report_NAME.png; the runs
    stay below in runs/, and the command goes on with what is finished there.
    """
    from vulnus.gallery import GalleryWishes, injury_gallery
    from vulnus.terminal import notes_said

    directory = output or Path("runs/gallery")
    spacing = None if grid_spacing_mm is None else grid_spacing_mm * MILLIMETRE
    wishes = GalleryWishes(labels=labels, mode=mode, grid_spacing=spacing)
    console = _console()
    with (
        _stoppable("the same command"),
        notes_said(_speaker(console)),
    ):
        for path in injury_gallery(directory, wishes, _progress(console), _speaker(console)):
            print(path)


@scenario_app.command(name="list")
def list_scenarios() -> None:
    """List the presets and what each is for."""
    from vulnus.scenario import preset_purposes

    for name, purpose in preset_purposes().items():
        print(f"{name:<28} {purpose}")


@app.command
def projectiles() -> None:
    """List the projectiles that a scenario may name: shape, mass, size, speed and source."""
    from vulnus.injury import PROJECTILES

    line = "{:<21}{:<10}{:>7}  {:<12}{:<16}{}"
    print(line.format("name", "shape", "mass g", "size mm", "speed m/s", "source"))
    for row in PROJECTILES.values():
        sizes = (row.diameter, row.length) if row.diameter else (row.length, row.width)
        size = " x ".join(f"{value / MILLIMETRE:g}" for value in sizes if value)
        low, high = row.speed_range
        speed = f"{row.speed:g} ({low:g}-{high:g})"
        print(line.format(row.name, row.shape, f"{row.mass / GRAM:g}", size, speed, row.source))


@scenario_app.command
def show(
    scenario: Annotated[str, Parameter(help="Preset or scenario file (.toml).")],
) -> None:
    """Print the complete scenario, every default with its meaning, unit and limits, as TOML."""
    from vulnus.scenario import scenario_text

    print(scenario_text(scenario), end="")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and give back its exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        result = app(words, exit_on_error=False, result_action="return_value")
    except cyclopts.CycloptsError:
        return USAGE_EXIT_CODE  # cyclopts has said what is wrong
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 1
    except (Exception, KeyboardInterrupt) as trouble:
        return _exit_code_of(trouble)
    return result if isinstance(result, int) else 0


def _exit_code_of(trouble: BaseException) -> int:
    """Say what happened, as far as it was not said yet, and give the exit code for it."""
    if isinstance(trouble, VulnusError):
        _tell_error(trouble)
        return trouble.exit_code
    if isinstance(trouble, KeyboardInterrupt):
        from vulnus.terminal import Terminated

        return 128 + (signal.SIGTERM if isinstance(trouble, Terminated) else signal.SIGINT)
    if isinstance(trouble, BrokenPipeError):  # for example `vulnus scenario show demo | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    return _tell_defect(trouble)


def _run(source: str, directory: Path, *, resume: bool, until: str | None) -> None:
    from vulnus.pipeline import check_stage, run_scenario
    from vulnus.scenario import load_scenario
    from vulnus.storage import RunStore
    from vulnus.terminal import notes_said

    scenario = load_scenario(source)
    check_stage(until)
    console = _console()
    say = _speaker(console)
    say(f"{scenario.title}: {directory}")
    with (
        RunStore.create(
            directory,
            scenario.text,
            resume=resume,
            checkpoint_interval=scenario.checkpoint_interval,
        ) as store,
        _stoppable(f"vulnus run -o {directory} --resume"),
        notes_said(say),
    ):
        summary = run_scenario(scenario, store, _progress(console), until=until, say=say)
    _print_summary(summary, directory)


def _free_directory(parent: Path, name: str) -> Path:
    """`parent/name`, or with the first number behind it that is not taken."""
    path, number = parent / name, 1
    while path.exists():
        number += 1
        path = parent / f"{name}-{number}"
    return path


def _console() -> Console:
    from rich.console import Console

    return Console(stderr=True, highlight=False)


def _speaker(console: Console) -> Callable[[str], None]:
    from rich.text import Text

    return lambda text: console.print(Text(text), soft_wrap=True)


def _progress(console: Console) -> Progress:
    from vulnus.terminal import BarProgress, LineProgress

    return BarProgress(console) if console.is_terminal else LineProgress(_speaker(console))


def _stoppable(resume_command: str) -> Any:
    """Ctrl-C and SIGTERM end the block within a second and say how to go on."""
    from vulnus.terminal import stopped_by_signals

    def last_words(number: int) -> None:
        name = signal.Signals(number).name
        sys.stderr.write(
            f"\nstopped ({name}); what was finished is kept. Go on with: {resume_command}\n"
        )

    return stopped_by_signals(last_words)


def _print_summary(summary: Any, directory: Path) -> None:
    from rich.table import Table

    from vulnus.terminal import summary_rows

    table = Table(box=None, show_header=False, pad_edge=False)
    for name, value in summary_rows(summary):
        table.add_row(name, value)
    console = _console()
    console.print(table)
    console.print(f"in {directory}", highlight=False, soft_wrap=True)


def _tell_error(error: VulnusError) -> None:
    from rich.text import Text

    text = Text.assemble(("error: ", "bold red"), (error.subject, "bold"))
    for sentence in (f": {error.problem}", f"\n{error.advice}"):
        text.append(sentence if sentence.endswith((".", "?", "!")) else f"{sentence}.")
    _console().print(text, soft_wrap=True)


def _tell_defect(error: BaseException) -> int:
    if os.environ.get("VULNUS_DEBUG") == "1":
        raise error
    if isinstance(error, MemoryError):
        sys.stderr.write(
            "error: the memory is used up. Take a larger particle_spacing_mm or voxel_mm, or a "
            "machine with more memory; --resume goes on from what was finished.\n"
        )
        return 1
    sys.stderr.write(
        f"error: {type(error).__name__}: {error}\n"
        "This is a defect in vulnus, not in your input; what was finished is kept, and --resume "
        "goes on. VULNUS_DEBUG=1 shows where it happened.\n"
    )
    return DEFECT_EXIT_CODE
