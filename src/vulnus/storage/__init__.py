"""The run directory: frames, checkpoints, tables, summary and provenance; no physics."""

from __future__ import annotations

from .checkpoint_file import FileCheckpoint
from .frame_series import FrameSeries
from .run_store import RunStore, StageReachedError
from .stage_book import StageBook
from .summary import summarise
from .whole_file import replaced_whole, storage_error, write_whole

__all__ = [
    "FileCheckpoint",
    "FrameSeries",
    "RunStore",
    "StageBook",
    "StageReachedError",
    "replaced_whole",
    "storage_error",
    "summarise",
    "write_whole",
]
