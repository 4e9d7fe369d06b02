"""Pictures of an episode: floor plan with temperatures, actuators and power."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..buildings import Building
from ..errors import need
from .layout import Layout

Array = NDArray[Any]

#: Size of a frame, inches, and its resolution, pixels per inch.
_SIZE, _DPI = (9.6, 5.4), 100
#: Deviation from target at the ends of the color scale, K.
_MAX_DEVIATION = 4.0
#: Hours of power shown.
_HOURS = 24
#: Smallest height of the power chart, W/m²; it grows by doubling.
_MIN_POWER = 10.0
#: Distance between the floors of a building, relative to their size.
_FLOOR_DISTANCE = 1.15
#: Aspect ratio of the area for the floor plan.
_PLAN_ASPECT = 1.7
#: Font sizes, points: of titles and of labels; labels shrink to the smallest where they are many.
_TITLE, _LABEL, _MIN_LABEL = 8.5, 7.5, 6.5
#: Width and height of a character and a line, relative to the font size.
_CHARACTER, _LINE = 0.56, 1.3


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
    power: PowerHistory


class PowerHistory:
    """HVAC power of the last hours of an episode, W/m²."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._rows: deque[tuple[int, float, float]] = deque(maxlen=_HOURS * layout.steps_per_hour + 1)

    def add(self, step: int, observation: Array) -> None:
        """Adds the power of a step; drops later steps, left from an earlier episode."""
        rows, layout, rate = self._rows, self._layout, self._layout.steps_per_hour
        while rows and rows[-1][0] >= step:
            rows.pop()
        rows.append((step, observation[layout.electricity] * rate, observation[layout.gas] * rate))

    def rows(self) -> Array:
        """Returns step, electric power and gas power of the last hours, ``[rows, 3]``."""
        return np.array(self._rows or [(0, 0.0, 0.0)])

    def __copy__(self) -> PowerHistory:
        other = PowerHistory(self._layout)
        other._rows.extend(self._rows)
        return other


class Renderer:
    """Draws the episodes of one environment. The static parts are drawn once per building."""

    def __init__(self) -> None:
        need("matplotlib", "plots")
        self._layout: Layout | None = None
        self._drawing: _Drawing
        self._window: Any = None
        self._image: Any = None

    def draw(self, scene: Scene, show: bool) -> NDArray[np.uint8] | None:
        """Returns a frame as an array (height, width, 3); with ``show``, shows it in a window instead."""
        if self._layout is not scene.layout:
            self._layout, self._drawing = scene.layout, _Drawing(scene.layout)
        frame = self._drawing.frame(scene)
        if show:
            self._show(frame)
            return None
        return frame

    def _show(self, frame: NDArray[np.uint8]) -> None:
        from matplotlib import pyplot

        if self._window is None:
            pyplot.ion()
            self._window, axes = pyplot.subplots(figsize=_SIZE)
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


@dataclass
class _Cell:
    """A box of the picture, redrawn when its content changes."""

    box: Any
    artists: list[Any]
    #: Its current content.
    shown: Any = None
    #: The content on the canvas.
    drawn: Any = None
    #: The box without the artists.
    background: Any = None


class _Panel(Protocol):
    """A part of the picture."""

    cells: list[_Cell]

    def update(self, scene: Scene) -> bool:
        """Shows a state; returns whether anything besides the cells has changed."""


class _Drawing:
    """The picture of a building."""

    def __init__(self, layout: Layout) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self._figure = Figure(figsize=_SIZE, dpi=_DPI)
        self._canvas = FigureCanvasAgg(self._figure)
        self._empty = True
        self._panels: list[_Panel] = [
            _Title(self._figure),
            _Plan(layout, self._figure.add_axes((0.01, 0.31, 0.6, 0.57))),
            _Power(layout, self._figure.add_axes((0.04, 0.07, 0.57, 0.17))),
            _Actuators(layout, self._figure.add_axes((0.63, 0.02, 0.36, 0.86))),
        ]

    def frame(self, scene: Scene) -> NDArray[np.uint8]:
        """Returns the picture of a state."""
        changed = [panel.update(scene) for panel in self._panels]
        cells = [cell for panel in self._panels for cell in panel.cells]
        if self._empty or any(changed):
            self._canvas.draw()
            for cell in cells:
                cell.background, cell.drawn = self._canvas.copy_from_bbox(cell.box), None
            self._empty = False
        for cell in cells:
            if cell.drawn is None or cell.drawn != cell.shown:
                self._canvas.restore_region(cell.background)
                for artist in cell.artists:
                    self._figure.draw_artist(artist)
                cell.drawn = cell.shown
        return np.asarray(self._canvas.buffer_rgba())[..., :3].copy()


