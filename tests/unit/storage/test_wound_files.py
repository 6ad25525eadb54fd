"""The files of a wound: states, field and tables hold what the report says."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from reference.injury_outcomes import injury_outcome

from vulnus.storage.wound_files import write_wound_files

from .test_handoff_file import injured_limb


def columns(path: Path) -> dict[str, np.ndarray]:
    with path.open() as stream:
        header, *rows = list(csv.reader(stream))
    return dict(zip(header, np.array(rows, float).T, strict=True))


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    write_wound_files(tmp_path, injury_outcome(injured_limb()))
    return tmp_path


def test_states_and_field_open_as_vtkhdf(directory: Path) -> None:
    import h5py

    for name in ("temporary", "permanent"):
        with h5py.File(directory / f"{name}.vtkhdf") as file:
            assert file["VTKHDF"].attrs["Type"] == b"PolyData"
            assert set(file["VTKHDF/PointData"]) == {"damage", "displacement_m", "tissue"}
    with h5py.File(directory / "field.vtkhdf") as file:
        root = file["VTKHDF"]
        assert root.attrs["Type"] == b"ImageData"
        assert list(root.attrs["WholeExtent"]) == [0, 2, 0, 3, 0, 4]
        assert root["PointData/void"].shape == (5, 4, 3)  # z, y, x


def test_tables_have_their_units(directory: Path) -> None:
    cavity = columns(directory / "cavity.csv")
    assert cavity["t_ms"][-1] == pytest.approx(2.0)
    assert cavity["cavity_volume_ml"].max() == pytest.approx(30.0)
    tract = columns(directory / "tract.csv")
    assert tract["arc_length_mm"][-1] == pytest.approx(40.0)
    assert tract["temporary_radius_mm"][0] == pytest.approx(20.0)
    energy = columns(directory / "energy.csv")
    assert energy["energy_j"].sum() == pytest.approx(20.0)
    assert energy["path_to_mm"][-1] == pytest.approx(40.0)
