"""Centre-lines of arteries from their label, for volumes that bring none.

A label of an artery says where its lumen is; its axis is the way through it that keeps to the
middle. The way from the proximal end to each far tip is the shortest one where steps near the wall
cost more (a tree of shortest paths, as in TEASAR, Sato et al. 2000), then evened along its length.
The radius is that of the circle with the label's volume per length.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np

from vulnus.core.arrays import BoolArray, FloatArray, IndexArray
from vulnus.core.handoff import ArteryCentreline, LabelVolume, Tissue

LOG = logging.getLogger("vulnus.anatomy")

SHORTEST_BRANCH = 20e-3
"""Shortest way that counts as an artery [m]; chosen: shorter ones are bumps of the label."""

POINT_STEP = 2e-3
"""Distance of two points of a centre-line [m]; chosen: about one artery's diameter."""

WALL_COST = 8.0
"""How much dearer a step at the wall is than one on the axis; chosen: a detour of eight radii along
the axis is then taken rather than a short cut along the wall."""

NAMED_LENGTH = 80e-3
"""Shortest vessel that is taken for one of the leg's named arteries [m]; chosen: a third of the
shortest of them in the example legs, longer than their side branches."""


@dataclass(frozen=True, slots=True)
class _Lumen:
    """Voxels of one connected artery label: centres (n, 3) [m], a graph, ways from the root."""

    centre: FloatArray
    distance: FloatArray
    before: IndexArray
    voxel_volume: float
    voxel: float


@dataclass(slots=True)
class _Path:
    """A way from its start on the parent (or the root) to a tip, (n, 3) [m]."""

    points: FloatArray
    parent: int | None


def find_arteries(volume: LabelVolume) -> tuple[ArteryCentreline, ...]:
    """Centre-lines of the ARTERY label, longest first; empty where it has none long enough.

    Where three long vessels leave one trunk they are named as in the leg (anterior tibial the most
    anterior, posterior tibial medial, fibular lateral, popliteal the trunk); else they are
    artery_1, artery_2, … . The proximal end is the highest in z (superior).
    """
    import cc3d

    mask = volume.labels == Tissue.ARTERY
    if not mask.any():
        return ()
    parts = cc3d.connected_components(mask, connectivity=26)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    arteries: list[ArteryCentreline] = []
    for part in np.argsort(-sizes, kind="stable"):
        voxels = np.argwhere(parts == part) if sizes[part] > 8 else np.empty((0, 3))
        if len(voxels) == 0:
            break
        lumen = _walk(volume, voxels.astype(np.int64))
        paths = _branches(lumen)
        arteries.extend(_name(_measure(paths, lumen), volume.side, len(arteries)))
    if arteries:
        names = ", ".join(artery.name for artery in arteries)
        LOG.warning("%s: no centre-lines given; made from the label: %s", volume.source, names)
    else:
        LOG.warning("%s: its artery label gives no centre-line; no arteries", volume.source)
    return tuple(arteries)


def _walk(volume: LabelVolume, voxels: IndexArray) -> _Lumen:
    """Shortest ways from the highest voxel to all others, dearer near the wall."""
    import edt
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    low = voxels.min(axis=0) - 1
    local = voxels - low
    shape = tuple(int(n) for n in local.max(axis=0) + 2)
    number = np.full(shape, -1, dtype=np.int64)
    number[tuple(local.T)] = np.arange(len(local))
    depth = edt.edt(number >= 0, anisotropy=tuple(volume.spacing.tolist()))[tuple(local.T)]
    dearness = 1.0 + WALL_COST * (1.0 - depth / depth.max()) ** 2
    rows, columns, costs = [], [], []
    for step in np.argwhere(np.ones((3, 3, 3))) - 1:
        other = number[tuple((local + step).T)]
        there = other >= 0
        if not step.any():
            continue
        length = float(np.linalg.norm(step * volume.spacing))
        rows.append(np.flatnonzero(there))
        columns.append(other[there])
        costs.append(length * 0.5 * (dearness[there] + dearness[other[there]]))
    count = len(local)
    graph = coo_array(
        (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))),
        shape=(count, count),
    ).tocsr()
    centre = volume.origin + (voxels * volume.spacing) @ volume.direction.T
    root = int(np.argmax(centre[:, 2]))
    distance, before = dijkstra(graph, indices=np.array([root]), return_predecessors=True)
    return _Lumen(
        centre=centre,
        distance=distance[0],
        before=before[0].astype(np.int64),
        voxel_volume=float(np.prod(volume.spacing)),
        voxel=float(volume.spacing.max()),
    )


