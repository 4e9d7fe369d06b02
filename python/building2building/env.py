"""A building as a Gymnasium environment."""

from __future__ import annotations

import atexit
import json
import os
import threading
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import gymnasium
import numpy as np

from . import _core
from .buildings import Building, find_building, list_buildings
from .errors import EpisodeError, ProcessError, SettingError
from .info import Info
from .morphology import Morphology

_open: weakref.WeakSet = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    for each in list(_open):
        each.close()


def resolve(
    building_type: str | None,
    split: str = "train",
    index: int | None = None,
    building_id: str | None = None,
    place: str | None = None,
    weather: str | os.PathLike | None = None,
    building: Building | None = None,
) -> Building:
    """The building that the arguments of :func:`make_env` name."""
    if building is not None:
        return building
    if building_id is not None:
        return find_building(building_id, place, weather)
    if building_type is None:
        raise SettingError("name a building: give a type, a building_id, or a building")
    if index is not None:
        ids = list_buildings(building_type, split)
        if not 0 <= index < len(ids):
            raise SettingError(f"index {index}: split `{split}` of {building_type} has 0 to {len(ids) - 1}")
        return find_building(ids[index], place, weather)
    return find_building(building_type, place, weather)


class Layout:
    """Where is what in the vectors of an environment; made from the core's spaces."""

    def __init__(self, spaces: _core.Spaces):
        self.core = spaces
        self.data: dict[str, Any] = json.loads(spaces.to_json())
        data = self.data
        self.observation_low = np.array([slot["low"] for slot in data["observation"]])
        self.observation_high = np.array([slot["high"] for slot in data["observation"]])
        self.action_low = np.array([actuator["low"] for actuator in data["action"]])
        self.action_high = np.array([actuator["high"] for actuator in data["action"]])
        controlled = [zone for zone in data["zones"] if zone["controlled"]]
        self.zones = [zone["name"] for zone in controlled]
        self.temperatures = np.array([zone["temperature_slot"] for zone in controlled], dtype=int)
        moving = data["constant_target"] is None
        self.targets = np.array([zone["target_slot"] for zone in controlled], dtype=int) if moving else None
        self.occupancies = np.array([zone["occupancy_slot"] for zone in controlled], dtype=int) if moving else None
        self.steps_per_hour: int = data["steps_per_hour"]
        self.electricity: int = data["electricity"]
        self.gas: int = data["gas"]

    def targets_in(self, observation: np.ndarray) -> np.ndarray:
        """Target of every controlled zone for the step after an observation (or many of them), °C."""
        if self.targets is None:
            return np.full((*observation.shape[:-1], len(self.zones)), self.data["constant_target"])
        return observation[..., self.targets]

    def metadata(self) -> dict[str, Any]:
        """Names and units of what is seen and driven."""
        data = self.data
        return {
            "building": data["name"],
            "observation_names": [slot["name"] for slot in data["observation"]],
            "observation_units": [slot["unit"] for slot in data["observation"]],
            "action_names": [actuator["name"] for actuator in data["action"]],
            "action_units": [actuator["unit"] for actuator in data["action"]],
            "zones": [zone["name"] for zone in data["zones"]],
            "controlled_zones": self.zones,
            "conditioned_floor_area": data["conditioned_floor_area"],
            "energy_scale": data["energy_scale"],
        }


