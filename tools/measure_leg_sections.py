"""Measure the built-in leg's tables on the meshes of the Visible Human Female's left leg.

    python tools/measure_leg_sections.py MESH_FOLDER OUTPUT_FOLDER

Writes leg_sections.csv (star-shaped contours of tibia, fibula and the envelope of the muscles) and
leg_muscles.csv (each muscle as an ellipse by its second moments) at 21 levels between the ankle's
and the knee's joint face. MESH_FOLDER holds Bone_*.stl and Muscle_*.stl (Andreassen et al. 2022,
Sci Data 9, CC BY 4.0) in LPS millimetres. What was chosen, and not measured, stands as a constant
below. Needs pyvista (extra `test`).
"""

from __future__ import annotations

import csv
import re
import sys
from pathlib import Path

import numpy as np
import pyvista
from matplotlib.path import Path as Polygon
from scipy import ndimage

PLAFOND_MM, PLATEAU_MM = 168.0, 480.0
"""Heights of the tibia's joint faces on the meshes."""

AXIS_MM = np.array([[-507.0, -424.0], [-472.3, -441.6]])
"""Where the tibia's axis passes levels 0 and 1 (x, y): middles of its sections at 0.02, 0.97."""

LEVELS = (
    *(0.0, 0.02, 0.04, 0.07, 0.10, 0.14, 0.20, 0.27, 0.35, 0.43, 0.51, 0.59, 0.67, 0.74, 0.80),
    *(0.85, 0.89, 0.92, 0.945, 0.965, 0.985),
)
RAYS = 30
PIXEL_MM = 0.4
X_MM, Y_MM = np.meshgrid(
    np.arange(-540, -425, PIXEL_MM), np.arange(-480, -340, PIXEL_MM), indexing="ij"
)

ACHILLES_MM = {
    0.0: (-510, -366, 7.5, 3.2),
    0.02: (-510, -367, 7, 3.2),
    0.04: (-509, -368, 7, 3.2),
    0.07: (-508.5, -369, 6.8, 3.2),
    0.10: (-508, -370.5, 6.8, 3.2),
    0.14: (-507, -372, 7, 3.2),
    0.20: (-505, -373.5, 8.5, 3.5),
    0.27: (-501, -375, 12, 3.5),
}
"""Achilles tendon, absent from the meshes: middle and semi-axes. Chosen: between soleus and the
calcaneal tuber; 14 x 6 mm (Gray's Anatomy: 5-6 mm thick, about 15 mm wide where narrowest)."""

TIBIALIS_ANTERIOR_MM = {
    0.0: (-505, -448.5, 3.6, 2.4),
    0.02: (-503, -448.5, 3.6, 2.4),
    0.04: (-501, -448, 3.6, 2.4),
    0.07: (-498, -446.5, 3.6, 2.4),
    0.10: (-494, -444.5, 3.6, 2.6),
    0.14: (-490, -441.5, 3.6, 3.0),
}
"""Its tendon, absent from the meshes; chosen: in front of the tibia's lateral third."""

CLOSING_LEVELS = (0.0, 0.1, 0.14, 0.2, 0.3, 0.87, 0.92, 0.985)
CLOSING_MM = (45, 45, 40, 35, 25, 25, 50, 70)
"""Radius of the ball that the fascia is rolled over with; chosen: it hides grooves between
muscles, and keeps the hollows beside the Achilles tendon."""

POSTURE_LEVELS = (0.0, 0.35, 0.6, 0.85, 1.0)
POSTURE = (0.0, 0.0, 1.0, 1.0, 0.5)
"""How much of the posture correction a level takes."""


def main() -> None:
    """Measure all levels and write both tables."""
    meshes, output = Path(sys.argv[1]), Path(sys.argv[2])
    parts = {
        path.stem.split("_")[1]: pyvista.read(path)
        for path in sorted(meshes.glob("*.stl"))
        if path.stem.startswith("Muscle") or path.stem in ("Bone_Tibia", "Bone_Fibula")
    }
    masks = {level: sections(parts, level) for level in LEVELS}
    contours: list[list] = []
    muscles: list[list] = []
    for level in LEVELS:
        measure_level(level, masks, contours, muscles)
    smooth_fascia([row for row in contours if row[0] == "fascia"])
    muscles.sort(key=lambda row: (row[0], row[1]))
    for row in muscles:
        row[0] = re.sub(r"(?<=[a-z])([A-Z])", r"_\1", row[0]).lower()
    centre = ["level", "centre_x_mm", "centre_y_mm"]
    rays = [f"radius_{ray * 360 // RAYS:03d}_mm" for ray in range(RAYS)]
    shape = ["shape_xx_mm", "shape_xy_mm", "shape_yy_mm"]
    write(output / "leg_sections.csv", ["structure", *centre, *rays], contours)
    write(output / "leg_muscles.csv", ["muscle", *centre, *shape], muscles)


