"""What tissue and blood look like: linear RGB reflectances and Mitsuba's surface models.

Colours are chosen by eye under the studio lights of `lighting.py`, from photographs of living
skin and fresh dissections; optical constants carry their source.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np

from ..core.arrays import Float32Array, FloatArray, LabelArray, Vector3
from ..core.handoff import Tissue

Material = Literal["tissue", "bone", "artery", "blood", "blood_opaque", "platform", "projectile"]

TISSUE_COLOUR: dict[Tissue, Vector3] = {
    Tissue.SKIN: (0.60, 0.305, 0.215),
    Tissue.FAT: (0.78, 0.52, 0.20),
    Tissue.MUSCLE: (0.30, 0.032, 0.026),
    Tissue.BONE: (0.80, 0.70, 0.50),
    Tissue.CANCELLOUS: (0.70, 0.42, 0.28),
    Tissue.MARROW: (0.55, 0.16, 0.10),
    Tissue.ARTERY: (0.52, 0.020, 0.022),
}
RAW_WOUND: Vector3 = (0.20, 0.008, 0.008)
"""Torn, blood-stained tissue, towards which damaged points are tinted."""

BLOOD_REFRACTIVE_INDEX = 1.36  # whole blood, visible light (Li et al. 2000, J Biomed Opt 5:404)
BLOOD_EXTINCTION = (
    520.0  # 1/m, chosen: 1 mm is red, 1 cm is dark (true values are opaque at 0.1 mm)
)
BLOOD_ALBEDO: Vector3 = (0.80, 0.05, 0.04)
BLOOD_ANISOTROPY = 0.6


def tissue_colours(tissue: LabelArray, damage: Float32Array | None = None) -> FloatArray:
    """Linear RGB (n, 3) of points by `tissue` code (n,), torn ones (`damage` 0-1) stained."""
    table = np.zeros((256, 3))
    for code, colour in TISSUE_COLOUR.items():
        table[int(code)] = colour
    colours = np.asarray(np.take(table, tissue, axis=0), dtype=np.float64)
    if damage is None:
        return colours
    stain = 0.75 * np.clip(damage, 0.0, 1.0)[:, None]
    stain = np.where((tissue == Tissue.BONE)[:, None], 0.35 * stain, stain)
    stained: FloatArray = (1.0 - stain) * colours + stain * np.asarray(RAW_WOUND)
    return stained


def surface_model(material: Material) -> dict[str, Any]:
    """Mitsuba's description (BSDF dictionary) of a material."""
    if material == "tissue":
        return {
            "type": "principled",
            "base_color": {"type": "mesh_attribute", "name": "vertex_colour"},
            "roughness": {"type": "mesh_attribute", "name": "vertex_roughness"},
            "specular": 0.40,
            "sheen": 0.2,
            "sheen_tint": 0.7,
        }
    if material == "blood":
        return {"type": "dielectric", "int_ior": BLOOD_REFRACTIVE_INDEX, "ext_ior": 1.0}
    colour, roughness, specular, clearcoat = {
        "bone": (TISSUE_COLOUR[Tissue.BONE], 0.42, 0.40, 0.15),
        "artery": (TISSUE_COLOUR[Tissue.ARTERY], 0.30, 0.50, 0.30),
        "blood_opaque": ((0.190, 0.0035, 0.0045), 0.16, 0.55, 1.0),
        "platform": ((0.40, 0.415, 0.43), 0.32, 0.35, 0.0),
        "projectile": ((0.42, 0.30, 0.20), 0.25, 0.9, 0.5),
    }[material]
    return {
        "type": "principled",
        "base_color": {"type": "rgb", "value": list(colour)},
        "roughness": roughness,
        "specular": specular,
        "clearcoat": clearcoat,
        "clearcoat_gloss": 0.95,
        "metallic": 0.9 if material == "projectile" else 0.0,
    }


def interior_medium(material: Material) -> dict[str, Any] | None:
    """Mitsuba's description of what fills a closed surface, or None for opaque materials."""
    if material != "blood":
        return None
    return {
        "type": "homogeneous",
        "sigma_t": BLOOD_EXTINCTION,
        "albedo": {"type": "rgb", "value": list(BLOOD_ALBEDO)},
        "phase": {"type": "hg", "g": BLOOD_ANISOTROPY},
    }