def _inward(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds as f32 that are within those in f64."""
    single = low.astype(np.float32)
    low32 = np.where(single < low, np.nextafter(single, np.float32(np.inf)), single)
    single = high.astype(np.float32)
    high32 = np.where(single > high, np.nextafter(single, np.float32(-np.inf)), single)
    return low32, np.maximum(low32, high32)


def observation_box(layout: Layout) -> gymnasium.spaces.Box:
    """The observation space, f32."""
    low, high = layout.observation_low.astype(np.float32), layout.observation_high.astype(np.float32)
    return gymnasium.spaces.Box(low, high, dtype=np.float32)


def action_box(layout: Layout, rescale: bool) -> gymnasium.spaces.Box:
    """The action space, f32: physical units, or shares from -1 to 1."""
    if rescale:
        return gymnasium.spaces.Box(-1.0, 1.0, (len(layout.action_low),), dtype=np.float32)
    low, high = _inward(layout.action_low, layout.action_high)
    return gymnasium.spaces.Box(low, high, dtype=np.float32)


class StepInfo(Info):
    """The info of a step, made of what the step was judged by when it is read."""

    __slots__ = ("made_of",)

    # One is made at every step: without a call of Python's, and with one thing to keep.
    __init__ = dict.__init__

    def _filled(self) -> Info:
        if self.made_of is None:
            return self
        layout, setting, before, after, temperature, energy, step = self.made_of
        electricity, gas = float(after[layout.electricity]), float(after[layout.gas])
        hour = (step - 1) % (24 * layout.steps_per_hour) / layout.steps_per_hour
        cost, emissions = setting.cost_and_emissions(electricity, gas, hour)
        temperatures, targets = after[layout.temperatures], layout.targets_in(before)
        info = {
            "step": step,
            "hour": hour,
            "reward_terms": {"temperature": -temperature, "energy": -energy},
            "energy": {"electricity": electricity, "gas": gas},
            "cost": cost,
            "emissions": emissions,
            "zone_temperature": temperatures,
            "zone_target": targets,
            "zone_deviation": temperatures - targets,
            "observation": after,
        }
        if layout.occupancies is not None:
            info["zone_occupied"] = before[layout.occupancies] > 0.5
        self.made_of = None
        return self._take(info)


@dataclass(frozen=True)
class _Position:
    """What of an environment is not in its process."""

    layout: Layout
    setting: Any
    observation: np.ndarray
    steps: int
    truncated: bool


class Snapshot:
    """An episode where it stood: a process of its own, until :meth:`release` or the end of its environment."""

    def __init__(self, env: BuildingEnv, number: int, position: _Position):
        self._env = weakref.ref(env)
        self._number = number
        self._position = position
        self._finalizer = weakref.finalize(self, env._core.release, number)

    def release(self) -> None:
        """Ends its process."""
        self._finalizer()


class BuildingEnv(gymnasium.Env):
    """A building on EnergyPlus; :func:`make_env` makes one.

    - Observation: ``Box`` f32, ``metadata["observation_names"]`` and ``["observation_units"]``: air temperature of
      every zone (°C), outdoor temperature (°C) and humidity (%), clock, electricity and gas of the step (Wh/m²); where
      targets move, occupancy and target (°C) of every controlled zone for the step to come. :attr:`observation` is the
      same in f64.
    - Action: ``Box`` f32, one value an actuator, in physical units; from -1 to 1 with ``rescale_action``. f64 is taken
      as it is.
    - Reward: minus the mean squared deviation from target over the controlled zones (K²), minus the task's weight times
      energy; ``info["reward_terms"]`` has both.
    - End: truncated at the end of the run period; never terminated.

    The simulation is in a process of its own, so any number of environments run at once, in any threads.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 12}

    def __init__(
        self,
        building_type: str | None = None,
        *,
        split: str = "train",
        index: int | None = None,
        building_id: str | None = None,
        building: Building | None = None,
        place: str | None = None,
        weather: str | os.PathLike | None = None,
        task: str | dict = "constant",
        run_period: str = "winter",
        timesteps_per_hour: int = 12,
        rescale_action: bool = False,
        window_days: int | None = None,
        window_starts: int = 8,
        resample_targets: bool = False,
        reward: Callable[[dict[str, Any]], float] | None = None,
        render_mode: str | None = None,
        in_process: bool = False,
    ):
        self._core = None
        self._arguments = {name: value for name, value in locals().items() if name not in ("self", "__class__")}
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise SettingError(f"render_mode is `{render_mode}`: give rgb_array, human or None")
        if in_process and window_days is not None:
            raise SettingError("window_days needs a process of its own: leave in_process=False")
        self.building = resolve(building_type, split, index, building_id, place, weather, building)
        self.task = json.dumps(task) if isinstance(task, dict) else str(task)
        self.run_period, self.timesteps_per_hour = run_period, timesteps_per_hour
        self.rescale_action = rescale_action
        self.render_mode = render_mode
        self._window = None if window_days is None else (window_days, window_starts)
        self._resample_targets = resample_targets
        self._reward = reward
        self._renderer = None
        self._thread = threading.get_ident() if in_process else None
        self._process = os.getpid()
        self._whole = self._setting(self.building, self.task)
        self.setting = self._whole
        if self._window is not None:
            self.setting.window(*self._window, 0)
        self._core = _core.LocalEnv(self.setting) if in_process else _core.Env(self.setting)
        _open.add(self)
        self._began = False
        self._adopt()

    def _setting(self, building: Building, task: str) -> _core.Setting:
        return _core.Setting(building._core, self.run_period, self.timesteps_per_hour, task)

    def _adopt(self) -> None:
        """Takes over the spaces of the building that the core has now."""
        self.layout = Layout(self._core.spaces())
        self.observation_space = observation_box(self.layout)
        self.action_space = action_box(self.layout, self.rescale_action)
        self.metadata = {**type(self).metadata, **self.layout.metadata(), "task": json.loads(self.setting.task())}
        self._morphology = None
        self.observation = np.zeros(len(self.layout.observation_low))
        self._steps = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None):
        """Begins an episode at the end of the building's warm-up: milliseconds, once the building is ready.

        ``seed`` drives what is drawn: the window of days with ``window_days``, the targets of a random task with
        ``resample_targets``. The rest of an episode is the same every time.
        """
        super().reset(seed=seed)
        self._check_thread()
        if os.getpid() != self._process:
            self._move_here()
        setting, steps = self._whole, None
        if self._resample_targets:
            setting = self._setting(self.building, self._drawn_task())
        if self._window is not None:
            setting, steps = setting.window(*self._window, int(self.np_random.integers(2**63)))
        if setting is not self.setting:
            self.setting = setting
            if self._thread is not None:
                self._core = _core.LocalEnv(setting)
            else:
                self._core.set(setting)
        single, self.observation = self._core.reset() if self._thread is not None else self._core.reset(steps)
        self._steps, self._began, self._truncated = 0, True, False
        self._episode_steps = steps or self.layout.data["episode_steps"]
        building = self.building
        info = Info(lambda: {"building": building.name, "first_day": setting.first_day()})
        if self.render_mode == "human":
            self.render()
        return single, info

    def _drawn_task(self) -> str:
        task = json.loads(self._whole.task())
        if task["setpoints"].get("mode") != "random":
            raise SettingError(f"resample_targets is for random targets, and the task is `{self.task}`: give random")
        task["setpoints"]["seed"] = int(self.np_random.integers(2**32))
        return json.dumps(task)

    def _check_thread(self) -> None:
        if self._core is None:
            raise EpisodeError("the environment is closed")
        if self._thread is not None and self._thread != threading.get_ident():
            raise ProcessError(
                "an environment with in_process=True stays with the thread that made it: make it without, and any "
                "thread may use it"
            )

    def _move_here(self) -> None:
        """In a fork: leaves the processes to the parent, and has others here."""
        if self._thread is not None:
            raise ProcessError("an environment with in_process=True cannot be used in a fork: make another there")
        self._core, self._process = _core.Env(self._whole), os.getpid()
        self.setting = self._whole

    def step(self, action, *, rescale: bool | None = None):
        """One zone time step: 5 minutes by default.

        ``rescale`` tells whether this action is from -1 to 1, where it is not as the environment was made.
        """
        # All of it in one place: next to the engine's memory, a call of Python's own is what costs.
        if self._core is None or (self._thread is not None and self._thread != threading.get_ident()):
            self._check_thread()
        rescale = self.rescale_action if rescale is None else rescale
        single, after, temperature, energy, truncated = self._core.step(action, rescale)
        before, self.observation = self.observation, after
        self._penalties = temperature, energy
        self._steps += 1
        self._truncated = truncated
        info = StepInfo()
        info.made_of = self.layout, self.setting, before, after, temperature, energy, self._steps
        if truncated:
            info["metrics"] = self._core.metrics()
        reward = -temperature - energy if self._reward is None else float(self._reward(info))
        if self.render_mode == "human":
            self.render()
        return single, reward, False, truncated, info

    @property
    def penalties(self) -> tuple[float, float]:
        """Temperature and energy penalty of the last step: the task's reward is minus both."""
        return self._penalties

    def carried_out(self) -> np.ndarray:
        """The last action as it was carried out: f64, physical units, within bounds."""
        return self._core.carried_out()

    def physical(self, action) -> np.ndarray:
        """An action of this environment in physical units."""
        action = np.asarray(action, dtype=np.float64)
        if not self.rescale_action:
            return action
        share = (action + 1) / 2
        return self.layout.action_low * (1 - share) + self.layout.action_high * share

    @property
    def steps(self) -> int:
        """Steps done in the episode."""
        return self._steps

    @property
    def episode_steps(self) -> int:
        """Steps of the whole run period."""
        return self.layout.data["episode_steps"]

    @property
    def morphology(self) -> Morphology:
        """The building as a graph."""
        if self._morphology is None:
            self._morphology = Morphology(self.layout.core.morphology())
        return self._morphology

    @property
    def description(self) -> dict[str, Any]:
        """What the building is, in numbers, as in ``b2b show --json``."""
        return json.loads(self.layout.core.description())

    def set_building(self, building: Building | str) -> None:
        """Makes another building that of the episodes to come. Its spaces become this environment's."""
        self.building = building if isinstance(building, Building) else find_building(building)
        self._check_thread()
        self._arguments["building"] = self.building
        self._whole = self.setting = self._setting(self.building, self.task)
        if self._thread is not None:
            self._core = _core.LocalEnv(self.setting)
        else:
            self._core.set(self.setting)
        self._began = False
        self._adopt()

    def snapshot(self) -> Snapshot:
        """Keeps the episode where it stands: milliseconds. :meth:`restore` goes back to it, any number of times."""
        if self._thread is not None:
            raise ProcessError("snapshots need a process of their own: make the environment without in_process=True")
        if not self._began:
            raise EpisodeError("no episode is in progress: call reset before snapshot")
        position = _Position(self.layout, self.setting, self.observation, self._steps, self._truncated)
        return Snapshot(self, self._core.snapshot(), position)

    def restore(self, snapshot: Snapshot) -> tuple[np.ndarray, dict[str, Any]]:
        """Goes back to a snapshot of this environment, and gives the observation there."""
        if snapshot._env() is not self:
            raise EpisodeError("this snapshot is of another environment")
        self._core.restore(snapshot._number)
        there = snapshot._position
        self.layout, self.setting, self._steps = there.layout, there.setting, there.steps
        self.observation, self._truncated = there.observation, there.truncated
        return self.observation.astype(np.float32), Info(lambda: {"building": self.building.name})

    def render(self):
        """A picture of the floor plan: an array (height, width, 3) of u8, or a window."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() without a render_mode: make the environment with render_mode='rgb_array'")
            return None
        if self._renderer is None:
            from .render import Renderer

            self._renderer = Renderer(self)
        return self._renderer.draw(self, show=self.render_mode == "human")

    def close(self) -> None:
        """Ends the environment's processes."""
        core, self._core = getattr(self, "_core", None), None
        if core is not None and os.getpid() == self._process:
            if self._thread is None or self._thread == threading.get_ident():
                core.close()
        if getattr(self, "_renderer", None) is not None:
            self._renderer.close()
            self._renderer = None

    def __del__(self):
        try:
            self.close()
        except Exception:  # the interpreter may be half gone
            pass

    def __reduce__(self):
        """Pickles as how it was made: what comes out has processes of its own, and stands before its first reset."""
        return _remake, (self._arguments, self.spec)

    def __str__(self) -> str:
        return f"<{type(self).__name__} {self.building.name}>"


