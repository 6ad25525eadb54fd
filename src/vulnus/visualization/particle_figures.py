"""The limb as points and as slices: the paper's Fig. 2 and the labels that the run began with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..core.arrays import AnyArray, FloatArray
from ..core.handoff import InjuredLimb, LabelVolume, ParticleFrame, Tissue, TriangleSurface
from ..core.units import MILLIMETRE, MILLISECOND
from .camera import unit
from .figure_style import FIGURE_2_COLOURS, INK, bare_axes, linear_colour, new_figure
from .frames import points_in_passage
from .projectile_view import projectiles_in
from .surface import TissuePoints

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_REACH = 0.055  # m along the limb on each side of the shot; chosen: the paper's Fig. 2
_AHEAD = 0.075  # m behind the limb that the side view shows, where torn tissue flies


def passage_figure(
    wound: InjuredLimb,
    frames: Sequence[ParticleFrame],
    projectiles: Sequence[TriangleSurface] = (),
) -> Figure:
    """The paper's Fig. 2: one row an instant, from the side and from the exit's side.

    The side view shows the half of the limb behind the shot, so that the tract can be seen, and
    the `projectiles` (surfaces in their own frames) where the frame says.
    """
    rows = max(1, len(frames))
    figure = new_figure(8.6, 3.0 * rows)
    grid = figure.subplots(rows, 2, squeeze=False, width_ratios=[1.65, 1.0])
    for row, frame in zip(grid, frames, strict=False):
        points, reference = points_in_passage(frame, wound)
        bodies = projectiles_in(frame, wound.shot, projectiles)
        shot_side_view(row[0], wound, points, reference, bodies=bodies)
        shot_back_view(row[1], wound, points)
        text = f"t = {frame.time / MILLISECOND:.2f} ms"
        row[0].text(0.99, 0.97, text, transform=row[0].transAxes, ha="right", va="top", color=INK)
    bare_axes(grid[0, 0], "side, cut open")
    bare_axes(grid[0, 1], "back (exit)")
    return figure


def shot_side_view(
    axes: Axes,
    wound: InjuredLimb,
    points: TissuePoints,
    reference: AnyArray,
    *,
    bodies: Sequence[TriangleSurface] = (),
) -> None:
    """Points of the far half, seen across the shot, and the outlines of `bodies`."""
    flight, upward, across = shot_axes(wound)
    middle = shot_middle(wound)
    behind = (reference - middle) @ across
    shown = (behind < 0.0) & (behind > -3.0 * wound.spacing)
    draw_points(axes, points.only(shown), middle, flight, upward)
    ends = (np.array([wound.shot.entry_point, wound.shot.exit_point]) - middle) @ flight
    axes.set_xlim((ends.min() - 0.02) / MILLIMETRE, (ends.max() + _AHEAD) / MILLIMETRE)
    for body in bodies:
        draw_outline(axes, (body.vertices - middle) @ np.stack([flight, upward]).T)
    bare_axes(axes)


def draw_outline(axes: Axes, corners: FloatArray) -> None:
    """The convex outline of a projectile, whose `corners` (n, 2) [m] lie in the picture's plane."""
    from matplotlib.patches import Polygon
    from scipy.spatial import ConvexHull

    ring = corners[ConvexHull(corners).vertices] / MILLIMETRE
    axes.add_patch(Polygon(ring, closed=True, color="#30343a", linewidth=0, zorder=3))


def shot_back_view(axes: Axes, wound: InjuredLimb, points: TissuePoints) -> None:
    """Points seen against the flight: the side where the projectile leaves."""
    flight, upward, across = shot_axes(wound)
    middle = shot_middle(wound)
    facing = (points.position - middle) @ flight
    draw_points(axes, points.only(facing > 0.0), middle, -across, upward, depth=flight)
    bare_axes(axes)


