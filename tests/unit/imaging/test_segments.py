"""Named segments: names, SNOMED codes, layers and the user's own map decide the tissue."""

from __future__ import annotations

import numpy as np
import pytest

from vulnus.core.errors import InputFileError
from vulnus.core.handoff import Tissue
from vulnus.imaging import ImagingParameters, load_labels
from vulnus.imaging.label_names import tissue_of_name, tissue_of_tags

from . import volumes as v

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

ENTRY = (
    "TerminologyEntry:Segmentation category and type - 3D Slicer General Anatomy list"
    "~SCT^123037004^Anatomical Structure~SCT^{code}^{text}~^^~Anatomic codes~^^~^^|"
)


def segment(number: int, name: str, value: int, layer: int = 0, code: str = "") -> dict[str, str]:
    return {
        f"Segment{number}_ID": f"Segment_{number}",
        f"Segment{number}_Name": name,
        f"Segment{number}_LabelValue": str(value),
        f"Segment{number}_Layer": str(layer),
        f"Segment{number}_Tags": ENTRY.format(code=code, text=name) if code else "",
    }


@pytest.mark.parametrize(
    ("name", "tissue"),
    [
        ("skin", Tissue.SKIN),
        ("Soft tissue", Tissue.MUSCLE),
        ("muscle_TibialisAnterior", Tissue.MUSCLE),
        ("cartilage_tibiadistal", Tissue.MUSCLE),
        ("ligament_mcl", Tissue.MUSCLE),
        ("great saphenous vein", Tissue.MUSCLE),
        ("subcutaneous_fat", Tissue.FAT),
        ("bone_tibia", Tissue.BONE),
        ("Fibula", Tissue.BONE),
        ("cancellous bone", Tissue.CANCELLOUS),
        ("bone marrow", Tissue.MARROW),
        ("anterior_tibial_artery", Tissue.ARTERY),
        ("background", Tissue.AIR),
        ("Segment_7", None),
    ],
)
def test_names_speak_of_tissues(name, tissue):
    assert tissue_of_name(name) is tissue


def test_codes_are_read_from_type_before_category():
    assert tissue_of_tags(ENTRY.format(code="51114001", text="Artery")) is Tissue.ARTERY
    assert tissue_of_tags(ENTRY.format(code="12611008", text="Tibia")) is Tissue.BONE
    assert tissue_of_tags(ENTRY.format(code="1", text="?")) is None
    assert tissue_of_tags("") is None


def test_segments_are_read_by_code_or_name_whatever_their_values(tmp_path):
    values = np.array([0, 12, 7, 200, 31], dtype=np.uint8)
    extra = (
        segment(0, "Haut", 12, code="39937001")
        | segment(1, "soft tissue", 7)
        | segment(2, "Knochen", 200, code="272673000")
        | segment(3, "left popliteal artery", 31)
    )
    path = v.write_nrrd(tmp_path / "leg.seg.nrrd", values[v.asymmetric_labels()], **extra)
    volume = load_labels(ImagingParameters(source=path))
    expected = np.bincount(v.asymmetric_labels().ravel(), minlength=5)
    assert np.bincount(volume.labels.ravel(), minlength=5).tolist() == expected.tolist()


def test_overlapping_layers_merge_by_priority(tmp_path):
    labels = v.asymmetric_labels()
    layers = np.stack([(labels > 0), (labels > 1) * 1 + (labels == 3), labels == 4]).astype(
        np.uint8
    )
    extra = (
        segment(0, "skin", 1, layer=0)
        | segment(1, "muscle", 1, layer=1)
        | segment(2, "bone", 2, layer=1)
        | segment(3, "artery", 1, layer=2)
    )
    directions = np.vstack([np.full(3, np.nan), v.oblique_axes_mm().T])
    path = v.write_nrrd(
        tmp_path / "leg.seg.nrrd",
        layers,
        kinds=["list", "domain", "domain", "domain"],
        **{"space directions": directions},
        **extra,
    )
    volume = load_labels(ImagingParameters(source=path))
    # Skin outranks muscle where segments overlap; bone and artery outrank skin.
    expected = np.where(labels == 2, 1, labels)
    assert np.array_equal(volume.labels, expected)


def test_an_unnamed_segment_is_refused_by_value_and_name(tmp_path):
    extra = segment(0, "skin", 1) | segment(1, "Blob", 2) | segment(2, "bone", 3)
    path = v.write_nrrd(tmp_path / "leg.seg.nrrd", **extra)
    with pytest.raises(InputFileError, match=r"2 \('Blob'\), 4"):
        load_labels(ImagingParameters(source=path))
    label_map = {"muscle": 2, "artery": 4}
    volume = load_labels(ImagingParameters(source=path, label_map=label_map))
    assert (volume.labels == Tissue.ARTERY).sum() == (v.asymmetric_labels() == 4).sum()


def test_a_label_map_translates_structures(tmp_path):
    values = np.array([0, 50, 60, 40, 70], dtype=np.uint16)
    labels = values[v.asymmetric_labels()]
    labels[3, 3, 3] = 41
    path = v.write_nrrd(tmp_path / "leg.nrrd", labels)
    label_map = {"skin": 50, "soleus": 60, "tibia": 40, "fibula": 41, "artery": 70}
    volume = load_labels(ImagingParameters(source=path, label_map=label_map))
    assert (volume.labels == Tissue.BONE).sum() == ((labels == 40) | (labels == 41)).sum()
    assert (volume.labels == Tissue.MUSCLE).sum() == (labels == 60).sum()
