"""Bad input through the real command: a clear error, its own exit code, nothing finished lost."""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vulnus.cli import main
from vulnus.core.errors import AnatomyError, InputFileError, ProjectileError, StorageError
from vulnus.core.handoff import LabelVolume, Tissue
from vulnus.core.units import MILLIMETRE
from vulnus.imaging import ImagingParameters, generate_leg

pytestmark = pytest.mark.regression

TINY = Path(__file__).with_name("tiny.toml").read_text()
SMALL_FILES = 120_000
"""Largest file [byte] on the disk that stands for a full one: the labels fit, the limb does not."""


@pytest.fixture(scope="module")
def leg() -> LabelVolume:
    return generate_leg(ImagingParameters(voxel=4e-3))


def write_volume(folder: Path, leg: LabelVolume, labels: np.ndarray) -> Path:
    """A NRRD file of five labels, and its arteries as JSON beside it."""
    import nrrd

    five = np.where(np.isin(labels, [Tissue.FAT]), Tissue.MUSCLE, labels)
    five = np.where(np.isin(five, [Tissue.MARROW, Tissue.CANCELLOUS]), Tissue.BONE, five)
    header = {
        "space": "left-posterior-superior",
        "space directions": (leg.direction * leg.spacing).T / MILLIMETRE,
        "space origin": leg.origin / MILLIMETRE,
    }
    path = folder / "leg.nrrd"
    nrrd.write(str(path), five.astype(np.uint8), header)
    segments = [
        {
            "name": artery.name,
            "points_mm": (artery.points / MILLIMETRE).tolist(),
            "radius_mm": (artery.radius / MILLIMETRE).tolist(),
            "parent": artery.parent,
        }
        for artery in leg.arteries
    ]
    arteries = {"space": "LPS", "units": "mm", "segments": segments}
    (folder / "artery_centrelines.json").write_text(json.dumps(arteries))
    return path


def scenario(folder: Path, **keys: str) -> Path:
    """The tiny scenario with other values: table__key = "TOML value"."""
    text = TINY
    for name, value in keys.items():
        table, _, key = name.replace("__", ".").rpartition(".")
        lines = [line for line in text.splitlines() if not line.startswith(f"{key} =")]
        if f"[{table}]" not in lines:
            lines.append(f"[{table}]")
        lines.insert(lines.index(f"[{table}]") + 1, f"{key} = {value}")
        text = "\n".join(lines)
    path = folder / "mine.toml"
    path.write_text(text)
    return path


def test_a_label_file_runs(tmp_path: Path, leg: LabelVolume) -> None:
    write_volume(tmp_path, leg, leg.labels)
    mine = scenario(tmp_path, imaging__source='"leg.nrrd"')
    assert main(["run", str(mine), "-o", str(tmp_path / "run"), "--until", "anatomy"]) == 0


def test_a_truncated_volume(
    tmp_path: Path, leg: LabelVolume, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_volume(tmp_path, leg, leg.labels)
    path.write_bytes(path.read_bytes()[:2000])
    mine = scenario(tmp_path, imaging__source='"leg.nrrd"')
    code = main(["run", str(mine), "-o", str(tmp_path / "run")])
    said = capsys.readouterr().err
    assert code == InputFileError.exit_code
    assert "leg.nrrd" in said
    assert "Traceback" not in said


def test_a_volume_without_bone(
    tmp_path: Path, leg: LabelVolume, capsys: pytest.CaptureFixture[str]
) -> None:
    soft = np.isin(leg.labels, [Tissue.BONE, Tissue.MARROW, Tissue.CANCELLOUS])
    write_volume(tmp_path, leg, np.where(soft, Tissue.MUSCLE, leg.labels))
    mine = scenario(tmp_path, imaging__source='"leg.nrrd"')
    code = main(["run", str(mine), "-o", str(tmp_path / "run")])
    said = capsys.readouterr().err
    assert code in (InputFileError.exit_code, AnatomyError.exit_code)
    assert "bone" in said


def test_a_projectile_that_misses_keeps_the_limb(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = scenario(tmp_path, injury__aim__target_mm="[900.0, 0.0, 0.0]")
    where = ["-o", str(tmp_path / "run")]
    assert main(["run", str(mine), *where]) == ProjectileError.exit_code
    assert "beside the limb" in capsys.readouterr().err
    assert (tmp_path / "run" / "checkpoints" / "anatomy.h5").exists()
    assert main(["run", str(mine), *where, "--resume"]) == ProjectileError.exit_code
    assert "anatomy: kept" in capsys.readouterr().err


def test_a_shot_away_from_vessels_cuts_none_and_ends_well(
    tmp_path: Path, leg: LabelVolume, capsys: pytest.CaptureFixture[str]
) -> None:
    """Through the calf's medial edge, from behind: only skin, fat and muscle are there."""
    height = float(leg.arteries[1].points[:, 2].mean())
    place = np.argwhere(leg.labels > 0) * leg.spacing @ leg.direction.T + leg.origin
    slab = place[np.abs(place[:, 2] - height) < 0.02]
    medial = slab[slab[:, 0] < slab[:, 0].min() + 0.012]  # the left leg's medial side is right
    target = (1e3 * medial.mean(axis=0)).round(1).tolist()
    mine = scenario(
        tmp_path,
        injury__aim__target_mm=str(target),
        injury__aim__azimuth_deg="180.0",
        injury__projectile__diameter_mm="5.0",
        run__checkpoint_interval_s="20.0",
    )
    assert main(["run", str(mine), "-o", str(tmp_path / "run")]) == 0
    assert "cut no artery" in capsys.readouterr().err
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["wound"]["severed_segment"] is None
    assert summary["bleeding"]["injected_ml"] == 0.0


def test_a_full_disk_in_the_middle_loses_nothing_that_was_finished(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk: the system refuses to write more."""
    mine, run = scenario(tmp_path), tmp_path / "run"
    command = [sys.executable, "-m", "vulnus", "run", str(mine), "-o", str(run)]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (SMALL_FILES, SMALL_FILES)),
    )
    assert done.returncode == StorageError.exit_code, done.stderr
    assert "anatomy.h5" in done.stderr
    assert "--resume" in done.stderr
    assert (run / "checkpoints" / "imaging.h5").exists()
    assert list(run.rglob(".part-*")) == []
    assert main([*command[3:], "--resume", "--until", "anatomy"]) == 0
