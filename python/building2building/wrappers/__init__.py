"""Wrappers for building environments, in addition to Gymnasium's."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray

from ..buildings import Building, list_buildings
from ..buildings.signatures import renamed
from ..env import unwrap
from ..env.layers import is_own
from ..env.layout import index_of
from ..errors import ActionError, SettingError
from ..rollouts import BuiltInController, ReactiveController
from ..scaling import Scale
from .graph import GraphObservation
from .hours_ahead import PriceSignal, WeatherForecast
from .observation_wrapper import Env, ObservationWrapper, Stepped, box_of
from .previous_step import PreviousStepObservation, PreviousStepVectorObservation

__all__ = [
    "AugmentObservationWithBuildingParams",
    "GraphObservation",
    "NormalizeObservation",
    "PadObservation",
    "PreviousStepObservation",
    "PreviousStepVectorObservation",
    "PriceSignal",
    "ResampleBuildingOnResetWrapper",
    "RoleObservation",
    "SubsetAction",
    "SubsetObservation",
    "WeatherForecast",
    "wrap_env_for_rl",
]

Array = NDArray[Any]


class PadObservation(ObservationWrapper):
    """Pads the observation with zeros, so that buildings with different numbers of zones can share a policy.

    ``width`` appends zeros up to that many slots. ``zones`` aligns the zones instead: the temperature of zone i, in
    model order, is slot i; weather, calendar and energy follow after ``zones`` such slots, and then, where targets
    vary, occupancy and target of each zone at its own place. Either way, zones stay in model order: for houses,
    :class:`RoleObservation` has a slot for each role.

    Buildings of one width have one observation space: with ``width``, all slots have the widest bounds of any of them;
    with ``zones``, slots of the same quantity have the same bounds, which include 0.
    """

    @renamed(
        positions=2,
        target_size="zones=target_size - 7 aligns the zones, as it did; width=target_size appends zeros",
    )
    def __init__(self, env: Env, *, width: int | None = None, zones: int | None = None):
        super().__init__(env, width=width, zones=zones)
        if (width is None) == (zones is None):
            raise SettingError("pass either width or zones")
        self._width, self._zones = width, zones
        self._update()

    def _read(self) -> None:
        self._read_places()
        padded = self.env if self._zones is None else self._core
        box, metadata = box_of(padded), padded.metadata
        low, high = np.zeros(self._slots, box.dtype), np.zeros(self._slots, box.dtype)
        low[self._places], high[self._places] = box.low, box.high
        for alike in self._alike:
            low[alike], high[alike] = low[alike].min(initial=0), high[alike].max(initial=0)
        self.observation_space = Box(low, high, dtype=box.dtype)
        names, units = ["padding"] * self._slots, ["1"] * self._slots
        for place, name, unit in zip(self._places, metadata["observation_names"], metadata["observation_units"]):
            names[place], units[place] = name, unit
        self._rename(names, units)

    def _read_places(self) -> None:
        """Reads the positions of the slots of the building's observation."""
        if self._width is not None:
            slots = box_of(self.env).shape[0]
            if slots > self._width:
                raise SettingError(f"width is {self._width}, but the observation has {slots} slots")
            self._places, self._slots = np.arange(slots), self._width
            # A slot may hold another quantity in another building.
            self._alike: list[slice] = [slice(None)]
            return
        room = self._zones or 0
        layout = self._core.layout
        if not is_own(self.env):
            raise SettingError("the observation was changed by another wrapper; apply PadObservation with zones first")
        if len(layout.zones) > room:
            raise SettingError(f"zones is {room}, but {layout.spaces.name} has {len(layout.zones)} zones")
        if layout.cooling_setpoints is not None:
            raise SettingError("zones has no slots for comfort bands; use width in tasks of operation")
        varying = 0 if layout.targets is None else 2 * sum(zone.controlled for zone in layout.zones)
        others = len(layout.observation) - len(layout.zones) - varying
        self._places = np.arange(len(layout.observation)) + room - len(layout.zones)
        for index, zone in enumerate(layout.zones):
            self._places[zone.temperature_slot] = index
            if zone.occupancy_slot is not None and zone.target_slot is not None:
                self._places[[zone.occupancy_slot, zone.target_slot]] = room + others + 2 * index + np.arange(2)
        self._slots = room + others + (2 * room if varying else 0)
        # Temperatures, occupancies, targets.
        self._alike = [slice(room), slice(room + others, None, 2), slice(room + others + 1, None, 2)]

    def observation(self, observation: Array) -> Array:
        padded = np.zeros(self._slots, observation.dtype)
        padded[self._places] = observation[: len(self._places)]
        return padded


