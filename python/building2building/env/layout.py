"""Slots of an environment's observation and action vectors, and their Gymnasium spaces."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from .. import _core
from ..errors import SettingError

Array = NDArray[Any]


class Layout:
    """Slots, bounds and zones of an environment, read once from the core's spaces."""

    def __init__(self, spaces: _core.Spaces):
        #: The core's spaces.
        self.spaces = spaces
        #: Slots of the observation.
        self.observation = spaces.observation
        #: Slots of the action.
        self.action = spaces.action
        #: All zones.
        self.zones = spaces.zones
        #: Bounds of the observation, f64.
        self.observation_low, self.observation_high = spaces.observation_low, spaces.observation_high
        #: Bounds of the action, f64, physical units.
        self.action_low, self.action_high = spaces.action_low, spaces.action_high
        controlled = [zone for zone in self.zones if zone.controlled]
        #: Names of the controlled zones.
        self.controlled_zones = [zone.name for zone in controlled]
        #: Observation slots of the controlled zones' temperatures.
        self.temperatures = np.array([zone.temperature_slot for zone in controlled], dtype=int)
        #: Target of every controlled zone, °C; ``None`` if targets change over time.
        self.constant_target = spaces.constant_target
        moving = self.constant_target is None
        #: Observation slots of the controlled zones' targets, or of their heating setpoints; ``None`` if targets are
        #: constant.
        self.targets = np.array([zone.target_slot for zone in controlled], dtype=int) if moving else None
        slots = [(zone.target_slot, zone.cooling_setpoint_slot) for zone in controlled]
        has_bands = any(low is not None and self.observation[low].quantity == "heating_setpoint" for low, _ in slots)
        #: Observation slots of the controlled zones' cooling setpoints, or of their heating setpoints where nothing
        #: cools; ``None`` in tasks without bands.
        self.cooling_setpoints = (
            np.array([low if high is None else high for low, high in slots], dtype=int) if has_bands else None
        )
        #: Observation slots of the controlled zones' occupancies; ``None`` if targets are constant.
        self.occupancies = np.array([zone.occupancy_slot for zone in controlled], dtype=int) if moving else None
        #: Zone time steps per hour.
        self.steps_per_hour = spaces.steps_per_hour
        #: Steps of the whole run period.
        self.episode_steps = spaces.episode_steps
        #: Observation slots of the HVAC energy of the step.
        self.electricity, self.gas = spaces.electricity_slot, spaces.gas_slot
        #: Observation slot of the outdoor air temperature; humidity follows it.
        self.outdoor_temperature = spaces.outdoor_temperature_slot

    def targets_in(self, observation: Array) -> Array:
        """Returns the target of every controlled zone for the step after an observation or a batch of them, °C.

        In a task with bands, the middle of the band.
        """
        if self.targets is None:
            return np.full((*observation.shape[:-1], len(self.controlled_zones)), self.constant_target)
        if self.cooling_setpoints is None:
            return observation[..., self.targets]
        return 0.5 * (observation[..., self.targets] + observation[..., self.cooling_setpoints])

    def bands_in(self, observation: Array) -> tuple[Array, Array] | None:
        """Returns the heating and the cooling setpoint of every controlled zone for the step after an observation, °C.

        The cooling setpoint is infinite where nothing cools. ``None`` in tasks without bands.
        """
        if self.cooling_setpoints is None or self.targets is None:
            return None
        low, high = observation[..., self.targets], observation[..., self.cooling_setpoints]
        return low, np.where(self.cooling_setpoints == self.targets, np.inf, high)

    def deviations_in(self, observation: Array, temperatures: Array) -> Array:
        """Returns the deviation of the zones' temperatures after the step, K: from the target, or from the band."""
        bands = self.bands_in(observation)
        if bands is None:
            return temperatures - self.targets_in(observation)
        return np.minimum(temperatures - bands[0], 0.0) + np.maximum(temperatures - bands[1], 0.0)

    def metadata(self) -> dict[str, Any]:
        """Returns names and units for the environment's ``metadata``."""
        return {
            "building": self.spaces.name,
            "observation_names": [slot.name for slot in self.observation],
            "observation_units": [slot.unit for slot in self.observation],
            "action_names": [actuator.name for actuator in self.action],
            "action_units": [actuator.unit for actuator in self.action],
            "zones": [zone.name for zone in self.zones],
            "controlled_zones": self.controlled_zones,
            "conditioned_floor_area": self.spaces.conditioned_floor_area,
            "energy_scale": self.spaces.energy_scale,
        }

    def observation_bounds(self) -> tuple[Array, Array]:
        """Returns the bounds of the observation as f32."""
        return self.observation_low.astype(np.float32), self.observation_high.astype(np.float32)

    def action_bounds(self) -> tuple[Array, Array]:
        """Returns the bounds of the action as f32, rounded inward so that they are never clamped."""
        return rounded_inward(self.action_low, self.action_high)

    def rescaled(self, action: Array) -> Array:
        """Converts an action in physical units to [-1, 1]."""
        span = self.action_high - self.action_low
        return 2 * (action - self.action_low) / np.where(span > 0, span, 1) - 1

    def observation_space(self) -> Box[np.float32]:
        """Returns the observation space, f32."""
        low, high = self.observation_bounds()
        return Box(low, high, dtype=np.float32)

    def action_space(self, rescale: bool) -> Box[np.float32]:
        """Returns the action space, f32: physical units, or [-1, 1] with ``rescale``."""
        if rescale:
            return Box(-1.0, 1.0, (len(self.action_low),), dtype=np.float32)
        low, high = self.action_bounds()
        return Box(low, high, dtype=np.float32)


def rounded_inward(low: Array, high: Array) -> tuple[Array, Array]:
    """Returns bounds as f32, rounded inward."""
    single = low.astype(np.float32)
    low32 = np.where(single < low, np.nextafter(single, np.float32(np.inf)), single)
    single = high.astype(np.float32)
    high32 = np.where(single > high, np.nextafter(single, np.float32(-np.inf)), single)
    return low32, np.maximum(low32, high32)


def index_of(names: list[str], what: str, name: str) -> int:
    """Returns the index of a slot or an actuator by its name."""
    if name not in names:
        raise SettingError(f"unknown {what} `{name}`; expected one of {', '.join(names)}")
    return names.index(name)
