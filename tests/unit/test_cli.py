"""What the command line says to every way of getting it wrong, and how fast it says it."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from vulnus import __version__
from vulnus.cli import main
from vulnus.core.errors import InputFileError, ScenarioError, StorageError


@pytest.fixture
def _same_directory_behind() -> Iterator[None]:
    before = Path.cwd()
    yield
    os.chdir(before)


def test_help_and_version_name_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    shown = capsys.readouterr().out
    for command in ("demo", "run", "render", "doctor", "scenario"):
        assert command in shown
    assert main(["--version"]) == 0
    assert __version__ in capsys.readouterr().out
    for command in (["run"], ["demo"], ["render"], ["doctor"], ["scenario"]):
        assert main([*command, "--help"]) == 0


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import sys, vulnus.cli\n"
        "vulnus.cli.main(['--help'])\n"
        "heavy = {'numpy', 'scipy', 'pydantic', 'h5py', 'matplotlib', 'SimpleITK'}\n"
        "sys.exit(str(sorted(heavy & set(sys.modules)))[1:-1] or 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_presets_are_listed_and_shown_as_valid_toml(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenario", "list"]) == 0
    names = [line.split()[0] for line in capsys.readouterr().out.splitlines()]
    assert {"demo", "tibial_vertical", "tibial_horizontal_platform"} <= set(names)
    for name in names:
        assert main(["scenario", "show", name]) == 0
        projectile = tomllib.loads(capsys.readouterr().out)["injury"]["projectile"]
        assert projectile["name"] != "auto" or projectile["diameter_mm"] > 0


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["run", "nothing.toml", "-o", "run"], ScenarioError.exit_code, ["nothing.toml", "demo"]),
        (["run", "dmo", "-o", "run"], ScenarioError.exit_code, ["Did you mean demo?"]),
        (["run", "demo"], StorageError.exit_code, ["-o DIRECTORY"]),
        (["run", "demo", "-o", "file"], StorageError.exit_code, ["not a directory"]),
        (["run", "-o", "run", "--resume"], StorageError.exit_code, ["no scenario was given"]),
        (["run", "demo", "-o", "run", "--until", "x"], ScenarioError.exit_code, ["Stages:"]),
        (["render", "run"], StorageError.exit_code, ["does not exist"]),
        (["scenario", "show", "x.toml"], ScenarioError.exit_code, ["x.toml"]),
        (["run", "far.toml", "-o", "run"], InputFileError.exit_code, ["far.nrrd", "no such file"]),
        (["run", "bad.toml", "-o", "run"], ScenarioError.exit_code, ["diameter_mm = -9", "> 0"]),
        (["frobnicate"], 2, ["frobnicate"]),
        (["run", "demo", "--nonsense"], 2, ["nonsense"]),
    ],
)
@pytest.mark.usefixtures("_same_directory_behind")
def test_a_wrong_call_is_answered_in_one_block(
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
    arguments: list[str],
    code: int,
    words: list[str],
) -> None:
    os.chdir(tmp_path)
    Path("file").write_text("x")
    Path("far.toml").write_text('[imaging]\nsource = "far.nrrd"')
    Path("bad.toml").write_text("[injury.projectile]\ndiameter_mm = -9")
    assert main(arguments) == code
    said = capfd.readouterr()
    for word in words:
        assert word in said.err + said.out
    assert "Traceback" not in said.err
    assert not Path("run").exists()


def test_a_defect_shows_where_it_is_only_when_asked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import vulnus.scenario

    def fail() -> None:
        raise ZeroDivisionError("odd")

    monkeypatch.setattr(vulnus.scenario, "preset_purposes", fail)
    assert main(["scenario", "list"]) == 70
    assert "ZeroDivisionError: odd" in capsys.readouterr().err
    monkeypatch.setenv("VULNUS_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        main(["scenario", "list"])


def test_doctor_says_what_is_missing_and_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from vulnus import doctor

    monkeypatch.setattr(doctor, "_llvm", lambda: doctor.Finding("LLVM", True, "not tried"))
    monkeypatch.setitem(doctor.CORE_PACKAGES, "numpy", "numpy_is_gone")
    monkeypatch.setenv("COLUMNS", "200")
    assert main(["doctor"]) == 1
    shown = capsys.readouterr().out
    assert "not installed" in shown
    assert "make demo" in shown
    for name in ("Python", "OpenMP", "native code: injury", "memory", "disk"):
        assert name in shown
