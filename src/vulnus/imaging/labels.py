"""The imaging stage's one entry: a limb as labelled voxels, from wherever the scenario says."""

from __future__ import annotations

from vulnus.core.errors import InputFileError
from vulnus.core.handoff import LabelVolume
from vulnus.core.progress import Progress, SilentProgress

from .parameters import BUILTIN_LEG, ImagingParameters


def load_labels(parameters: ImagingParameters, progress: Progress | None = None) -> LabelVolume:
    """The limb that `parameters.source` names: the built-in leg or a label file with its arteries.

    Errors: InputFileError where a file, or a value about it, cannot be used.
    """
    if parameters.side not in ("left", "right"):
        raise InputFileError(
            "imaging.side",
            f"{parameters.side!r} is neither 'left' nor 'right'",
            "Say which leg the volume shows",
        )
    if str(parameters.source) == BUILTIN_LEG:
        from .builtin_leg import generate_leg

        return generate_leg(parameters, progress or SilentProgress())
    from .label_files import read_label_file

    return read_label_file(parameters)