def _branches(lumen: _Lumen) -> list[_Path]:
    """The way to the farthest tip, then to the farthest voxel not yet beside a way, and so on."""
    from scipy.spatial import cKDTree

    paths: list[_Path] = []
    covered: BoolArray = np.zeros(len(lumen.centre), dtype=bool)
    owner = np.full(len(lumen.centre), -1, dtype=np.int64)
    reach = 3.0 * lumen.voxel + np.sqrt(lumen.voxel_volume * len(covered) / lumen.distance.max())
    while not covered.all():
        tip = int(np.argmax(np.where(covered, -1.0, lumen.distance)))
        way = [tip]
        while lumen.before[way[-1]] >= 0 and not covered[way[-1]]:
            way.append(int(lumen.before[way[-1]]))
        points = lumen.centre[way[::-1]]
        parent = int(owner[way[-1]]) if paths else None
        near = cKDTree(points).query(lumen.centre, distance_upper_bound=reach)[0] < np.inf
        fresh = near & ~covered
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        if length >= SHORTEST_BRANCH:
            owner[fresh] = len(paths)
            if parent is not None:
                joint = cKDTree(paths[parent].points).query(points[0])[1]
                points = np.vstack([paths[parent].points[joint], points])
            paths.append(_Path(points, parent))
        elif parent is not None:
            owner[fresh] = parent
        covered |= near
        covered[way] = True
        if not paths:
            break
    return paths


def _measure(paths: list[_Path], lumen: _Lumen) -> list[ArteryCentreline]:
    """Even the ways, space their points, and measure each one's radius from the label's volume."""
    from scipy.ndimage import gaussian_filter1d
    from scipy.spatial import cKDTree

    lines = _centred([_even(path.points) for path in paths], lumen)
    if not lines:
        return []
    which = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    nearest = cKDTree(np.concatenate(lines)).query(lumen.centre)[1]
    counts = np.bincount(nearest, minlength=len(which)) * lumen.voxel_volume
    arteries = []
    for index, (line, path) in enumerate(zip(lines, paths, strict=True)):
        step = np.linalg.norm(np.diff(line, axis=0), axis=1).mean()
        volume = counts[which == index]
        volume[[0, -1]] = volume[[1, -2]]  # an end has half a step of its own, or a stump's rest
        area = gaussian_filter1d(volume / step, 3.0, mode="nearest")
        radius = np.sqrt(np.maximum(area, lumen.voxel_volume / step) / np.pi)
        parent = None if path.parent is None else f"artery_{path.parent + 1}"
        arteries.append(ArteryCentreline(f"artery_{index + 1}", line, radius, parent))
    return arteries


