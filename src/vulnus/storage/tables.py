"""Signals, volumes and profiles of a run as CSV, with the unit in each column's name."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from vulnus.core.arrays import FloatArray
from vulnus.core.errors import StorageError
from vulnus.core.handoff import BleedLedger, BleedWaveforms
from vulnus.core.units import MILLILITRE, MILLILITRE_PER_MINUTE, MILLIMETRE_OF_MERCURY

WAVEFORM_COLUMNS = {
    "t_s": ("time", 1.0),
    "pressure_aorta_mmHg": ("pressure_aorta", MILLIMETRE_OF_MERCURY),
    "pressure_artery_mmHg": ("pressure_artery", MILLIMETRE_OF_MERCURY),
    "pressure_injury_mmHg": ("pressure_injury", MILLIMETRE_OF_MERCURY),
    "flow_injury_ml_per_min": ("flow_injury", MILLILITRE_PER_MINUTE),
}
"""Column of `waveforms.csv` to the signal and the column's unit in SI."""

LEDGER_COLUMNS = {
    "t_s": ("time", 1.0),
    "injected_ml": ("injected", MILLILITRE),
    "in_limb_ml": ("in_limb", MILLILITRE),
    "out_of_limb_ml": ("out_of_limb", MILLILITRE),
    "removed_ml": ("removed", MILLILITRE),
    "pending_ml": ("pending", MILLILITRE),
}
"""Column of `ledger.csv` to the volume and the column's unit in SI."""

Columns = dict[str, tuple[str, float]]


def as_csv(signals: BleedWaveforms | BleedLedger | None, columns: Columns) -> str:
    """The table's text; the header alone where no artery bled."""
    if signals is None:
        return table_text(dict.fromkeys(columns, np.zeros(0)))
    return table_text(
        {title: getattr(signals, name) / unit for title, (name, unit) in columns.items()}
    )


def table_text(columns: Mapping[str, FloatArray]) -> str:
    """Columns (n,) by their title as CSV."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    for row in zip(*columns.values(), strict=True):
        writer.writerow([f"{value:.9g}" for value in row])
    return text.getvalue()


def read_csv(path: Path, columns: Columns) -> dict[str, FloatArray]:
    """The signals in SI by their field's name."""
    try:
        with path.open(newline="") as stream:
            header, *rows = list(csv.reader(stream))
        if header != list(columns):
            raise ValueError(f"the columns are {', '.join(header)}")
        table = np.array(rows, dtype=np.float64).reshape(-1, len(columns))
    except (OSError, ValueError) as trouble:
        raise StorageError(
            str(path),
            f"the table cannot be read ({trouble})",
            "Run the scenario again, or restore the file",
        ) from trouble
    return {name: table[:, place] * unit for place, (name, unit) in enumerate(columns.values())}
