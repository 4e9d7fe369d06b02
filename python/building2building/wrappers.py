"""Wrappers where Gymnasium has none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from . import weather
from .buildings import Building, list_buildings
from .errors import ActionError, SettingError
from .info import Info
from .scaling import Scale

__all__ = [
    "AugmentObservationWithBuildingParams",
    "NormalizeObservation",
    "PadObservation",
    "PriceSignal",
    "ResampleBuildingOnResetWrapper",
    "SubsetAction",
    "SubsetObservation",
    "WeatherForecast",
    "wrap_env_for_rl",
]


class _Wrapper(gymnasium.Wrapper, gymnasium.utils.RecordConstructorArgs):
    """Keeps its arguments, so that an environment can be made again from its spec, and the names of what is seen."""

    def __init__(self, env: gymnasium.Env, **arguments):
        gymnasium.utils.RecordConstructorArgs.__init__(self, **arguments)
        gymnasium.Wrapper.__init__(self, env)

    def _rename(self, names: list[str], units: list[str]) -> None:
        self.metadata = {**self.env.metadata, "observation_names": names, "observation_units": units}

    def observation(self, observation: np.ndarray) -> np.ndarray:
        return observation

    def reset(self, **options):
        observation, info = self.env.reset(**options)
        return self.observation(observation), info

    def step(self, action):
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self.observation(observation), reward, terminated, truncated, info


def _extended(env, low, high, names, units) -> tuple[Box, list[str], list[str]]:
    """A box with more slots, with their names and units."""
    box = env.observation_space
    dtype = box.dtype
    low, high = np.concatenate([box.low, low]).astype(dtype), np.concatenate([box.high, high]).astype(dtype)
    return (
        Box(low, high, dtype=dtype),
        [*env.metadata["observation_names"], *names],
        [*env.metadata["observation_units"], *units],
    )


class PadObservation(_Wrapper):
    """Zeros behind the observation up to a width, so that buildings with different numbers of zones share a policy."""

    def __init__(self, env: gymnasium.Env, width: int):
        super().__init__(env, width=width)
        more = width - env.observation_space.shape[0]
        if more < 0:
            raise SettingError(f"the observation has {env.observation_space.shape[0]} slots, more than {width}")
        zeros = np.zeros(more)
        self.observation_space, *names = _extended(env, zeros, zeros, ["padding"] * more, ["1"] * more)
        self._rename(*names)
        self._more = more

    def observation(self, observation):
        return np.pad(observation, (0, self._more))


class NormalizeObservation(_Wrapper):
    """Each slot from -1 at its lower to 1 at its upper bound. ``bounds`` are narrower ones by a slot's name or its last
    words, such as ``{"air temperature": (10, 35)}``; what is beyond is clipped."""

    def __init__(self, env: gymnasium.Env, bounds: dict[str, tuple[float, float]] | None = None):
        super().__init__(env, bounds=bounds)
        names, box = env.metadata["observation_names"], env.observation_space
        self._scale = Scale(names, box.low, box.high, bounds)
        self.observation_space = self._scale.space
        self._rename(names, ["1"] * len(names))

    def observation(self, observation):
        return self._scale(observation)


class AugmentObservationWithBuildingParams(_Wrapper):
    """What the building is, behind the observation: the common attributes of its morphology (area, climate, envelope),
    constant over an episode. What is not known of a building is 0."""

    def __init__(self, env: gymnasium.Env, parameters: Sequence[str] | None = None):
        super().__init__(env, parameters=parameters)
        known = env.unwrapped.morphology.common_attributes
        self._names = list(known) if parameters is None else list(parameters)
        for name in self._names:
            if name not in known:
                raise SettingError(f"a building has no `{name}`: it has {', '.join(known)}")
        self._take()
        free = np.full(len(self._names), np.inf)
        self.observation_space, *names = _extended(
            env, -free, free, [f"building {name}" for name in self._names], ["1"] * len(self._names)
        )
        self._rename(*names)

    def _take(self):
        self._of = self.unwrapped.building
        known = self.unwrapped.morphology.common_attributes
        self._values = np.nan_to_num(np.array([known[name] or 0.0 for name in self._names], dtype=np.float32))

    def observation(self, observation):
        if self.unwrapped.building is not self._of:
            self._take()
        return np.concatenate([observation, self._values])


class ResampleBuildingOnResetWrapper(_Wrapper):
    """Another building every episode, drawn by the seed of ``reset`` from a list of ids or :class:`Building`, or from a
    split of the environment's type. Make the environment with ``rescale_action=True``, so that they have the same
    actions. Houses have one to three zones: ``width`` pads the observation. ``reset(options={"building": ...})`` asks
    for one."""

    def __init__(
        self,
        env: gymnasium.Env,
        buildings: Sequence[Building | str] | None = None,
        split: str = "train",
        width: int | None = None,
    ):
        super().__init__(env, buildings=buildings, split=split, width=width)
        box = env.observation_space
        self._width, self._pads = width or box.shape[0], width is not None
        if width is not None:
            if box.shape[0] > width:
                raise SettingError(f"the observation has {box.shape[0]} slots, more than {width}")
            low, high = min(float(box.low.min()), 0.0), max(float(box.high.max()), 0.0)
            self.observation_space = Box(low, high, (width,), dtype=box.dtype)
        if buildings is None:
            buildings = list_buildings(env.unwrapped.building.building_type, split)
        self._buildings = list(buildings)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None):
        core = self.unwrapped
        if seed is not None:
            gymnasium.Env.reset(core, seed=seed)
        options = dict(options or {})
        building = options.pop("building", None)
        if building is None:
            building = self._buildings[int(core.np_random.integers(len(self._buildings)))]
        actions = core.action_space
        core.set_building(building)
        if core.action_space != actions:
            raise SettingError(
                f"{core.building.name} has other actions than the building before it: rescale_action=True gives the "
                "buildings of a type the same"
            )
        self._check(core)
        observation, info = self.env.reset(seed=seed, options=options or None)
        return self.observation(observation), info

    def _check(self, core):
        slots = core.observation_space.shape[0]
        if slots > self._width or (slots != self._width and not self._pads):
            raise SettingError(
                f"{core.building.name} has {slots} observation slots, not {self._width}: give the width of the largest"
            )

    def observation(self, observation):
        return np.pad(observation, (0, self._width - len(observation)))


class WeatherForecast(_Wrapper):
    """Outdoor weather at the beginnings of the next hours, behind the observation: what the weather file has, a perfect
    forecast, in order of quantity and hour."""

    _BOUNDS = {
        "temperature": (-60, 60),
        "dew_point": (-60, 60),
        "humidity": (0, 110),
        "direct_radiation": (0, 1500),
        "diffuse_radiation": (0, 1500),
        "wind_speed": (0, 60),
    }

    def __init__(self, env: gymnasium.Env, hours: int = 6, quantities: Sequence[str] = ("temperature",)):
        super().__init__(env, hours=hours, quantities=quantities)
        self._hours, self._quantities = hours, tuple(quantities)
        self._read()
        bounds = np.repeat([self._BOUNDS[each] for each in self._quantities], hours, axis=0)
        names = [f"{each} in {hour + 1} h" for each in self._quantities for hour in range(hours)]
        units = [weather.COLUMNS[each][1] for each in self._quantities for _ in range(hours)]
        self.observation_space, *named = _extended(env, bounds[:, 0], bounds[:, 1], names, units)
        self._rename(*named)

    def _read(self):
        self._of = self.unwrapped.building
        self._year = weather.read(self._of.weather, self._quantities)

    def observation(self, observation):
        core = self.unwrapped
        if core.building is not self._of:
            self._read()
        now = (core.setting.first_day() - 1) * 24 + core.steps / core.timesteps_per_hour
        # The values of an EPW hour are for its end: row i for the end of hour i + 1.
        at = now + np.arange(1, self._hours + 1) - 1
        whole, share = np.floor(at).astype(int), (at % 1)[:, None]
        rows = len(self._year)
        ahead = self._year[whole % rows] * (1 - share) + self._year[(whole + 1) % rows] * share
        return np.concatenate([observation, ahead.T.ravel().astype(observation.dtype)])


class PriceSignal(_Wrapper):
    """A price, or emissions, by the hour: now and in the next hours behind the observation, and ``weight`` times it
    times the electricity of the step (kWh/m²) off the reward.

    ``series`` has 24 values for the hours of a day or 8760 for those of a year, such as :meth:`time_of_use`.
    """

    def __init__(
        self,
        env: gymnasium.Env,
        series: Sequence[float] | None = None,
        *,
        ahead: int = 3,
        weight: float = 0.0,
        name: str = "electricity price",
        unit: str = "1/kWh",
    ):
        super().__init__(env, series=series, ahead=ahead, weight=weight, name=name, unit=unit)
        self._series = np.asarray(self.time_of_use() if series is None else series, dtype=np.float64)
        if self._series.shape not in ((24,), (8760,)) or not np.isfinite(self._series).all():
            raise SettingError(f"a series has 24 or 8760 finite values, and this one is of shape {self._series.shape}")
        self._ahead, self._weight, self._name = ahead, weight, name
        count = ahead + 1
        names = [f"{name} now", *(f"{name} in {hour + 1} h" for hour in range(ahead))]
        low, high = np.full(count, self._series.min()), np.full(count, self._series.max())
        self.observation_space, *named = _extended(env, np.minimum(low, 0), high, names, [unit] * count)
        self._rename(*named)

    @staticmethod
    def time_of_use() -> np.ndarray:
        """An example: 0.08 at night, 0.12 by day, 0.25 from 16 to 21, a kWh."""
        hours = np.full(24, 0.12)
        hours[:7], hours[22:], hours[16:21] = 0.08, 0.08, 0.25
        return hours

    def _now(self) -> float:
        core = self.unwrapped
        return (core.setting.first_day() - 1) * 24 + core.steps / core.timesteps_per_hour

    def observation(self, observation):
        hours = (int(self._now() + 1e-9) + np.arange(self._ahead + 1)) % len(self._series)
        return np.concatenate([observation, self._series[hours].astype(observation.dtype)])

    def step(self, action):
        price = self._series[int(self._now() + 1e-9) % len(self._series)]
        observation, reward, terminated, truncated, info = self.env.step(action)
        if self._weight:
            core = self.unwrapped
            electricity = float(core.observation[core.layout.electricity]) / 1000
            cost = self._weight * price * electricity
            info = _with_term(info, self._name, -cost)
            reward = reward - cost
        return self.observation(observation), reward, terminated, truncated, info


def _with_term(info: dict, name: str, value: float) -> dict:
    def fill():
        every = dict(info)
        every["reward_terms"] = {**every["reward_terms"], name: value}
        return every

    return Info(fill)


class SubsetObservation(_Wrapper):
    """These slots of the observation alone, by name and in this order."""

    def __init__(self, env: gymnasium.Env, names: Sequence[str]):
        super().__init__(env, names=names)
        known = env.metadata["observation_names"]
        self._slots = np.array([_place(known, name) for name in names], dtype=int)
        box = env.observation_space
        self.observation_space = Box(box.low[self._slots], box.high[self._slots], dtype=box.dtype)
        self._rename(list(names), [env.metadata["observation_units"][slot] for slot in self._slots])

    def observation(self, observation):
        return observation[self._slots]


class SubsetAction(_Wrapper):
    """These actuators alone, by name and in this order; ``rest`` says for an observation what all actuators do, and
    drives those that are left: :class:`ReactiveController` by default."""

    def __init__(self, env: gymnasium.Env, names: Sequence[str], rest: Callable[[np.ndarray], Any] | None = None):
        super().__init__(env, names=names, rest=rest)
        from .rollouts import ReactiveController

        known = env.metadata["action_names"]
        self._actuators = np.array([_place(known, name) for name in names], dtype=int)
        self._rest = ReactiveController(env) if rest is None else rest
        box = env.action_space
        self.action_space = Box(box.low[self._actuators], box.high[self._actuators], dtype=box.dtype)
        units = env.metadata["action_units"]
        self.metadata = {
            **env.metadata,
            "action_names": list(names),
            "action_units": [units[each] for each in self._actuators],
        }

    def reset(self, **options):
        if hasattr(self._rest, "reset"):
            self._rest.reset()
        return self.env.reset(**options)

    def step(self, action):
        action = action_of_shape(action, self._actuators.shape)
        every = np.array(self._rest(self.unwrapped.observation), dtype=np.float64)
        every[self._actuators] = action
        return self.env.step(every)


def action_of_shape(action, shape: tuple[int, ...]) -> np.ndarray:
    """An action as an array, which has to be of this shape."""
    action = np.asarray(action)
    if action.shape != shape:
        raise ActionError(f"the action is of shape {action.shape}, and must be of {shape}")
    return action


def _place(known: list[str], name: str) -> int:
    if name not in known:
        raise SettingError(f"there is no `{name}`: there are {', '.join(known)}")
    return known.index(name)


def wrap_env_for_rl(env: gymnasium.Env, *, width: int | None = None, parameters: bool = False) -> gymnasium.Env:
    """What learners want: observations from -1 to 1, actions too if the environment was made with
    ``rescale_action=True`` (they are rescaled here if not), padded to ``width``, with the building's parameters if
    asked for."""
    if not env.unwrapped.rescale_action:
        env = gymnasium.wrappers.RescaleAction(env, np.float32(-1.0), np.float32(1.0))
    env = NormalizeObservation(env)
    if parameters:
        env = AugmentObservationWithBuildingParams(env)
    return env if width is None else PadObservation(env, width)
