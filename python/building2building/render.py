"""Pictures of an episode: floor plan with temperatures, actuators and power."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .buildings import Building
from .errors import need
from .layout import Layout

Array = NDArray[Any]

#: Deviation from target at the ends of the color scale, K.
_MAX_DEVIATION = 4.0
#: Hours of power shown.
_HOURS = 24
#: Distance between the levels of a building, relative to their size.
_LEVEL_DISTANCE = 1.1
#: Aspect ratio of the area for the floor plan.
_PLAN_ASPECT = 1.6
#: Zones above which labels are shortened.
_CROWDED = 8


@dataclass(frozen=True)
class Scene:
    """The state of an environment to draw."""

    building: Building
    layout: Layout
    setting: _core.Setting
    observation: NDArray[np.float64]
    #: ``None`` before the first step.
    applied_action: NDArray[np.float64] | None
    steps: int


@dataclass(frozen=True)
class _Floor:
    """The floor of a zone."""

    level: int
    zone: int
    corners: Array


class Renderer:
    """Draws the episodes of one environment. The floor plan is computed once per building."""

    def __init__(self) -> None:
        need("matplotlib", "plots")
        self._building: Building | None = None
        self._floors: list[_Floor] = []
        self._figure: Any = None
        self._canvas: Any = None
        self._window: Any = None
        self._image: Any = None
        self._power: deque[tuple[int, float, float]] = deque()

    def draw(self, scene: Scene, show: bool) -> NDArray[np.uint8] | None:
        """Returns a frame as an array (height, width, 3); with ``show``, shows it in a window instead."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        if self._building is not scene.building:
            self._building, self._floors = scene.building, _floors(scene.layout)
        if self._figure is None:
            self._figure = Figure(figsize=(9.6, 5.4), dpi=100)
            self._canvas = FigureCanvasAgg(self._figure)
        figure = self._figure
        figure.clear()
        margins = {"left": 0.03, "right": 0.99, "top": 0.9, "bottom": 0.05, "hspace": 0.15, "wspace": 0.03}
        grid = figure.add_gridspec(2, 2, width_ratios=[3, 2], height_ratios=[3, 1], **margins)
        _draw_plan(scene, self._floors, figure.add_subplot(grid[0, 0]))
        _draw_actuators(scene, figure.add_subplot(grid[:, 1]))
        self._draw_power(scene, figure.add_subplot(grid[1, 0]))
        figure.suptitle(_title(scene), fontsize=10, x=0.01, ha="left")
        self._canvas.draw()
        frame = np.asarray(self._canvas.buffer_rgba())[..., :3].copy()
        if show:
            self._show(frame)
            return None
        return frame

    def _draw_power(self, scene: Scene, axes: Any) -> None:
        layout, now = scene.layout, scene.observation
        rate = layout.steps_per_hour
        while self._power and self._power[-1][0] >= scene.steps:
            self._power.pop()
        self._power.append((scene.steps, now[layout.electricity] * rate, now[layout.gas] * rate))
        while self._power[0][0] < scene.steps - _HOURS * rate:
            self._power.popleft()
        steps, electricity, gas = np.array(self._power).T
        hours = (steps - scene.steps) / rate
        axes.stackplot(hours, electricity, gas, labels=["electricity", "gas"], colors=["#4c78a8", "#f58518"])
        axes.set_xlim(-_HOURS, 0)
        axes.set_ylim(bottom=0)
        axes.tick_params(labelsize=6)
        axes.set_title("HVAC power of the last 24 h, W/m²", fontsize=8, loc="left")
        axes.legend(fontsize=6, loc="upper left", frameon=False)

    def _show(self, frame: NDArray[np.uint8]) -> None:
        from matplotlib import pyplot

        if self._window is None:
            pyplot.ion()
            self._window, axes = pyplot.subplots(figsize=(9.6, 5.4))
            axes.axis("off")
            axes.set_position([0, 0, 1, 1])
            self._image = axes.imshow(frame)
        else:
            self._image.set_data(frame)
        self._window.canvas.draw_idle()
        self._window.canvas.flush_events()

    def close(self) -> None:
        """Closes the window."""
        if self._window is not None:
            from matplotlib import pyplot

            pyplot.close(self._window)
            self._window = None