def write(path: Path, names: list[str], rows: list[list]) -> None:
    """One table as CSV."""
    with path.open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(names)
        table.writerows(rows)


def axis_mm(level: float) -> np.ndarray:
    """The tibia's axis at a level (x, y); the sections' origin."""
    return AXIS_MM[0] + (AXIS_MM[1] - AXIS_MM[0]) * level


def sections(parts: dict, level: float) -> dict[str, np.ndarray]:
    """Masks of all parts that a level cuts, tendons added."""
    height = PLAFOND_MM + level * (PLATEAU_MM - PLAFOND_MM)
    masks = {name: section(mesh, height) for name, mesh in parts.items()}
    if level in ACHILLES_MM:
        masks["Achilles"] = ellipse(ACHILLES_MM[level])
    if level in TIBIALIS_ANTERIOR_MM:
        masks["TibialisAnterior"] = masks["TibialisAnterior"] | ellipse(TIBIALIS_ANTERIOR_MM[level])
    # The ankle joint opens the lowest tibia section; the leg's cut there is solid bone.
    solid = ndimage.binary_closing(np.pad(masks["Tibia"], 30), iterations=8)
    masks["Tibia"] = ndimage.binary_fill_holes(solid)[30:-30, 30:-30]
    return masks


def section(mesh: pyvista.PolyData, height: float) -> np.ndarray:
    """Mask of a closed mesh's cut by a horizontal plane; even-odd rule."""
    mask = np.zeros(X_MM.shape, dtype=bool)
    cut = mesh.slice(normal=(0, 0, 1), origin=(0, 0, height))
    if cut.n_points < 3:
        return mask
    lines = cut.strip()
    pixels = np.c_[X_MM.ravel(), Y_MM.ravel()]
    for index in range(lines.n_cells):
        points = lines.get_cell(index).points[:, :2]
        if len(points) >= 3:
            mask ^= Polygon(points).contains_points(pixels).reshape(mask.shape)
    return mask


def ellipse(shape: tuple[float, float, float, float]) -> np.ndarray:
    """Mask of an upright ellipse."""
    x, y, a, b = shape
    return ((X_MM - x) / a) ** 2 + ((Y_MM - y) / b) ** 2 < 1


def measure_level(
    level: float, masks: dict[float, dict], contours: list[list], muscles: list[list]
) -> None:
    """Append the rows of one level."""
    parts = dict(masks[level])
    for name in ("tibia", "fibula"):
        mask = parts[name.capitalize()]
        if area(mask) >= 20:
            contours.append(contour(name, level, mask))
    parts = {
        name: mask if name in ("Tibia", "Fibula") else stand(mask, level)
        for name, mask in parts.items()
    }
    contours.append(contour("fascia", level, envelope(level, parts, masks[0.945]["Fibula"])))
    for name, mask in parts.items():
        if name in ("Tibia", "Fibula", "Plantaris") or area(mask) < 12:
            continue
        # One ellipse cannot follow these two round the corner: halves are measured.
        if name == "Soleus" and level >= 0.2:
            middle = np.median(X_MM[mask])
            muscles.append(moments("Soleus_medial", level, mask & (middle > X_MM)))
            muscles.append(moments("Soleus_lateral", level, mask & (middle <= X_MM)))
        elif name == "GastrocnemiusMedial":
            middle = np.median(Y_MM[mask])
            muscles.append(moments(f"{name}_anterior", level, mask & (middle > Y_MM)))
            muscles.append(moments(f"{name}_posterior", level, mask & (middle <= Y_MM)))
        else:
            muscles.append(moments(name, level, mask))


def area(mask: np.ndarray) -> float:
    """Area [mm²]."""
    return float(mask.sum()) * PIXEL_MM**2