def _remake(arguments: dict[str, Any], spec) -> BuildingEnv:
    env = BuildingEnv(**arguments)
    env.spec = spec
    return env


def make_env(building_type: str | None = None, **arguments) -> BuildingEnv:
    """Makes an environment: ``make_env("OfficeSmall")``, or with any of these.

    - ``split`` and ``index``: that building of the dataset's ``train``, ``test`` or ``test_small``; ``building_id``:
      ``"OfficeSmall-0042"``; ``building``: of :func:`generate`, :func:`import_building`. Without any, the type's own
      model, at its home, at ``place``, or under a ``weather`` file.
    - ``task``: ``constant``, ``occupancy+energy0.5``, ``random:7+cost2``..., a JSON file, or a dictionary;
      ``run_period``: ``winter``, ``summer``, ``full_year`` or ``01-01..01-07``; ``timesteps_per_hour``.
    - ``rescale_action``: actions from -1 to 1 in place of physical units; the default of ``gymnasium.make``.
    - ``window_days``, ``window_starts``: episodes of so many days from a random one of so many first days;
      ``resample_targets``: other targets each episode, for random tasks. Both follow the seed of ``reset``.
    - ``reward``: your own, a function of the step's info, in place of the task's.
    - ``render_mode``; ``in_process``: in this process, for debuggers; one at a time, in one thread.
    """
    if building_type is None:
        return BuildingEnv(**arguments)
    name = _type_name(building_type)
    return gymnasium.make(f"b2b/{name}-v0", **{"rescale_action": False, **arguments})


def _type_name(text: str) -> str:
    for name, _, _ in _core.building_types():
        if name.lower() == text.lower():
            return name
    find_building(text)  # raises, and tells which was meant
    raise SettingError(f"`{text}` is no type: give it as building_id")