class RoleObservation(ObservationWrapper):
    """Gives observations of houses a fixed width in which a slot means the same in every house and task.

    The slots are the air temperatures of living area, attic, crawlspace and garage (0 if the house does not have it),
    weather, calendar and energy, occupancy and target of the living area (constant in a task with constant targets),
    and the presence of the four zones, 0 or 1. Wrap the environment before any wrapper that changes its observation.
    """

    def __init__(self, env: Env):
        super().__init__(env)
        self._update()

    def _read(self) -> None:
        roles = self._core.layout.spaces.roles
        if roles is None:
            raise SettingError(
                f"{self._core.building.name} has no slots by role, which the generator's houses have in tasks without "
                "comfort bands; pass width to PadObservation where widths differ"
            )
        if not is_own(self.env):
            raise SettingError("the observation was changed by another wrapper; apply RoleObservation first")
        low = np.array([each.low for each in roles], np.float32)
        high = np.array([each.high for each in roles], np.float32)
        self.observation_space = Box(low, high, dtype=np.float32)
        self._rename([each.name for each in roles], [each.unit for each in roles])
        self._row = np.array([each.constant for each in roles], dtype=np.float32)
        self._places = np.array([place for place, each in enumerate(roles) if each.slot is not None])
        self._own = np.array([each.slot for each in roles if each.slot is not None])

    def observation(self, observation: Array) -> Array:
        row = self._row.copy()
        row[self._places] = observation[self._own]
        return row


class NormalizeObservation(ObservationWrapper):
    """Maps each slot's usual range to [-1, 1] and clips. ``bounds`` replaces the range of slots by their name or its
    last words, for example ``{"air temperature": (10, 35)}``; the outdoor air temperature has a range of its own, and
    slots whose bounds are narrower keep theirs."""

    @renamed(dtype="observations are f32")
    def __init__(self, env: Env, bounds: dict[str, tuple[float, float]] | None = None):
        super().__init__(env, bounds=bounds)
        self._bounds = bounds
        self._update()

    def _read(self) -> None:
        names, box = self.env.metadata["observation_names"], box_of(self.env)
        self._scale = Scale(names, box.low, box.high, self._bounds, self._core.layout.steps_per_hour)
        self.observation_space = self._scale.space
        self._rename(names, ["1"] * len(names))

    def observation(self, observation: Array) -> Array:
        return self._scale(observation)

    def denormalize(self, observation: ArrayLike) -> Array:
        """Converts a normalized observation back to its units, except that values out of bounds stay clipped."""
        return self._scale.denormalize(observation)


