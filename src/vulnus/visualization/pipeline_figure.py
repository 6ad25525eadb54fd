"""The whole pipeline in one picture, each station drawn from the run's own results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..core.handoff import (
    BleedOutcome,
    BleedWaveforms,
    InjuredLimb,
    LabelVolume,
    Tissue,
    TriangleSurface,
)
from ..core.units import MILLILITRE_PER_MINUTE, MILLIMETRE, MILLIMETRE_OF_MERCURY
from .figure_style import AORTA, ARTERY, INK, bare_axes, new_figure, style_axes
from .particle_figures import draw_points, draw_slice, shot_axes, shot_middle, shot_side_view
from .picture import Picture
from .surface import TissuePoints

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True, eq=False)
class PipelineStations:
    """What the stations of the pipeline left behind; None where a station was not reached.

    `picture` is a rendered view, `blood` the reconstructed surface.
    """

    wound: InjuredLimb
    labels: LabelVolume | None = None
    beat: BleedWaveforms | None = None
    outcome: BleedOutcome | None = None
    blood: TriangleSurface | None = None
    picture: Picture | None = None


def pipeline_figure(stations: PipelineStations) -> Figure:
    """Labels, points, injury, arterial tree, bleeding and picture, from left to right."""
    figure = new_figure(15.0, 6.2)
    axes = figure.subplots(2, 3, width_ratios=[1.0, 1.0, 1.35])
    _labels_station(axes[0, 0], stations.labels)
    _points_station(axes[0, 1], stations.wound)
    _injury_station(axes[0, 2], stations.wound)
    _tree_station(axes[1, 0], stations.beat)
    _blood_station(axes[1, 1], stations)
    _picture_station(axes[1, 2], stations)
    return figure


def _labels_station(axes: Axes, labels: LabelVolume | None) -> None:
    if labels is not None:
        occupied = np.flatnonzero(np.any(labels.labels > 0, axis=(0, 1)))
        draw_slice(axes, labels, int(occupied[int(0.62 * (len(occupied) - 1))]), titled=False)
    bare_axes(axes)
    _name(axes, 1, "imaging: labelled voxels")


def _points_station(axes: Axes, wound: InjuredLimb) -> None:
    flight, upward, across = shot_axes(wound)
    middle = shot_middle(wound)
    points = TissuePoints(
        wound.reference_position, wound.tissue, np.zeros_like(wound.damage), wound.spacing
    )
    behind = (points.position - middle) @ across
    half = points.only((behind < 0.0) & (behind > -3.0 * wound.spacing))
    draw_points(axes, half, middle, flight, upward)
    bare_axes(axes)
    _name(axes, 2, "anatomy: Poisson-disk points")


def _injury_station(axes: Axes, wound: InjuredLimb) -> None:
    shot_side_view(axes, wound, TissuePoints.of(wound), wound.reference_position)
    for artery in wound.arteries:
        _draw_artery(axes, wound, artery.points, artery.damage)
    _name(axes, 3, f"injury: t = {1e3 * wound.time:.1f} ms (material points)")


def _draw_artery(axes: Axes, wound: InjuredLimb, points: np.ndarray, damage: np.ndarray) -> None:
    flight, upward, _ = shot_axes(wound)
    offset = points - shot_middle(wound)
    x = np.where(damage < 0.5, offset @ flight, np.nan) / MILLIMETRE
    axes.plot(x, offset @ upward / MILLIMETRE, color="#ff2a2a", linewidth=1.6, alpha=0.9)


def _tree_station(axes: Axes, beat: BleedWaveforms | None) -> None:
    _name(axes, 4, "circulation: 91-segment tree")
    if beat is None:
        bare_axes(axes)
        return
    time = beat.time - beat.time[0]
    axes.plot(time, beat.pressure_aorta / MILLIMETRE_OF_MERCURY, "--", color=AORTA, label="aorta")
    pressure = beat.pressure_artery / MILLIMETRE_OF_MERCURY
    axes.plot(time, pressure, color=ARTERY, label="injured artery")
    style_axes(axes, x="time [s]", y="pressure [mmHg]")
    axes.legend(frameon=False, fontsize=8)


def _blood_station(axes: Axes, stations: PipelineStations) -> None:
    _name(axes, 5, "hemorrhage: smoothed particles, surface")
    blood = stations.blood
    if blood is None or blood.triangles.shape[0] == 0:
        bare_axes(axes)
        axes.text(0.5, 0.5, "no artery is cut", ha="center", transform=axes.transAxes)
        return
    flight, upward, across = shot_axes(stations.wound)
    _draw_outline(axes, stations.wound)
    corners = blood.vertices[blood.triangles] - shot_middle(stations.wound)
    order = np.argsort(corners.mean(axis=1) @ across)
    corners = corners[order]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-20)
    light = np.clip(normal @ (0.5 * across + 0.6 * upward - 0.4 * flight), 0.0, 1.0)
    shade = (0.25 + 0.75 * light)[:, None] * np.array([0.80, 0.07, 0.09])
    seen = normal @ across > 0.0
    plane = np.stack([corners @ flight, corners @ upward], axis=-1)[seen] / MILLIMETRE
    from matplotlib.collections import PolyCollection

    axes.add_collection(
        PolyCollection(list(plane), facecolors=shade[seen], edgecolors="face", linewidths=0.3)
    )
    axes.autoscale_view()
    axes.set_aspect("equal")
    bare_axes(axes)
    if stations.outcome is not None:
        flow = stations.outcome.mean_flow_per_beat
        if flow.size:
            text = f"first beat: {flow[0] / MILLILITRE_PER_MINUTE:.0f} ml/min"
            axes.text(0.02, 0.02, text, transform=axes.transAxes, fontsize=8, color=INK)


def _draw_outline(axes: Axes, wound: InjuredLimb) -> None:
    """The skin's points in a slab about the shot, pale, so that the blood has its place."""
    flight, upward, across = shot_axes(wound)
    middle = shot_middle(wound)
    offset = wound.position - middle
    slab = (wound.tissue == Tissue.SKIN) & (np.abs(offset @ across) < 3.0 * wound.spacing)
    slab &= np.abs(offset @ upward) < 0.055
    x, y = offset[slab] @ flight / MILLIMETRE, offset[slab] @ upward / MILLIMETRE
    near = np.abs(x) < 1.6 * np.median(np.abs(x)) if x.size else slab[:0]
    axes.scatter(x[near], y[near], s=5.0, color="#e3c2b1", linewidths=0.0)


def _picture_station(axes: Axes, stations: PipelineStations) -> None:
    bare_axes(axes)
    if stations.picture is not None:
        _name(axes, 6, "visualization: ray-traced picture")
        axes.imshow(stations.picture)
        return
    _name(axes, 6, "visualization: points of the skin")
    skin = stations.wound.tissue == Tissue.SKIN
    points = TissuePoints.of(stations.wound).only(skin)
    flight, upward, across = shot_axes(stations.wound)
    draw_points(axes, points, shot_middle(stations.wound), flight, upward, depth=across)


def _name(axes: Axes, number: int, text: str) -> None:
    axes.set_title(f"{number}  {text}", loc="left", fontsize=11, color=INK)
