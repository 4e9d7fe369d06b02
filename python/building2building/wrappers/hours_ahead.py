"""Wrappers that append what is known about the hours ahead: weather forecasts and prices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..env import BuildingEnv
from ..env.info import Info
from ..errors import SettingError
from .observation_wrapper import Env, ObservationWrapper, Stepped

Array = NDArray[Any]

#: Days of a year before 29 February.
_BEFORE_LEAP_DAY = 59


class WeatherForecast(ObservationWrapper):
    """Appends the outdoor weather 1, 2, ... hours from now, ordered by quantity, then hour, from the weather file.

    The forecast is perfect, except for quantities in ``errors``, such as ``{"temperature": 0.5}``: their errors are a
    random walk over the hours ahead, whose steps have this standard deviation; a new walk is drawn every hour. The same
    seed of ``reset`` gives the same errors.
    """

    #: Unit and bounds of the quantities.
    _QUANTITIES = {
        "temperature": ("°C", -60, 60),
        "dew_point": ("°C", -60, 60),
        "humidity": ("%", 0, 110),
        "direct_radiation": ("Wh/m²", 0, 1500),
        "diffuse_radiation": ("Wh/m²", 0, 1500),
        "wind_speed": ("m/s", 0, 60),
    }

    def __init__(
        self,
        env: Env,
        hours: int = 6,
        quantities: Sequence[str] = ("temperature",),
        *,
        errors: Mapping[str, float] | None = None,
    ):
        super().__init__(env, hours=hours, quantities=quantities, errors=errors)
        self._hours, self._quantities = hours, tuple(quantities)
        self._errors = self._checked(errors or {})
        self._seed = 0
        self._update()

    def _read(self) -> None:
        self._read_weather()
        hours = range(self._hours)
        bounds = np.repeat([self._QUANTITIES[each][1:] for each in self._quantities], self._hours, axis=0)
        self._low, self._high = bounds.T
        names = [f"{each} in {hour + 1} h" for each in self._quantities for hour in hours]
        units = [self._QUANTITIES[each][0] for each in self._quantities for _ in hours]
        self._extend(self._low, self._high, names, units)

    def _read_weather(self) -> None:
        self._setting = self._core.setting
        self._year = np.stack([self._setting.hourly_weather(each) for each in self._quantities], axis=1)

    def _checked(self, errors: Mapping[str, float]) -> Array:
        for quantity, error in errors.items():
            if quantity not in self._quantities:
                raise SettingError(f"errors has `{quantity}`; expected one of {', '.join(self._quantities)}")
            if not 0 <= error < np.inf:
                raise SettingError(f"the error of {quantity} is {error}; expected a number from 0 up")
        return np.array([errors.get(quantity, 0.0) for quantity in self._quantities])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self._update()
        if self._errors.any():
            self._seed = int(self._core.np_random.integers(2**63))
        return self.observation(observation), info

    def _drawn_errors(self, hour: int) -> Array:
        """Returns the errors of the forecast that was issued at an hour of the year, ``[hours, quantities]``."""
        random = np.random.default_rng([self._seed, hour])
        return (random.standard_normal((self._hours, len(self._quantities))) * self._errors).cumsum(axis=0)

    def observation(self, observation: Array) -> Array:
        if self._core.setting is not self._setting:
            self._read_weather()
        # EPW values describe the hour that ends: row i belongs to the end of hour i + 1.
        now = _hour_of_year(self._core)
        positions = now + np.arange(1, self._hours + 1) - 1
        whole, fraction = np.floor(positions).astype(int), (positions % 1)[:, None]
        rows = len(self._year)
        forecast = self._year[whole % rows] * (1 - fraction) + self._year[(whole + 1) % rows] * fraction
        if self._errors.any():
            forecast += self._drawn_errors(_full_hour(self._core))
        appended = forecast.T.ravel().clip(self._low, self._high)
        return np.concatenate([observation, appended.astype(observation.dtype)])


class PriceSignal(ObservationWrapper):
    """Appends an hourly price or emission factor, now and for the next ``ahead`` hours, and subtracts ``weight`` times
    the price times the step's electricity (kWh/m²) from the reward.

    ``series`` has 24 values for the hours of the day, or 8760 for the hours of the year, where 29 February is like the
    day before; see :meth:`time_of_use`.
    """

    def __init__(
        self,
        env: Env,
        series: Sequence[float] | Array | None = None,
        *,
        ahead: int = 3,
        weight: float = 0.0,
        name: str = "electricity price",
        unit: str = "1/kWh",
    ):
        super().__init__(env, series=series, ahead=ahead, weight=weight, name=name, unit=unit)
        self._series = np.asarray(self.time_of_use() if series is None else series, dtype=np.float64)
        if self._series.shape not in ((24,), (8760,)) or not np.isfinite(self._series).all():
            raise SettingError(f"series has shape {self._series.shape}; expected 24 or 8760 finite values")
        self._ahead, self._weight, self._name, self._unit = ahead, weight, name, unit
        self._update()

    def _read(self) -> None:
        count = self._ahead + 1
        names = [f"{self._name} now", *(f"{self._name} in {hour} h" for hour in range(1, count))]
        low, high = np.full(count, self._series.min()), np.full(count, self._series.max())
        self._extend(np.minimum(low, 0), high, names, [self._unit] * count)

    @staticmethod
    def time_of_use() -> Array:
        """Returns an example tariff per kWh: 0.25 from 16 to 21 h, 0.08 from 22 to 7 h, else 0.12."""
        hours = np.full(24, 0.12)
        hours[:7], hours[22:], hours[16:21] = 0.08, 0.08, 0.25
        return hours

    def observation(self, observation: Array) -> Array:
        return np.concatenate([observation, self._prices().astype(observation.dtype)])

    def _prices(self) -> Array:
        """Returns the prices of this hour and of the hours ahead."""
        days = self._core.setting.days_of_year
        hours = (_full_hour(self._core) + np.arange(self._ahead + 1)) % (24 * days)
        hours[hours >= 24 * _BEFORE_LEAP_DAY] -= 24 * (days - 365)
        return self._series[hours % len(self._series)]

    def step(self, action: Any) -> Stepped:
        price, steps = self._prices()[0], self._core.steps
        observation, reward, terminated, truncated, info = self.env.step(action)
        if self._weight:
            core = self._core
            if core.steps != steps + 1:
                raise SettingError(
                    f"a weight prices single steps, and the wrapped environment made {core.steps - steps}; take a "
                    "tariff, such as task='operate+tou'"
                )
            electricity = float(core.observation[core.layout.electricity]) / 1000
            cost = self._weight * price * electricity
            info = _with_term(info, self._name, -cost)
            reward = reward - cost
        return self.observation(observation), reward, terminated, truncated, info


def _hour_of_year(core: BuildingEnv) -> float:
    return core.setting.first_hour + core.steps / core.timesteps_per_hour


def _full_hour(core: BuildingEnv) -> int:
    return int(_hour_of_year(core) + 1e-9)


def _with_term(info: dict[str, Any], name: str, value: float) -> dict[str, Any]:
    def compute() -> dict[str, Any]:
        every = dict(info)
        every["reward_terms"] = {**every["reward_terms"], name: value}
        return every

    changed = Info(compute)
    changed["step"] = info["step"]
    return changed