def stand(mask: np.ndarray, level: float) -> np.ndarray:
    """The part of a standing leg: the supine calf is pressed flat and to the medial side.

    Chosen so that the calf is about as deep as broad: up to 15 % less on the medial side, 5 % less
    on the lateral one, 16 % more behind the middle.
    """
    weight = np.interp(level, POSTURE_LEVELS, POSTURE)
    x, y = X_MM - axis_mm(level)[0], Y_MM - axis_mm(level)[1]
    back = 0.16 * weight * np.exp(-(((x + 6) / 38.0) ** 2))
    medial, lateral = 0.15 * weight, 0.05 * weight
    from_x = np.where(
        x < -18,
        -18 + (x + 18) / (1 - medial),
        np.where(x > 30, 30 + (x - 30) / (1 - lateral), x),
    )
    from_y = np.where(y > 18, 18 + (y - 18) / (1 + back), y)
    return sample(mask.astype(float), from_x + axis_mm(level)[0], from_y + axis_mm(level)[1]) > 0.5


def sample(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Linear interpolation of an image at places [mm]."""
    place = [(x - X_MM[0, 0]) / PIXEL_MM, (y - Y_MM[0, 0]) / PIXEL_MM]
    return ndimage.map_coordinates(image, place, order=1)


def envelope(level: float, parts: dict[str, np.ndarray], head: np.ndarray) -> np.ndarray:
    """The fascia: all parts together, their grooves closed."""
    mask = np.logical_or.reduce(list(parts.values()))
    if 0.9 < level < 0.98:
        # The head of the fibula shows under the skin; the fascia passes over it smoothly.
        bone = head if level > 0.93 else parts["Fibula"]
        margin = 1.5 if level < 0.955 else 0.3
        mask |= ndimage.distance_transform_edt(~bone) * PIXEL_MM < margin
    radius = float(np.interp(level, CLOSING_LEVELS, CLOSING_MM))
    pad = int(radius / PIXEL_MM) + 4
    grown = ndimage.distance_transform_edt(~np.pad(mask, pad)) * PIXEL_MM < radius
    closed = ndimage.distance_transform_edt(grown)[pad:-pad, pad:-pad] * PIXEL_MM > radius
    return ndimage.gaussian_filter(closed.astype(float), 2 / PIXEL_MM) > 0.5


def contour(name: str, level: float, mask: np.ndarray) -> list:
    """A row: middle, and the outermost edge along each ray."""
    middle = np.array([X_MM[mask].mean(), Y_MM[mask].mean()])
    soft = ndimage.gaussian_filter(mask.astype(float), 1.0)
    reach = np.arange(0, 95, 0.1)
    radii = []
    for angle in np.arange(RAYS) * 2 * np.pi / RAYS:
        values = sample(soft, middle[0] + reach * np.cos(angle), middle[1] + reach * np.sin(angle))
        inside = np.nonzero(values > 0.5)[0]
        radii.append(reach[inside[-1]] if len(inside) else 0.0)
    return [name, level, *np.round(middle - axis_mm(level), 2), *np.round(radii, 2)]


def moments(name: str, level: float, mask: np.ndarray) -> list:
    """A row: middle, and the symmetric matrix of the ellipse with the mask's second moments."""
    points = np.c_[X_MM[mask], Y_MM[mask]]
    middle = points.mean(axis=0)
    values, vectors = np.linalg.eigh(np.cov(points.T))
    shape = vectors @ np.diag(2 * np.sqrt(values)) @ vectors.T
    entries = [shape[0, 0], shape[0, 1], shape[1, 1]]
    return [name, level, *np.round(middle - axis_mm(level), 2), *np.round(entries, 2)]


def smooth_fascia(rows: list[list]) -> None:
    """Even out the fascia along the calf and round it, where single muscle ends would show."""
    table = np.array([row[1:] for row in rows], dtype=float)
    smooth = table.copy()
    for index in range(1, len(table) - 1):
        below, here, above = table[index - 1 : index + 2, 0]
        weight = 0.5 * np.interp(here, [0.2, 0.4, 0.8, 0.9], [0, 1, 1, 0])
        part = (here - below) / (above - below)
        line = (1 - part) * table[index - 1] + part * table[index + 1]
        smooth[index, 1:] = ((1 - weight) * table[index] + weight * line)[1:]
    for row, values in zip(rows, smooth, strict=True):
        weight = np.interp(values[0], [0.3, 0.45, 0.8, 0.88], [0, 1, 1, 0.15])
        ring = values[3:]
        even = ring
        for _ in range(2):
            even = (np.roll(even, 1) + 2 * even + np.roll(even, -1)) / 4
        values[3:] = (1 - weight) * ring + weight * even
        row[2:] = list(np.round(values[1:], 2))


if __name__ == "__main__":
    main()