def draw_points(
    axes: Axes,
    points: TissuePoints,
    middle: FloatArray,
    right: FloatArray,
    upward: FloatArray,
    *,
    depth: FloatArray | None = None,
) -> None:
    """Scatter points in the plane of two unit vectors [mm], those nearer along `depth` on top."""
    offset = points.position.astype(np.float64) - middle
    near = np.abs(offset @ upward) < _REACH
    offset, tissue, damage = offset[near], points.tissue[near], points.damage[near]
    order = (
        np.argsort(offset @ depth, kind="stable") if depth is not None else np.arange(len(offset))
    )
    offset, tissue, damage = offset[order], tissue[order], damage[order]
    x, y = offset @ right / MILLIMETRE, offset @ upward / MILLIMETRE
    # Disks as wide as 1.3 spacings where the height of the axes is about 2.8 inches.
    points_per_metre = 2.8 * 72.0 / (2.0 * _REACH)
    size = (1.3 * points.spacing * points_per_metre) ** 2
    axes.scatter(
        x,
        y,
        s=size,
        c=point_colours(tissue, damage),
        edgecolors=(0.2, 0.1, 0.05, 0.55),
        linewidths=0.25,
        rasterized=True,
    )
    axes.set_facecolor("white")
    axes.set_aspect("equal")
    axes.set_ylim(-_REACH / MILLIMETRE, _REACH / MILLIMETRE)


def point_colours(tissue: AnyArray, damage: AnyArray) -> FloatArray:
    """SRGB fractions (n, 3): the paper's yellow, red and white, darker where torn."""
    from matplotlib.colors import to_rgb

    table = np.full((256, 3), 0.6)
    for code, colour in FIGURE_2_COLOURS.items():
        table[int(code)] = to_rgb(colour)
    dark = 1.0 - 0.35 * np.clip(np.asarray(damage, np.float64), 0.0, 1.0)
    colours: FloatArray = np.take(table, tissue, axis=0) * dark[:, None]
    return colours


def shot_axes(wound: InjuredLimb) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Unit vectors of the flight, of "up" across it (proximal) and of the viewer beside it."""
    flight = unit(wound.shot.direction)
    proximal = np.array([0.0, 0.0, 1.0])
    upward = unit(proximal - float(proximal @ flight) * flight)
    if not np.any(upward):
        upward = np.array([0.0, -1.0, 0.0])
    return flight, upward, np.cross(flight, upward)


def shot_middle(wound: InjuredLimb) -> FloatArray:
    """The point [m] half way between entry and exit."""
    ends = np.array([wound.shot.entry_point, wound.shot.exit_point], dtype=np.float64)
    return np.asarray(ends.mean(axis=0))


def slices_figure(labels: LabelVolume, *, count: int = 6) -> Figure:
    """Axial slices through the labelled limb, from proximal (left) to distal, patient's view.

    Drawn as radiology does: seen from the feet, patient's left on the right of the picture.
    """
    figure = new_figure(2.0 * count, 2.6)
    axes = figure.subplots(1, count, squeeze=False)[0]
    occupied = np.flatnonzero(np.any(labels.labels > 0, axis=(0, 1)))
    places = np.rint(np.linspace(0.94, 0.06, count) * (len(occupied) - 1)).astype(int)
    chosen = occupied[places if labels.direction[2, 2] > 0.0 else places[::-1]]
    for panel, index in zip(axes, chosen, strict=True):
        draw_slice(panel, labels, int(index))
    return figure


def draw_slice(axes: Axes, labels: LabelVolume, index: int, *, titled: bool = True) -> None:
    """One axial slice [mm] in the renderer's tissue colours, anterior up."""
    from matplotlib.colors import ListedColormap

    table = [(1.0, 1.0, 1.0)] + [linear_colour(Tissue(code)) for code in range(1, len(Tissue))]
    colours = ListedColormap(table)
    occupied = np.any(labels.labels > 0, axis=2)
    first, last = (np.flatnonzero(np.any(occupied, axis=axis)) for axis in (1, 0))
    box = (slice(first[0], first[-1] + 1), slice(last[0], last[-1] + 1))
    picture = labels.labels[:, :, index][box]
    if labels.direction[0, 0] < 0.0:
        picture = picture[::-1]
    if labels.direction[1, 1] < 0.0:
        picture = picture[:, ::-1]
    extent = (0.0, picture.shape[0] * labels.spacing[0] / MILLIMETRE)
    depth = (picture.shape[1] * labels.spacing[1] / MILLIMETRE, 0.0)
    axes.imshow(
        picture.T,
        cmap=colours,
        vmin=-0.5,
        vmax=len(table) - 0.5,
        interpolation="nearest",
        extent=(*extent, *depth),
    )
    place = labels.origin[2] + labels.direction[2, 2] * labels.spacing[2] * index
    bare_axes(axes, f"z = {place / MILLIMETRE:.0f} mm" if titled else "")
