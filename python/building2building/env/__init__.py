"""A building as a Gymnasium environment."""

from __future__ import annotations

import inspect
import json
import math
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import copy, deepcopy
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..buildings import Building, PathLike, checked_weather, find_building, select_building
from ..errors import EpisodeError, ProcessError, SettingError
from .info import StepInfo
from .layout import Layout
from .morphology import Metadata, Morphology
from .open_envs import close_at_exit
from .physical_actions import warn_of_learner, warn_of_zeros
from .render import PowerHistory, Renderer, Scene
from .snapshot import Position, Snapshot
from .tasks import check_count, task_text, windows


class BuildingEnv(gymnasium.Env[NDArray[np.float32], ArrayLike]):
    """A building simulated by EnergyPlus; :func:`make_env` makes one.

    - Observation: ``Box`` f32, with names and units in ``metadata["observation_names"]`` and
      ``metadata["observation_units"]``: air temperature of every zone (°C), outdoor temperature (°C) and relative
      humidity (%), time, HVAC electricity and gas of the step (Wh/m²); for the next step and every controlled zone,
      occupancy with the setpoints of heating and cooling (°C), or with a target that changes over time.
      :attr:`observation` is the same in f64.
    - Action: ``Box`` f32, one value per actuator, in physical units, or in [-1, 1] with ``rescale_action``. Actions in
      f64 are not rounded.
    - Metadata: names and units of the slots, the task, the zones, and ``["morphology"]``, the building as a graph.
    - Reward: minus a comfort penalty, averaged over the controlled zones, minus the weighted cost or energy of the
      step: see docs/tasks.md. ``info["reward_terms"]`` has both terms.
    - Episode end: truncated at the end of the run period; never terminated.

    Every environment runs its simulation in its own process, so any number can run at once, from any thread.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 12}
    observation_space: Box[np.float32]
    action_space: Box

    def __init__(
        self,
        building_type: str | None = None,
        *,
        split: str | None = None,
        index: int | None = None,
        building_id: str | None = None,
        building: Building | None = None,
        place: str | None = None,
        weather: PathLike | None = None,
        control: str = "actuators",
        task: str | dict[str, Any] = "operate",
        run_period: str = "winter",
        timesteps_per_hour: int = 12,
        rescale_action: bool = False,
        window_days: int | None = None,
        window_starts: int | None = None,
        weather_years: Sequence[PathLike] = (),
        resample_targets: bool = False,
        reward: Callable[[dict[str, Any]], float] | None = None,
        render_mode: str | None = None,
        in_process: bool = False,
        keep_engine_output: PathLike | None = None,
    ):
        self._core: _core.Env | _core.LocalEnv | None = None
        self._renderer: Renderer | None = None
        self._arguments = {name: value for name, value in locals().items() if name not in ("self", "__class__")}
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise SettingError(f"unknown render_mode `{render_mode}`; expected rgb_array, human or None")
        if reward is not None and not callable(reward):
            raise SettingError(f"reward is {reward!r}; expected a function of a step's info")
        in_process = in_process or keep_engine_output is not None
        if in_process and (window_days is not None or weather_years):
            message = "window_days and weather_years are not available with in_process=True or keep_engine_output"
            raise SettingError(message)
        self.building = select_building(building_type, split, index, building_id, place, weather, building, control)
        self.task = task_text(task)
        self.run_period, self.timesteps_per_hour = run_period, timesteps_per_hour
        self.rescale_action = rescale_action
        self.render_mode = render_mode
        self._window = windows(window_days, window_starts)
        check_count("timesteps_per_hour", timesteps_per_hour)
        self._weather_years = checked_weather(weather_years)
        self._resample_targets = resample_targets
        self._reward = reward
        self._engine_output = keep_engine_output
        self._thread = threading.get_ident() if in_process else None
        self._process = os.getpid()
        self._finish_run = False
        #: For :func:`rollout`: steps apply the second action, in physical units, instead of the first, or of any.
        self._exact: tuple[NDArray[np.float64] | None, NDArray[np.float64]] | None = None
        self._base_setting = self._setting_of(self.task)
        #: Building, run period, time step and task of the episode.
        self.setting = self._base_setting
        if self._window is not None:
            self.setting.window(*self._window, 0)  # raises if the windows do not fit
        self._core = self._local(self.setting) if in_process else _core.Env(self.setting)
        close_at_exit(self)
        self._started = False
        self._read_spaces()

    def _setting_of(self, task: str) -> _core.Setting:
        return _core.Setting(self.building._core, self.run_period, self.timesteps_per_hour, task)

    def _local(self, setting: _core.Setting) -> _core.LocalEnv:
        return _core.LocalEnv(setting, self._engine_output)

    def _read_spaces(self) -> None:
        """Reads the spaces of the core's building."""
        self.layout = Layout(self._open_core().spaces())
        self.observation_space = self.layout.observation_space()
        self.action_space = self.layout.action_space(self.rescale_action)
        task = json.loads(self.setting.task_json())
        values = {**type(self).metadata, **self.layout.metadata(), "task": task}
        self.metadata = Metadata(values, self.layout.spaces.morphology)
        self._power = PowerHistory(self.layout)
        #: The observation in f64.
        self.observation = np.zeros(len(self.layout.observation_low))
        self._steps = 0
        self._penalties = math.nan, math.nan
        self._last_reward = math.nan
        self._truncated = False

    @property
    def has_weather_years(self) -> bool:
        """Whether every episode draws its weather."""
        return bool(self._weather_years)

    def _open_core(self) -> _core.Env | _core.LocalEnv:
        """Returns the core; raises if the environment is closed or is used from the wrong thread."""
        if self._core is None:
            raise EpisodeError("the environment is closed")
        if self._thread is not None and self._thread != threading.get_ident():
            raise ProcessError(
                "an environment with in_process=True can only be used from the thread that made it; "
                "make it without in_process"
            )
        return self._core

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode at the end of the building's warm-up; takes milliseconds once the building is ready.

        ``seed`` determines the window of days with ``window_days``, the weather with ``weather_years`` and the targets
        with ``resample_targets``. Everything else is the same in every episode. ``info`` has the name of the building,
        the weather file and the first day (of a year without 29 February, from 1).
        """
        if options:
            raise SettingError(f"the environment has no options of reset; omit {', '.join(map(str, options))}")
        super().reset(seed=seed)
        self._open_core()
        if not self.rescale_action:
            warn_of_learner()
        if os.getpid() != self._process:
            self._restart_after_fork()
        setting, steps = self._base_setting, None
        if self._resample_targets:
            setting = self._setting_of(self._task_with_new_targets())
        if self._weather_years:
            setting = setting.with_weather(self._weather_years[self.np_random.integers(len(self._weather_years))])
        if self._window is not None:
            setting, steps = setting.window(*self._window, int(self.np_random.integers(2**63)))
        if setting is not self.setting:
            self._set_setting(setting)
        core = self._open_core()
        single, self.observation = (
            core.reset() if isinstance(core, _core.LocalEnv) else core.reset(steps, self._finish_run)
        )
        self._steps, self._started, self._truncated = 0, True, False
        self._penalties = math.nan, math.nan
        if self.render_mode is not None:
            self._power.add(0, self.observation)
        info = {"building": self.building.name, "weather": str(setting.weather), "first_day": setting.first_day}
        if self.render_mode == "human":
            self.render()
        return single, info

    def _task_with_new_targets(self) -> str:
        task = json.loads(self._base_setting.task_json())
        if task["setpoints"].get("mode") != "random":
            raise SettingError(f"resample_targets needs a random task, such as `random`; got `{self.task}`")
        task["setpoints"]["seed"] = int(self.np_random.integers(2**32))
        return json.dumps(task)

    def _set_setting(self, setting: _core.Setting) -> None:
        core = self._open_core()
        if isinstance(core, _core.LocalEnv):
            self._core = self._local(setting)
        else:
            core.set_setting(setting)
        self.setting = setting

    def _restart_after_fork(self) -> None:
        """Abandons the processes of the parent, which still owns them, and starts new ones."""
        if self._thread is not None:
            raise ProcessError("an environment with in_process=True cannot be used after a fork; create another one")
        self._core, self._process = _core.Env(self._base_setting), os.getpid()
        self.setting = self._base_setting

    def step(
        self, action: ArrayLike, *, rescale: bool | None = None
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        """Applies an action for one zone time step, 5 minutes by default.

        ``rescale`` overrides ``rescale_action`` for this action.
        """
        # All in one function: the engine occupies the cache, so every Python call costs time.
        core = self._core
        if core is None or (self._thread is not None and self._thread != threading.get_ident()):
            core = self._open_core()
        rescale = self.rescale_action if rescale is None else rescale
        if self._exact is not None and (self._exact[0] is None or np.array_equal(self._exact[0], action)):
            action, rescale = self._exact[1], False
        single, after, numbers, truncated = core.step(action, rescale)
        before, self.observation = self.observation, after
        temperature, energy, *_ = numbers
        self._penalties = temperature, energy
        self._steps += 1
        self._truncated = truncated
        info = StepInfo()
        info["step"] = self._steps
        info.record = self.layout, before, after, numbers, self._steps
        if truncated:
            info["metrics"] = core.metrics()
        reward = -temperature - energy if self._reward is None else float(self._reward(info))
        self._last_reward = reward
        if self._steps == 1 and not rescale:
            warn_of_zeros(self.layout, action)
        if self.render_mode is not None:
            self._power.add(self._steps, after)
            if self.render_mode == "human":
                self.render()
        return single, reward, False, truncated, info

    @property
    def penalties(self) -> tuple[float, float]:
        """Temperature and energy penalty of the last step; the task's reward is minus their sum. NaN before the first
        step of an episode."""
        return self._penalties

    def applied_action(self) -> NDArray[np.float64]:
        """Returns the last action as applied: f64, physical units, clamped to its bounds and raised by the ventilation
        interlock."""
        return self._open_core().applied_action()

    def physical(self, action: ArrayLike) -> NDArray[np.float64]:
        """Converts an action of this environment to physical units."""
        action = np.asarray(action, dtype=np.float64)
        if not self.rescale_action:
            return action
        share = (action + 1) / 2
        return self.layout.action_low * (1 - share) + self.layout.action_high * share

    @property
    def steps(self) -> int:
        """Number of steps done in the episode."""
        return self._steps

    @property
    def episode_steps(self) -> int:
        """Number of steps of the whole run period."""
        return self.layout.episode_steps

    @property
    def morphology(self) -> Morphology:
        """The building as a graph."""
        morphology: Morphology = self.metadata["morphology"]
        return morphology

    @property
    def description(self) -> dict[str, Any]:
        """Description of the building, as ``b2b show --json`` prints it."""
        return json.loads(self.layout.spaces.description_json())

    def set_building(self, building: Building | str) -> None:
        """Changes the building of future episodes, and with it the spaces of this environment.

        A name is found with the control of the present building, at its own place.
        """
        self._open_core()
        if not isinstance(building, Building):
            building = find_building(building, control=self.building.control)
        before, self.building = self.building, building
        try:
            setting = self._setting_of(self.task)
            self._set_setting(setting)
        except BaseException:
            self.building = before
            raise
        self._base_setting = setting
        selection = dict.fromkeys(inspect.signature(select_building).parameters)
        self._arguments |= {**selection, "building": building, "control": building.control}
        self._started = False
        self._read_spaces()

    @contextmanager
    def finishing_runs(self) -> Iterator[None]:
        """Lets the engine finish its run after an episode that begins inside, so that :meth:`record` has its report."""
        self._finish_run = True
        try:
            yield
        finally:
            self._finish_run = False

    def record(self) -> _core.Record:
        """Returns the record of the episode, everything but its steps, for :meth:`Trajectory.write`."""
        return self._open_core().record()

    def snapshot(self) -> Snapshot:
        """Takes a snapshot of the episode, in milliseconds; :meth:`restore` returns to it any number of times."""
        core = self._open_core()
        if isinstance(core, _core.LocalEnv):
            raise ProcessError("snapshots are not available with in_process=True")
        if not self._started:
            raise EpisodeError("no episode is in progress; call reset first")
        position = Position(
            self.building,
            self.layout,
            self.setting,
            self.observation,
            self._steps,
            self._penalties,
            self._truncated,
            copy(self._power),
        )
        return Snapshot(self, core.snapshot(), position, core.release)

    def restore(self, snapshot: Snapshot) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Returns to a snapshot of this environment; returns its observation and info."""
        core = self._open_core()
        if isinstance(core, _core.LocalEnv) or not snapshot.belongs_to(self):
            raise EpisodeError("the snapshot belongs to another environment")
        if snapshot.position.building is not self.building:
            taken, now = snapshot.position.building.name, self.building.name
            raise EpisodeError(f"the snapshot is of {taken}, but the building of the environment is now {now}")
        core.restore(snapshot.number)
        position = snapshot.position
        self.layout, self.setting, self.observation = position.layout, position.setting, position.observation
        self._steps, self._penalties, self._truncated = position.steps, position.penalties, position.truncated
        self._power = copy(position.power)
        return self.observation.astype(np.float32), {"building": self.building.name}

    def branch(self, count: int) -> list[BuildingEnv]:
        """Returns ``count`` environments that continue independently from the current point of the episode, each in its
        own process; takes milliseconds. Close each of them."""
        core = self._open_core()
        if isinstance(core, _core.LocalEnv):
            raise ProcessError("branches are not available with in_process=True")
        if not self._started:
            raise EpisodeError("no episode is in progress; call reset first")
        if count < 1:
            raise SettingError(f"the number of branches is {count}; expected 1 or more")
        return [self._copy_with(each) for each in core.branch(count)]

    def _copy_with(self, core: _core.Env) -> BuildingEnv:
        """Returns a copy of this environment that has another core."""
        env = object.__new__(type(self))
        env.__dict__.update(self.__dict__)
        env._arguments = dict(self._arguments)
        env._core, env._renderer, env._exact, env.np_random = core, None, None, deepcopy(self.np_random)
        env._power = copy(self._power)
        close_at_exit(env)
        return env

    def render(self) -> NDArray[np.uint8] | None:
        """Draws the floor plan: returns an array (height, width, 3) of u8, or shows it in a window."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() needs a render_mode; make the environment with render_mode='rgb_array'")
            return None
        if self._renderer is None:
            self._renderer = Renderer()
        applied = self.applied_action() if self.steps else None
        scene = Scene(self.building, self.layout, self.setting, self.observation, applied, self.steps, self._power)
        return self._renderer.draw(scene, show=self.render_mode == "human")

    def close(self) -> None:
        """Ends the environment's processes."""
        core, self._core = getattr(self, "_core", None), None
        if core is not None and os.getpid() == self._process:
            if self._thread is None or self._thread == threading.get_ident():
                core.close()
        renderer, self._renderer = getattr(self, "_renderer", None), None
        if renderer is not None:
            renderer.close()

    def __del__(self) -> None:
        try:
            self.close()
        except Exception:  # modules may be gone while the interpreter exits
            pass

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the arguments that it was made with; the copy has its own processes and is not reset."""
        return _remake, (self._arguments, self.spec)

    def __str__(self) -> str:
        return f"<{type(self).__name__} {self.building.name}>"


def _remake(arguments: dict[str, Any], spec: Any) -> BuildingEnv:
    env = BuildingEnv(**arguments)
    env.spec = spec
    return env


def unwrap(env: gymnasium.Env[Any, Any]) -> BuildingEnv:
    """Returns the :class:`BuildingEnv` inside wrappers; raises if there is none."""
    core = env.unwrapped
    if not isinstance(core, BuildingEnv):
        raise SettingError(f"expected a building2building environment; got {core!r}")
    return core
