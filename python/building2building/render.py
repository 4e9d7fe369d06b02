"""A frame of an episode: floor plan with temperatures against target, actuators, weather, power."""

from __future__ import annotations

from collections import deque

import numpy as np

from .errors import need

#: Colours reach from this much below to this much above target, K.
_SPAN = 4.0
#: Hours of power that are shown.
_HOURS = 24
#: Levels of a building are this many times their size apart.
_GAP = 1.1
#: Width over height of the room for the plan.
_ROOM = 1.6


class Renderer:
    """Draws one environment. The plan is made once for a building."""

    def __init__(self, env):
        need("matplotlib", "plots")
        self._of = None
        self._figure = None
        self._window = None
        self._image = None
        self._power: deque = deque()

    def _plan(self, env):
        """Floors of the zones, level by level: (level, zone, x and y of the corners)."""
        floors = [(zone, np.array(corners)) for zone, is_floor, corners in env.layout.core.faces() if is_floor]
        heights = sorted({round(float(corners[:, 2].mean()), 1) for _, corners in floors})
        levels: list[float] = []
        for height in heights:
            if not levels or height - levels[-1] > 1.0:
                levels.append(height)
        at = [
            (max(i for i, height in enumerate(levels) if corners[:, 2].mean() >= height - 0.5), zone, corners[:, :2])
            for zone, corners in floors
        ]
        zones = env.layout.data["zones"]
        # A level with nothing but attics and plenums says nothing.
        shown = sorted({level for level, zone, _ in at if zones[zone]["controlled"]})
        return [(shown.index(level), zone, xy) for level, zone, xy in at if level in shown], max(len(shown), 1)

    def draw(self, env, show: bool):
        """The frame as an array (height, width, 3) of u8; with ``show``, in a window."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        if self._of is not env.building:
            self._of, self._layout = env.building, self._plan(env)
        if self._figure is None:
            self._figure = Figure(figsize=(9.6, 5.4), dpi=100)
            self._canvas = FigureCanvasAgg(self._figure)
        figure = self._figure
        figure.clear()
        polygons, levels = self._layout
        grid = figure.add_gridspec(
            2,
            2,
            width_ratios=[3, 2],
            height_ratios=[3, 1],
            left=0.03,
            right=0.99,
            top=0.9,
            bottom=0.05,
            hspace=0.15,
            wspace=0.03,
        )
        plan = figure.add_subplot(grid[0, 0])
        self._draw_plan(env, plan, polygons, levels)
        self._draw_actuators(env, figure.add_subplot(grid[:, 1]))
        self._draw_power(env, figure.add_subplot(grid[1, 0]))
        figure.suptitle(self._title(env), fontsize=10, x=0.01, ha="left")
        self._canvas.draw()
        frame = np.asarray(self._canvas.buffer_rgba())[..., :3].copy()
        if show:
            self._show(frame)
            return None
        return frame

    @staticmethod
    def _title(env) -> str:
        data, observation = env.layout.data, env.observation
        at = data["outdoor_temperature"]
        day, hour = divmod(env.steps, 24 * data["steps_per_hour"])
        date = np.datetime64("2017-01-01") + env.setting.first_day() - 1 + day
        clock = hour / data["steps_per_hour"]
        return (
            f"{env.building.name}, {env.building.place}    {str(date)[5:]} {int(clock):02d}:{int(clock % 1 * 60):02d}"
            f"    outdoors {observation[at]:.1f} °C, {observation[at + 1]:.0f} %"
        )

    def _draw_plan(self, env, axes, polygons, levels):
        from matplotlib import colormaps
        from matplotlib.patches import Polygon

        layout, data = env.layout, env.layout.data
        targets = dict(zip(layout.zones, layout.targets_in(env.observation)))
        colours = colormaps["coolwarm"]
        corners = np.concatenate([xy for _, _, xy in polygons]) if polygons else np.zeros((1, 2))
        low, size = corners.min(0), np.ptp(corners, axis=0) + 1e-9
        columns = max(range(1, levels + 1), key=lambda count: _scale(size, count, -(-levels // count)))
        crowded = len(polygons) > 8
        for level, zone, xy in polygons:
            about = data["zones"][zone]
            temperature = env.observation[about["temperature_slot"]]
            target = targets.get(about["name"])
            colour = (0.92, 0.92, 0.92) if target is None else colours((temperature - target) / (2 * _SPAN) + 0.5)
            row, column = divmod(level, columns)
            xy = xy - low + np.array([column, row]) * size * _GAP
            axes.add_patch(Polygon(xy, facecolor=colour, edgecolor="0.25", linewidth=0.8))
            text = f"{temperature:.1f}" + ("" if target is None or crowded else f" / {target:.0f}")
            axes.text(*_inside(xy), text, ha="center", va="center", fontsize=6 if crowded else 8)
        axes.set_aspect("equal")
        axes.autoscale_view()
        axes.axis("off")
        title = "zones, °C" if crowded else "zones, °C / target"
        axes.set_title(f"{title}; blue is too cold, red too warm, by up to {_SPAN:.0f} K", fontsize=8, loc="left")

    @staticmethod
    def _draw_actuators(env, axes):
        layout = env.layout
        names = [actuator["name"] for actuator in layout.data["action"]]
        units = [actuator["unit"] for actuator in layout.data["action"]]
        values = env.carried_out() if env.steps else np.full(len(names), np.nan)
        span = np.where(layout.action_high > layout.action_low, layout.action_high - layout.action_low, 1.0)
        shares = np.nan_to_num((values - layout.action_low) / span)
        places = np.arange(len(names))
        axes.barh(places, np.ones(len(names)), color="0.93", height=0.8)
        axes.barh(places, shares, color="#a9c4e0", height=0.8)
        size = 6.5 if len(names) <= 16 else 4.5
        for place, (name, unit, value) in enumerate(zip(names, units, values)):
            number = "" if np.isnan(value) else f"  {value:.2f} {unit if unit != '1' else ''}"
            axes.text(0.01, place, name + number, va="center", fontsize=size)
        axes.set_xlim(0, 1)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.axis("off")
        axes.set_title("actuators, within their bounds", fontsize=8, loc="left")

    def _draw_power(self, env, axes):
        layout = env.layout
        rate = layout.steps_per_hour
        while self._power and self._power[-1][0] >= env.steps:
            self._power.pop()
        now = env.observation
        self._power.append((env.steps, now[layout.electricity] * rate, now[layout.gas] * rate))
        while self._power[0][0] < env.steps - _HOURS * rate:
            self._power.popleft()
        steps, electricity, gas = np.array(self._power).T
        hours = (steps - env.steps) / rate
        axes.stackplot(hours, electricity, gas, labels=["electricity", "gas"], colors=["#4c78a8", "#f58518"])
        axes.set_xlim(-_HOURS, 0)
        axes.set_ylim(bottom=0)
        axes.tick_params(labelsize=6)
        axes.set_title("HVAC power, W/m², the last 24 h", fontsize=8, loc="left")
        axes.legend(fontsize=6, loc="upper left", frameon=False)

    def _show(self, frame):
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

    def close(self):
        """Closes the window."""
        if self._window is not None:
            from matplotlib import pyplot

            pyplot.close(self._window)
            self._window = None


def _scale(size: np.ndarray, columns: int, rows: int) -> float:
    """How large levels can be drawn in so many columns and rows."""
    return min(_ROOM / (size[0] * columns), 1 / (size[1] * rows))


def _inside(xy: np.ndarray) -> np.ndarray:
    """The centroid of a polygon."""
    x, y = xy.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2
    if abs(area) < 1e-9:
        return xy.mean(0)
    around = np.array([((x + np.roll(x, -1)) * cross).sum(), ((y + np.roll(y, -1)) * cross).sum()])
    return around / (6 * area)