class AugmentObservationWithBuildingParams(ObservationWrapper):
    """Appends the common attributes of the building's morphology (size, year, climate, envelope, numbers of systems and
    actuators), which are constant within an episode.

    They are scaled from the bounds that all buildings share (``Morphology.common_attribute_bounds``) to [-1, 1];
    without ``scaled``, they are in physical units. Unknown attributes are 0.
    """

    @renamed(
        building_params="pass the names of attributes as parameters",
        allow_defaults="attributes come from the morphology",
    )
    def __init__(self, env: Env, parameters: Sequence[str] | None = None, *, scaled: bool = True):
        super().__init__(env, parameters=parameters, scaled=scaled)
        if isinstance(parameters, Mapping):
            raise SettingError("parameters are names of attributes, whose values are the building's; got a dictionary")
        self._scaled = scaled
        known = self._core.morphology.common_attributes
        self._names = list(known) if parameters is None else list(parameters)
        for name in self._names:
            if name not in known:
                raise SettingError(f"unknown building attribute `{name}`; expected one of {', '.join(known)}")
        self._update()

    def _read(self) -> None:
        bound = np.full(len(self._names), 1.0 if self._scaled else np.inf)
        self._extend(-bound, bound, [f"building {name}" for name in self._names], ["1"] * len(self._names))
        morphology = self._core.morphology
        known = morphology.scaled_common_attributes if self._scaled else morphology.common_attributes
        self._values = np.nan_to_num(np.array([known[name] for name in self._names], dtype=np.float32))

    def observation(self, observation: Array) -> Array:
        return np.concatenate([observation, self._values])

    def denormalize(self, observation: ArrayLike) -> Array:
        """Returns an observation without the attributes, in its units if an inner wrapper normalizes it."""
        own = np.asarray(observation)[..., : -len(self._names) or None]
        if self.env.has_wrapper_attr("denormalize"):
            return np.asarray(self.env.get_wrapper_attr("denormalize")(own))
        return own


class ResampleBuildingOnResetWrapper(ObservationWrapper):
    """Draws a new building for every episode.

    Buildings are drawn by the seed of ``reset`` from a list of ids or :class:`Building`, or from a split of the
    environment's type, by default ``train``; ``reset(options={"building": ...})`` selects one. Ids are found by
    :meth:`BuildingEnv.set_building`: at their own places, with the environment's ``control``. Make the environment with
    ``rescale_action=True``, so that all buildings share one action space.

    Houses have two to four zones: ``width`` pads the observation. As a slot may then hold another quantity in every
    episode, slots are named ``slot 0``, ``slot 1``... and have the same bounds. To give slots a meaning, wrap a
    :class:`RoleObservation`, without ``width``.
    """

    appends_zeros = True

    @renamed(
        env_factory="pass an environment",
        available_indices="pass buildings, such as list_buildings('OfficeSmall')",
        wandb_prefix="log from the training loop",
        log_interval_steps="log from the training loop",
    )
    def __init__(
        self,
        env: Env,
        buildings: Sequence[Building | str] | None = None,
        split: str | None = None,
        width: int | None = None,
    ):
        if callable(env) and not isinstance(env, gymnasium.Env):
            raise TypeError(
                "ResampleBuildingOnResetWrapper() takes an environment and buildings, not a factory and indices as in "
                "the original implementation (see docs/coming_from.md)"
            )
        if buildings is not None and split is not None:
            raise SettingError(f"split {split!r} selects buildings, and buildings are given; omit one of them")
        super().__init__(env, buildings=buildings, split=split, width=width)
        box = box_of(env)
        self._width, self._pads = width or box.shape[0], width is not None
        if width is not None:
            if box.shape[0] > width:
                raise SettingError(f"width is {width}, but the observation has {box.shape[0]} slots")
            low, high = min(float(box.low.min()), 0.0), max(float(box.high.max()), 0.0)
            self.observation_space = Box(low, high, (width,), dtype=box.dtype)
        if buildings is None:
            building_type = self._core.building.building_type
            if building_type is None:
                raise SettingError("an imported building has no type to draw from; pass buildings")
            buildings = list_buildings(building_type, split or "train")
        self._buildings = list(buildings)
        self._update()

    def _read(self) -> None:
        if self._pads:
            self._rename([f"slot {number}" for number in range(self._width)], ["1"] * self._width)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        core = self._core
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
                f"{core.building.name} has another action space than the previous building; make the environment with "
                "rescale_action=True"
            )
        # Without the seed, which would restart the random numbers that drew the building.
        observation, info = self.env.reset(seed=None, options=options or None)
        self._update()
        self._check_width(len(observation))
        return self.observation(observation), info

    def _check_width(self, slots: int) -> None:
        if slots > self._width or (slots != self._width and not self._pads):
            raise SettingError(
                f"{self._core.building.name} has {slots} observation slots instead of {self._width}; pass the width of "
                "the largest building"
            )

    def observation(self, observation: Array) -> Array:
        return np.pad(observation, (0, self._width - len(observation)))