def _centred(lines: list[FloatArray], lumen: _Lumen) -> list[FloatArray]:
    """Lines moved sideways to the middle of the voxels nearest to each point.

    A way runs through voxel centres, up to half a voxel's diagonal beside the axis.
    """
    from scipy.ndimage import gaussian_filter1d
    from scipy.spatial import cKDTree

    if not lines:
        return []
    points = np.concatenate(lines)
    nearest = cKDTree(points).query(lumen.centre)[1]
    count = np.bincount(nearest, minlength=len(points))
    sums = [np.bincount(nearest, lumen.centre[:, a], len(points)) for a in range(3)]
    middle = np.where(count[:, None] > 0, np.column_stack(sums) / np.maximum(count, 1)[:, None], 0)
    move = np.where(count[:, None] > 0, middle - points, 0.0)
    centred = []
    for line, part in zip(
        lines, np.split(move, np.cumsum([len(line) for line in lines])[:-1]), strict=True
    ):
        tangent = np.gradient(line, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        sideways = part - np.einsum("ij,ij->i", part, tangent)[:, None] * tangent
        sideways[[0, -1]] = sideways[[1, -2]]  # the ends' voxels are a cap, not a slice
        centred.append(line + gaussian_filter1d(sideways, 2.0, axis=0, mode="nearest"))
    return centred


def _even(points: FloatArray) -> FloatArray:
    """Points every `POINT_STEP` along a way, smoothed over some 4 mm; its ends stay."""
    from scipy.ndimage import gaussian_filter1d

    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    fine = np.linspace(0.0, along[-1], max(int(along[-1] / 0.5e-3), 8))
    dense = np.column_stack([np.interp(fine, along, points[:, a]) for a in range(3)])
    ends = dense[[0, -1]]
    # 8 samples of 0.5 mm; odd reflection keeps the direction at the ends.
    mirrored = np.concatenate([2 * ends[0] - dense[:0:-1], dense, 2 * ends[1] - dense[-2::-1]])
    smooth = gaussian_filter1d(mirrored, 8.0, axis=0)[len(dense) - 1 : 2 * len(dense) - 1]
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(smooth, axis=0), axis=1))])
    steps = np.linspace(0.0, along[-1], max(round(along[-1] / POINT_STEP), 4) + 1)
    return np.column_stack([np.interp(steps, along, smooth[:, a]) for a in range(3)])


def _name(arteries: list[ArteryCentreline], side: str, taken: int) -> list[ArteryCentreline]:
    """Named as in the leg where the tree has its shape; else numbered after those `taken`."""
    major = [a for a in arteries if _length(a) >= NAMED_LENGTH]
    if taken == 0 and len(major) == 3 and all(a.parent is not None for a in major[1:]):
        return _name_leg(arteries, major, side)
    if taken == 0:
        return arteries

    def later(name: str | None) -> str | None:
        return None if name is None else f"artery_{int(name.split('_')[1]) + taken}"

    return [
        ArteryCentreline(later(a.name) or a.name, a.points, a.radius, later(a.parent))
        for a in arteries
    ]


def _length(artery: ArteryCentreline) -> float:
    return float(np.linalg.norm(np.diff(artery.points, axis=0), axis=1).sum())


def _name_leg(
    arteries: list[ArteryCentreline], major: list[ArteryCentreline], side: str
) -> list[ArteryCentreline]:
    """Cut the trunk at its last major branch and name its distal part and the branches."""
    trunk = major[0]
    joints = [
        int(np.argmin(np.linalg.norm(trunk.points - branch.points[0], axis=1)))
        for branch in major[1:]
    ]
    cut = min(max(*joints, 2), len(trunk.points) - 3)
    popliteal = ArteryCentreline("popliteal", trunk.points[: cut + 1], trunk.radius[: cut + 1])
    distal = ArteryCentreline("", trunk.points[cut:], trunk.radius[cut:], "popliteal")
    vessels = [distal, *major[1:]]
    # Places are compared in the lower half, where the three run apart.
    place = [v.points[len(v.points) // 2 :].mean(axis=0) for v in vessels]
    lateral = 1.0 if side == "left" else -1.0
    anterior = int(np.argmin([p[1] for p in place]))
    others = sorted({0, 1, 2} - {anterior}, key=lambda v: lateral * place[v][0])
    new = {anterior: "anterior_tibial", others[0]: "posterior_tibial", others[1]: "fibular"}
    renamed = {trunk.name: "popliteal"}
    renamed |= {v.name: new[k] for k, v in enumerate(vessels) if v.name}
    named = [popliteal]
    named += [
        ArteryCentreline(new[k], v.points, v.radius, "popliteal") for k, v in enumerate(vessels)
    ]
    named += [
        ArteryCentreline(a.name, a.points, a.radius, renamed.get(a.parent or "", a.parent))
        for a in arteries
        if a not in major
    ]
    return named
