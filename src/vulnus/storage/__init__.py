"""The run directory: frames, checkpoints, tables, summary and provenance; no physics."""

from __future__ import annotations

from .checkpoint_file import FileCheckpoint
from .frame_series import FrameSeries
from .run_store import RunStore
from .whole_file import replaced_whole, storage_error, write_whole

__all__ = [
    "FileCheckpoint",
    "FrameSeries",
    "RunStore",
    "replaced_whole",
    "storage_error",
    "write_whole",
]