class _Title:
    """Building, date and weather."""

    def __init__(self, figure: Any) -> None:
        from matplotlib.transforms import Bbox

        self._text = figure.text(0.01, 0.955, "", fontsize=10.5, animated=True)
        self.cells = [_Cell(Bbox([[0.0, 0.93], [1.0, 1.0]]).transformed(figure.transFigure), [self._text])]

    def update(self, scene: Scene) -> bool:
        layout = scene.layout
        slot = layout.outdoor_temperature
        day, step = divmod(scene.steps, 24 * layout.steps_per_hour)
        month, date = scene.setting.date(day)
        hour, minute = divmod(step * 60 // layout.steps_per_hour, 60)
        self._text.set_text(
            f"{scene.building.name}, {scene.building.place}    {month:02d}-{date:02d} {hour:02d}:{minute:02d}"
            f"    outdoors {scene.observation[slot]:.1f} °C, {scene.observation[slot + 1]:.0f} % RH"
        )
        self.cells[0].shown = self._text.get_text()
        return False


@dataclass(frozen=True)
class _Area:
    """The floor area of a zone on a floor of the building."""

    floor: int
    zone: int
    corners: Array


@dataclass(frozen=True)
class _ZoneLabel:
    """The label of a zone."""

    text: Any
    #: Its lines, with places for temperature and target.
    template: str


class _Plan:
    """The floor plan, colored by the deviation from target."""

    def __init__(self, layout: Layout, axes: Any) -> None:
        from matplotlib import colormaps
        from matplotlib.patches import Polygon

        self._colors = colormaps["coolwarm"]
        self._areas = _areas(layout)
        corners = np.concatenate([area.corners for area in self._areas]) if self._areas else np.zeros((1, 2))
        low, size = corners.min(0), np.ptp(corners, axis=0) + 1e-9
        floors = max((area.floor + 1 for area in self._areas), default=1)
        columns = max(range(1, floors + 1), key=lambda count: _scale(size, count, -(-floors // count)))

        def corner_of(floor: int) -> Array:
            row, column = divmod(floor, columns)
            return np.array([column, -row]) * size * _FLOOR_DISTANCE

        outlines = [area.corners - low + corner_of(area.floor) for area in self._areas]
        style: dict[str, Any] = {"edgecolor": "0.25", "linewidth": 0.8, "animated": True}
        self._patches = [axes.add_patch(Polygon(outline, **style)) for outline in outlines]
        axes.set_aspect("equal", anchor="W")
        axes.autoscale_view()
        axes.axis("off")
        axes.apply_aspect()
        if floors > 1:
            for floor in range(floors):
                place = corner_of(floor) + [0, size[1] * 1.02]
                axes.text(*place, f"floor {floor + 1} of {floors}", fontsize=_MIN_LABEL, color="0.4")
        title = f"air temperature / target, °C    blue: too cold, red: too warm (±{_MAX_DEVIATION:.0f} K)"
        axes.set_title(title, fontsize=_TITLE, loc="left")
        self._labels = [
            _zone_label(axes, outline, layout.zones[area.zone]) for area, outline in zip(self._areas, outlines)
        ]
        # Zones touch, so the plan is one cell.
        self.cells = [_Cell(axes.bbox, [*self._patches, *(label.text for label in self._labels)])]

    def update(self, scene: Scene) -> bool:
        layout = scene.layout
        targets = dict(zip(layout.controlled_zones, layout.targets_in(scene.observation)))
        shown = []
        for area, patch, label in zip(self._areas, self._patches, self._labels):
            zone = layout.zones[area.zone]
            temperature, target = scene.observation[zone.temperature_slot], targets.get(zone.name)
            color: Any = (0.92, 0.92, 0.92)
            if target is not None:
                color = self._colors((temperature - target) / (2 * _MAX_DEVIATION) + 0.5)
            patch.set_facecolor(color)
            label.text.set_text(label.template.format(temperature=temperature, target=target))
            shown.append((label.text.get_text(), color))
        self.cells[0].shown = shown
        return False


class _Actuators:
    """The applied action, relative to its bounds."""

    def __init__(self, layout: Layout, axes: Any) -> None:
        from matplotlib.transforms import Bbox

        count = len(layout.action)
        height = axes.get_window_extent().height / max(count, 1) * 72 / _DPI
        size = min(_LABEL, max(_MIN_LABEL, height / _LINE))
        self._low = layout.action_low
        self._span = np.where(layout.action_high > layout.action_low, layout.action_high - layout.action_low, 1.0)
        self._units = ["" if actuator.unit == "1" else f" {actuator.unit}" for actuator in layout.action]
        positions = range(count)
        axes.barh(positions, np.ones(count), color="0.93", height=0.85)
        self._bars = axes.barh(positions, np.zeros(count), color="#4c78a8", alpha=0.45, height=0.85, animated=True)
        for position, actuator in enumerate(layout.action):
            axes.text(0.01, position, actuator.name, va="center", fontsize=size)
        style = {"va": "center", "ha": "right", "fontsize": size, "animated": True}
        self._values = [axes.text(0.99, position, "", **style) for position in positions]
        axes.set_xlim(0, 1)
        axes.set_ylim(max(count, 12) - 0.5, -0.5)
        axes.axis("off")
        axes.set_title("applied action; bars: share of the range", fontsize=_TITLE, loc="left")
        rows = [Bbox([[0.0, position + 0.5], [1.0, position - 0.5]]) for position in positions]
        boxes = [row.transformed(axes.transData) for row in rows]
        self.cells = [_Cell(box, [bar, text]) for box, bar, text in zip(boxes, self._bars, self._values)]

    def update(self, scene: Scene) -> bool:
        values = np.full(len(self._units), np.nan) if scene.applied_action is None else scene.applied_action
        shares = np.nan_to_num((values - self._low) / self._span)
        rows = zip(self.cells, self._bars, shares, self._values, values, self._units)
        for cell, bar, share, text, value, unit in rows:
            bar.set_width(share)
            text.set_text("" if np.isnan(value) else f"{value:.2f}{unit}")
            cell.shown = (text.get_text(), round(share, 3))
        return False


class _Power:
    """HVAC power of the last hours."""

    def __init__(self, layout: Layout, axes: Any) -> None:
        self._axes, self._rate = axes, layout.steps_per_hour
        style: list[dict[str, Any]] = [
            {"label": "electricity", "color": "#4c78a8"},
            {"label": "gas", "color": "#f58518"},
        ]
        self._areas = [axes.fill_between([], [], linewidth=0, animated=True, **each) for each in style]
        axes.set_xlim(-_HOURS, 0)
        ticks = range(-_HOURS, 1, 6)
        axes.set_xticks(ticks, [f"{tick} h".replace("-", "−") if tick else "now" for tick in ticks])
        axes.set_ylim(0, _MIN_POWER)
        axes.tick_params(labelsize=_MIN_LABEL)
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_title("HVAC power, W/m²", fontsize=_TITLE, loc="left")
        axes.legend(fontsize=_MIN_LABEL, loc="lower right", bbox_to_anchor=(1, 1), frameon=False, ncols=2)
        # Padded by the pixels that the areas' antialiased edges touch.
        self.cells = [_Cell(axes.bbox.padded(2), list(self._areas))]

    def update(self, scene: Scene) -> bool:
        rows = scene.power.rows()
        self.cells[0].shown = rows.tobytes()
        steps, electricity, gas = rows.T
        hours, total = (steps - scene.steps) / self._rate, electricity + gas
        for area, low, high in zip(self._areas, (np.zeros_like(total), electricity), (electricity, total)):
            outline = np.concatenate([np.c_[hours, low], np.c_[hours, high][::-1]])
            area.set_verts([outline])
        _, top = self._axes.get_ylim()
        needed = _MIN_POWER
        while needed < total.max():
            needed *= 2
        self._axes.set_ylim(0, needed)
        return bool(needed != top)


def _areas(layout: Layout) -> list[_Area]:
    """Returns the floor areas of the zones, from the lowest floor up; floors without controlled zones are left out."""
    outlines = [(zone, np.array(corners)) for zone, corners in layout.spaces.floors()]
    heights: list[float] = []
    for height in sorted({round(float(corners[:, 2].mean()), 1) for _, corners in outlines}):
        if not heights or height - heights[-1] > 1.0:
            heights.append(height)

    def floor_of(corners: Array) -> int:
        return max(floor for floor, height in enumerate(heights) if corners[:, 2].mean() >= height - 0.5)

    areas = [_Area(floor_of(corners), zone, corners[:, :2]) for zone, corners in outlines]
    shown = sorted({area.floor for area in areas if layout.zones[area.zone].controlled})
    return [_Area(shown.index(each.floor), each.zone, each.corners) for each in areas if each.floor in shown]


def _zone_label(axes: Any, outline: Array, zone: _core.Zone) -> _ZoneLabel:
    """Makes the label of a zone: as much of name, temperature and target as fits, along its longer side."""
    width, height = np.ptp(axes.transData.transform(outline), axis=0) * 72 / _DPI
    upright = bool(height > 1.5 * width)
    along, across = (height, width) if upright else (width, height)
    values = "{temperature:.1f} / {target:.0f}" if zone.controlled else "{temperature:.1f}"
    name = zone.name.replace("{", "{{").replace("}", "}}")
    candidates = [f"{name}\n{values}", f"{name} {values}", values]

    def fits(template: str, size: float) -> bool:
        lines = template.format(temperature=20.0, target=20.0).split("\n")
        longest = max(len(line) for line in lines) * _CHARACTER * size
        return longest <= along and len(lines) * _LINE * size <= across

    sizes = (_LABEL, _MIN_LABEL)
    fitting = ((template, size) for template in candidates for size in sizes if fits(template, size))
    template, size = next(fitting, ("{temperature:.1f}", _MIN_LABEL))
    x, y = _centroid(outline)
    style = {"ha": "center", "va": "center", "rotation": 90 if upright else 0, "animated": True}
    return _ZoneLabel(axes.text(x, y, "", fontsize=size, **style), template)


def _scale(size: Array, columns: int, rows: int) -> float:
    """Returns the scale at which floors fit in the plan area in this many columns and rows."""
    return float(min(_PLAN_ASPECT / (size[0] * columns), 1 / (size[1] * rows)))


def _centroid(xy: Array) -> Array:
    """Returns the centroid of a polygon."""
    x, y = xy.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2
    if abs(area) < 1e-9:
        return np.asarray(xy.mean(0))
    moments = np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()])
    return moments / (6 * area)
