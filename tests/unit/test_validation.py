"""The validation command: which cases there are, what it prints, and its exit code."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from vulnus import cli
from vulnus.core.errors import InputFileError, ScenarioError
from vulnus.core.progress import SilentProgress
from vulnus.validation import (
    CaseReport,
    Comparison,
    Curve,
    Panel,
    catalogue,
    chosen_cases,
    find_cases,
    run_case,
)
from vulnus.validation.plot import draw_report

CASE = """
import numpy as np
from vulnus.core.errors import ProjectileError
from vulnus.validation import CaseReport, Comparison, Curve, Panel

def run(quick, progress):
    progress.begin("thinking", 1.0, "1")
    value = {value}
    {extra}
    x = np.linspace(0.0, 1.0, 5)
    return CaseReport(
        comparisons=(Comparison.within("answer", value, reference=42.0, unit="m", relative=0.01,
                                       source="a book"),),
        panels=(Panel(title="t", x="x / m", y="y / m", curves=(Curve(x=x, y=x, label="line"),)),),
    )
"""


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of cases: T1 agrees, T2 does not, T10 is refused by vulnus."""
    trouble = 'raise ProjectileError("ball", "misses", "Aim")'
    for name, value, extra in (
        ("T1_right", "42.1 if quick else 42.0", ""),
        ("T2a_wrong", "50.0", ""),
        ("T10_refused", "42.0", trouble),
    ):
        folder = tmp_path / "stage" / name
        folder.mkdir(parents=True)
        (folder / "case.py").write_text(CASE.format(value=value, extra=extra))
    (tmp_path / "stage" / "notes").mkdir()
    monkeypatch.setattr(catalogue, "PLACES", (tmp_path / "nowhere", tmp_path))
    return tmp_path


@pytest.mark.usefixtures("places")
def test_cases_are_found_in_the_order_of_their_numbers() -> None:
    cases = find_cases("stage")
    assert [case.id for case in cases] == ["T1", "T2a", "T10"]
    assert [case.name for case in cases] == ["right", "wrong", "refused"]
    assert [case.id for case in chosen_cases(cases, ["t10", "T1"])] == ["T1", "T10"]
    assert chosen_cases(cases, []) == cases
    with pytest.raises(ScenarioError, match=r"'T3' is not known. Known: T1, T2a, T10"):
        chosen_cases(cases, ["T3"])


def test_a_stage_without_cases_and_an_installation_without_any(tmp_path: Path, places) -> None:
    with pytest.raises(ScenarioError, match=r"'circulation' has no validation cases. .* stage"):
        find_cases("circulation", (places,))
    with pytest.raises(InputFileError, match="no validation cases are there"):
        find_cases("injury", (tmp_path / "a", tmp_path / "b"))


def test_the_cases_of_the_checkout_are_found_first() -> None:
    root = Path(__file__).parents[2] / "validation"
    assert all(case.folder.parent == root / "injury" for case in find_cases("injury"))


def test_the_wheel_carries_the_cases() -> None:
    """What pyproject maps into the package is where the loader looks second."""
    import tomllib

    text = (Path(__file__).parents[2] / "pyproject.toml").read_text()
    packages = tomllib.loads(text)["tool"]["scikit-build"]["wheel"]["packages"]
    (inside,) = (target for target, source in packages.items() if source == "validation")
    assert catalogue.PLACES[1].parts[-3:] == tuple(inside.split("/"))


@pytest.mark.usefixtures("places")
def test_agreement_and_disagreement() -> None:
    right, wrong, refused = (
        run_case(case, quick=False, progress=SilentProgress()) for case in find_cases("stage")
    )
    assert right.passed
    assert not wrong.passed
    assert wrong.error is None
    assert not refused.passed
    assert "ball: misses" in refused.error


@pytest.mark.usefixtures("places")
def test_exit_codes_and_tables(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["validate", "stage", "--case", "T1", "--quick"]) == 0
    shown = capsys.readouterr().out
    assert "42.1 m" in shown
    assert "agrees" in shown
    assert "1 of 1 cases agree (1 of 1 comparisons)" in shown
    assert cli.main(["validate", "stage"]) == 1
    shown = capsys.readouterr().out
    assert "FAILS" in shown
    assert "ball: misses" in shown
    assert cli.main(["validate", "stage", "--case", "T7"]) == 2
    assert cli.main(["validate", "circulation"]) == 2