class SubsetObservation(ObservationWrapper):
    """Keeps the named slots of the observation, in the given order."""

    def __init__(self, env: Env, names: Sequence[str]):
        super().__init__(env, names=names)
        self._names = list(names)
        self._update()

    def _read(self) -> None:
        box, metadata = box_of(self.env), self.env.metadata
        known = metadata["observation_names"]
        self._slots = np.array([index_of(known, "observation slot", name) for name in self._names], dtype=int)
        self.observation_space = Box(box.low[self._slots], box.high[self._slots], dtype=box.dtype)
        self._rename(self._names, [metadata["observation_units"][slot] for slot in self._slots])

    def observation(self, observation: Array) -> Array:
        return observation[self._slots]


class SubsetAction(ObservationWrapper):
    """Restricts the action to the named actuators, in the given order. ``rest``, a controller of all actuators, sets
    the others, in the action space of the wrapped environment; :class:`ReactiveController` by default, which acts in
    the action space of :class:`BuildingEnv`: apply wrappers that change the action space, such as ``RescaleAction``,
    after this one. The building can change only without ``rest``."""

    def __init__(self, env: Env, names: Sequence[str], rest: Callable[[Array], ArrayLike] | None = None):
        super().__init__(env, names=names, rest=rest)
        self._names, self._given = list(names), rest
        self._update()

    def _read(self) -> None:
        core, metadata = self._core, self.env.metadata
        if self._given is not None and self._building is not None:
            before, now = self._building.name, core.building.name
            raise SettingError(f"`rest` was made for {before}, but the building is now {now}; omit rest")
        known = metadata["action_names"]
        self._actuators = np.array([index_of(known, "actuator", name) for name in self._names], dtype=int)
        self._rest = ReactiveController(core) if self._given is None else self._given
        box = self.env.action_space
        if not isinstance(box, Box):
            raise SettingError(f"expected actions in a Box; got {box}")
        if isinstance(self._rest, BuiltInController) and box != core.action_space:
            raise SettingError(
                f"the action space was changed by another wrapper, but {type(self._rest).__name__} acts in the "
                "building's; apply SubsetAction first"
            )
        low, high = box.low[self._actuators], box.high[self._actuators]
        self.action_space = Box(low, high, dtype=box.dtype)
        units = [metadata["action_units"][each] for each in self._actuators]
        self.metadata = metadata | {"action_names": self._names, "action_units": units}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        observation, info = super().reset(seed=seed, options=options)
        if hasattr(self._rest, "reset"):
            self._rest.reset()
        return observation, info

    def step(self, action: Any) -> Stepped:
        action = action_of_shape(action, self._actuators.shape)
        complete = np.array(self._rest(self._core.observation), dtype=np.float64)
        complete[self._actuators] = action
        return self.env.step(complete)


def action_of_shape(action: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Returns an action as an array; raises if it does not have this shape."""
    array = np.asarray(action)
    if array.shape != shape:
        raise ActionError(f"the action has shape {array.shape}; expected {shape}")
    return array


@renamed(
    normalize_obs="observations are always normalized, to [-1, 1] instead of [0, 1]",
    rescale_action="actions are always in [-1, 1]",
)
def wrap_env_for_rl(env: Env, *, width: int | None = None, parameters: bool = False) -> Env:
    """Wraps an environment for learning: observations and actions in [-1, 1], with ``parameters`` the building's
    scaled attributes appended, and padded to ``width``. In tasks without bands, houses have the slots of
    :class:`RoleObservation` unless ``width`` is given."""
    if not unwrap(env).rescale_action:
        env = gymnasium.wrappers.RescaleAction(env, np.float32(-1.0), np.float32(1.0))
    if width is None and unwrap(env).layout.spaces.roles is not None and is_own(env):
        env = RoleObservation(env)
    env = NormalizeObservation(env)
    if parameters:
        env = AugmentObservationWithBuildingParams(env)
    return env if width is None else PadObservation(env, width=width)
