"""Frames of particles as VTKHDF files, one a frame, with an index that ParaView opens as a film.

Format: VTKHDF 2.2 PolyData (https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html),
a vertex cell a particle, the time as field data `TimeValue`. The index `NAME.vtkhdf.series` is
ParaView's JSON list of files and times.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vulnus.core.arrays import IndexArray
from vulnus.core.errors import StorageError
from vulnus.core.handoff import ParticleFrame

from .whole_file import write_whole

_OWN_FIELDS = ("TimeValue", "FrameIndex")
_CELL_KINDS = ("Vertices", "Lines", "Polygons", "Strips")


class FrameSeries:
    """The frames of one stage in `directory`, files `NAME_0000.vtkhdf` and so on."""

    def __init__(self, directory: Path, name: str) -> None:
        self.directory = directory
        self.name = name

    @property
    def index_path(self) -> Path:
        """The `.vtkhdf.series` file."""
        return self.directory / f"{self.name}.vtkhdf.series"

    def path(self, index: int) -> Path:
        """The file of frame `index`."""
        return self.directory / f"{self.name}_{index:04d}.vtkhdf"

    def times(self) -> dict[int, float]:
        """Frame index to time [s], of the frames that are finished, in order."""
        try:
            entries = json.loads(self.index_path.read_text())["files"]
            known = {
                int(item["name"].split("_")[-1].split(".")[0]): float(item["time"])
                for item in entries
            }
        except FileNotFoundError:
            return {}
        except (ValueError, KeyError, TypeError) as trouble:
            raise StorageError(
                str(self.index_path),
                f"it is not a list of frames ({trouble})",
                "Delete it and run again with --resume",
            ) from trouble
        return {i: known[i] for i in sorted(known) if self.path(i).exists()}

    def save(self, frame: ParticleFrame) -> None:
        """Write `frame` and add it to the index; frames behind it belong to a lost run."""
        write_whole(self.path(frame.index), frame_as_vtkhdf(frame))
        times = {i: t for i, t in self.times().items() if i < frame.index}
        times[frame.index] = frame.time
        files = [{"name": self.path(i).name, "time": t} for i, t in times.items()]
        index = {"file-series-version": "1.0", "files": files}
        write_whole(self.index_path, json.dumps(index, indent=1) + "\n")

    def load(self, index: int) -> ParticleFrame:
        """Frame `index`, read back."""
        import h5py

        path = self.path(index)
        try:
            with h5py.File(path, "r") as file:
                root = file["VTKHDF"]
                return ParticleFrame(
                    index=index,
                    time=float(root["FieldData/TimeValue"][0]),
                    position=root["Points"][()],
                    point_data={name: data[()] for name, data in root["PointData"].items()},
                    frame_data={
                        name: data[()]
                        for name, data in root["FieldData"].items()
                        if name not in _OWN_FIELDS
                    },
                )
        except (OSError, KeyError) as trouble:
            raise StorageError(
                str(path),
                f"the frame cannot be read ({trouble})",
                "Delete the file's run directory or restore the file",
            ) from trouble

    def __len__(self) -> int:
        return len(self.times())

    def __iter__(self) -> Iterator[ParticleFrame]:
        return (self.load(index) for index in self.times())


def frame_as_vtkhdf(frame: ParticleFrame) -> bytes:
    """The bytes of a VTKHDF PolyData file that holds `frame`."""
    import h5py

    with h5py.File("frame", "w", driver="core", backing_store=False) as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 2], dtype=np.int64)
        root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
        count = len(frame.position)
        root["NumberOfPoints"] = np.array([count], dtype=np.int64)
        root["Points"] = np.ascontiguousarray(frame.position, dtype=np.float32)
        for kind in _CELL_KINDS:
            _write_cells(root.create_group(kind), count if kind == "Vertices" else 0)
        data = root.create_group("PointData")
        for name, values in sorted(frame.point_data.items()):
            data[name] = np.ascontiguousarray(values)
        fields = root.create_group("FieldData")
        fields["TimeValue"] = np.array([frame.time], dtype=np.float64)
        fields["FrameIndex"] = np.array([frame.index], dtype=np.int64)
        for name, values in sorted(frame.frame_data.items()):
            fields[name] = np.ascontiguousarray(values)
        file.flush()
        return bytes(file.id.get_file_image())


def _write_cells(group: Any, count: int) -> None:
    """One vertex a particle; the index arrays compress to almost nothing."""
    group["NumberOfCells"] = np.array([count], dtype=np.int64)
    group["NumberOfConnectivityIds"] = np.array([count], dtype=np.int64)
    _write_indices(group, "Offsets", np.arange(count + 1, dtype=np.int64))
    _write_indices(group, "Connectivity", np.arange(count, dtype=np.int64))


def _write_indices(group: Any, name: str, values: IndexArray) -> None:
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
    group.create_dataset(name, data=values, **(packed if len(values) > 1 else {}))