@pytest.mark.usefixtures("places")
def test_listing(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["validate", "stage", "--list"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == [
        "T1",
        "T2a",
        "T10",
    ]


def test_results_and_plots_are_written(
    places: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    arguments = ["validate", "stage", "--case", "T1", "T2a", "-o", str(out), "--json"]
    assert cli.main(arguments) == 1
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((out / "results.json").read_text())
    assert [case["passed"] for case in printed] == [True, False]
    assert printed[1]["comparisons"][0]["value"] == 50.0
    assert (out / "T1_right.png").read_bytes().startswith(b"\x89PNG")
    assert cli.main(["validate", "stage", "--case", "T1", "--plots"]) == 0
    assert (places / "stage" / "T1_right" / "plot.png").is_file()


@pytest.mark.usefixtures("places")
def test_an_interrupt_shows_what_was_done(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from vulnus.validation import command

    def stopping(case, **options):
        if case.id == "T2a":
            raise KeyboardInterrupt
        return run_case(case, **options)

    monkeypatch.setattr(command, "run_case", stopping)
    assert cli.main(["validate", "stage"]) == 130
    assert "1 of 1 cases agree" in capsys.readouterr().out


def test_a_case_without_a_run_or_without_comparisons(places: Path) -> None:
    folder = places / "stage" / "T1_right"
    (folder / "case.py").write_text("x = 1\n")
    (case,) = chosen_cases(find_cases("stage"), ["T1"])
    assert "has no function run" in run_case(case, quick=True, progress=SilentProgress()).error
    (folder / "case.py").write_text("def run(quick, progress):\n    return None\n")
    assert "gave no comparisons" in run_case(case, quick=True, progress=SilentProgress()).error


@pytest.mark.parametrize(
    ("comparison", "passed"),
    [
        (Comparison.within("a", 1.009, reference=1.0, unit="1", source="s", relative=0.01), True),
        (Comparison.within("a", 1.011, reference=1.0, unit="1", source="s", relative=0.01), False),
        (Comparison.within("a", -1.5, reference=-1.0, unit="1", source="s", absolute=0.6), True),
        (Comparison.within("a", math.nan, reference=1.0, unit="1", source="s", relative=9), False),
        (Comparison.between("a", 3.0, lower=2.0, upper=4.0, unit="1", source="s"), True),
        (Comparison.between("a", 4.1, lower=2.0, upper=4.0, unit="1", source="s"), False),
        (Comparison.at_most("a", np.float32(1.0), limit=1.0, unit="1", source="s"), True),
        (Comparison.at_most("a", -math.inf, limit=1.0, unit="1", source="s"), False),
        (Comparison.at_least("a", 0.9, limit=1.0, unit="1", source="s"), False),
    ],
)
def test_verdicts(comparison: Comparison, passed: bool) -> None:
    assert comparison.passed is passed


def test_comparisons_and_curves_that_are_none() -> None:
    with pytest.raises(ValueError, match="either relative or absolute"):
        Comparison.within("a", 1.0, reference=1.0, unit="1", source="s")
    with pytest.raises(ValueError, match="line: x"):
        Curve(x=np.zeros(3), y=np.zeros(4), label="line")


def test_a_plot_has_a_pane_a_panel(tmp_path: Path) -> None:
    x = np.linspace(1.0, 2.0, 4)
    curves = (
        Curve(x=x, y=x, label="found"),
        Curve(x=x, y=x, label="known", kind="reference points", error=0.1 * x),
    )
    panels = tuple(
        Panel(title=str(n), x="x / m", y="y / m", curves=curves, logarithmic=n == 0)
        for n in range(4)
    )
    path = draw_report(CaseReport(comparisons=(), panels=panels), tmp_path / "p.png", title="case")
    assert path.stat().st_size > 10_000