def _floors(layout: Layout) -> list[_Floor]:
    """Returns the floors of the zones, sorted into levels; levels without controlled zones are left out."""
    floors = [(zone, np.array(corners)) for zone, corners in layout.spaces.floors()]
    heights: list[float] = []
    for height in sorted({round(float(corners[:, 2].mean()), 1) for _, corners in floors}):
        if not heights or height - heights[-1] > 1.0:
            heights.append(height)

    def level_of(corners: Array) -> int:
        return max(level for level, height in enumerate(heights) if corners[:, 2].mean() >= height - 0.5)

    leveled = [_Floor(level_of(corners), zone, corners[:, :2]) for zone, corners in floors]
    shown = sorted({floor.level for floor in leveled if layout.zones[floor.zone].controlled})
    return [_Floor(shown.index(each.level), each.zone, each.corners) for each in leveled if each.level in shown]


def _title(scene: Scene) -> str:
    layout = scene.layout
    slot = layout.outdoor_temperature
    day, step = divmod(scene.steps, 24 * layout.steps_per_hour)
    date = np.datetime64("2017-01-01") + scene.setting.first_day - 1 + day
    hour, minute = divmod(step * 60 // layout.steps_per_hour, 60)
    return (
        f"{scene.building.name}, {scene.building.place}    {str(date)[5:]} {hour:02d}:{minute:02d}"
        f"    outdoors {scene.observation[slot]:.1f} °C, {scene.observation[slot + 1]:.0f} % RH"
    )


def _draw_plan(scene: Scene, floors: list[_Floor], axes: Any) -> None:
    from matplotlib import colormaps
    from matplotlib.patches import Polygon

    layout = scene.layout
    targets = dict(zip(layout.controlled_zones, layout.targets_in(scene.observation)))
    colors = colormaps["coolwarm"]
    corners = np.concatenate([floor.corners for floor in floors]) if floors else np.zeros((1, 2))
    low, size = corners.min(0), np.ptp(corners, axis=0) + 1e-9
    levels = max((floor.level + 1 for floor in floors), default=1)
    columns = max(range(1, levels + 1), key=lambda count: _scale(size, count, -(-levels // count)))
    crowded = len(floors) > _CROWDED
    for floor in floors:
        zone = layout.zones[floor.zone]
        temperature = scene.observation[zone.temperature_slot]
        target = targets.get(zone.name)
        color: Any = (0.92, 0.92, 0.92)
        if target is not None:
            color = colors((temperature - target) / (2 * _MAX_DEVIATION) + 0.5)
        row, column = divmod(floor.level, columns)
        xy = floor.corners - low + np.array([column, row]) * size * _LEVEL_DISTANCE
        axes.add_patch(Polygon(xy, facecolor=color, edgecolor="0.25", linewidth=0.8))
        text = f"{temperature:.1f}" + ("" if target is None or crowded else f" / {target:.0f}")
        axes.text(*_centroid(xy), text, ha="center", va="center", fontsize=6 if crowded else 8)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")
    label = "air temperature, °C" if crowded else "air temperature / target, °C"
    axes.set_title(f"{label}    blue: too cold, red: too warm (±{_MAX_DEVIATION:.0f} K)", fontsize=8, loc="left")


def _draw_actuators(scene: Scene, axes: Any) -> None:
    layout = scene.layout
    count = len(layout.action)
    values = np.full(count, np.nan) if scene.applied_action is None else scene.applied_action
    span = np.where(layout.action_high > layout.action_low, layout.action_high - layout.action_low, 1.0)
    positions = np.arange(count)
    axes.barh(positions, np.ones(count), color="0.93", height=0.8)
    axes.barh(positions, np.nan_to_num((values - layout.action_low) / span), color="#a9c4e0", height=0.8)
    size = 6.5 if count <= 16 else 4.5
    for position, (actuator, value) in enumerate(zip(layout.action, values)):
        unit = "" if actuator.unit == "1" else actuator.unit
        number = "" if np.isnan(value) else f"  {value:.2f} {unit}"
        axes.text(0.01, position, actuator.name + number, va="center", fontsize=size)
    axes.set_xlim(0, 1)
    axes.set_ylim(count - 0.5, -0.5)
    axes.axis("off")
    axes.set_title("actuators, relative to their bounds", fontsize=8, loc="left")


def _scale(size: Array, columns: int, rows: int) -> float:
    """Returns the scale at which levels fit in the plan area in this many columns and rows."""
    return min(_PLAN_ASPECT / (size[0] * columns), 1 / (size[1] * rows))


def _centroid(xy: Array) -> Array:
    """Returns the centroid of a polygon."""
    x, y = xy.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2
    if abs(area) < 1e-9:
        return xy.mean(0)
    moments = np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()])
    return moments / (6 * area)
