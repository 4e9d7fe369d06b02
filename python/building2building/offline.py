"""Minari datasets."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np

from .buildings import Building, Found, PathLike, as_building
from .env import unwrap
from .errors import SettingError, need
from .rollouts import BuiltInController, PhysicalController


def collect(
    controller: Callable[[Any], Any],
    buildings: Sequence[str | Building],
    dataset_id: str,
    *,
    place: str | None = None,
    weather: PathLike | None = None,
    control: str = "actuators",
    episodes: int = 1,
    steps: int | None = None,
    seed: int = 0,
    author: str = "",
    description: str = "",
    **arguments: Any,
) -> Any:
    """Runs a controller on buildings of one type and writes the episodes as a Minari dataset.

    The dataset contains the environment's spec: ``minari.load_dataset(dataset_id).recover_environment()``
    recreates it, unless the first building was generated. Actions are recorded as applied.

    ``controller`` is a class or function that makes a controller for an environment, such as ``ReactiveController``.
    Buildings that are given by their names are found as by :func:`find_building`. Every building runs ``episodes``
    episodes of at most ``steps`` steps. ``arguments`` go to :func:`make_env`; without ``task``, it is ``constant``, as
    for ``b2b collect``.
    Needs ``minari[hdf5,create]``.
    """
    minari = need("minari", "'minari[hdf5,create]'")
    _check_id(minari, dataset_id)
    found = [as_building(each, place, weather, control) for each in buildings]
    types = {each.building_type for each in found}
    if imported := [each.name for each in found if each.building_type is None]:
        raise SettingError(f"{imported[0]} is an imported model, for which a dataset has no environment")
    if len(types) != 1:
        raise SettingError("the buildings of a Minari dataset must have one type; collect one dataset per type")
    arguments.setdefault("rescale_action", len(found) > 1)
    env = gymnasium.make(f"b2b/{types.pop()}-v0", **_selection(found[0]), **arguments)
    core, space, width = unwrap(env), env.action_space, env.observation_space.shape
    if not isinstance(space, gymnasium.spaces.Box):
        raise SettingError(f"expected actions in a Box; got {space}")
    low, high = space.low, space.high
    name = getattr(controller, "__name__", "controller")
    built_in = controller if isinstance(controller, type) and issubclass(controller, BuiltInController) else None
    policy: Any

    class Applied(minari.StepDataCallback):  # type: ignore[name-defined]
        def __call__(self, env: Any, **step: Any) -> Any:
            data = super().__call__(env, **step)
            if step.get("action") is not None and space == core.action_space:
                action = core.applied_action()
                action = core.layout.rescaled(action) if core.rescale_action else action
                data["action"] = action.astype(space.dtype).clip(low, high)
            return data

    collector = minari.DataCollector(env, step_data_callback=Applied)
    try:
        for number, building in enumerate(found):
            if number:
                core.set_building(building)
            if env.action_space != space:
                raise SettingError(
                    f"{building.name} has another action space than {found[0].name}; omit rescale_action"
                )
            if env.observation_space.shape != width:
                raise SettingError(
                    f"{building.name} has observations of the shape {env.observation_space.shape}, {found[0].name} of "
                    f"{width}; collect one dataset for each"
                )
            policy = None if built_in else controller(env)
            for episode in range(episodes):
                own_seed = seed + number * episodes + episode
                if built_in:
                    policy = built_in(env, own_seed)
                elif hasattr(policy, "reset"):
                    policy.reset()
                observation, _ = collector.reset(seed=own_seed)
                done, count = False, 0
                while not done and (steps is None or count < steps):
                    action = np.asarray(policy(observation), dtype=space.dtype).clip(low, high)
                    observation, reward, terminated, truncated, _ = collector.step(action)
                    if isinstance(policy, PhysicalController):
                        policy.reward(float(reward))
                    done, count = terminated or truncated, count + 1
        return collector.create_dataset(
            dataset_id=dataset_id,
            author=author or "building2building",
            description=description or f"{name} on {len(found)} buildings",
            algorithm_name=name,
        )
    finally:
        collector.close()


def _check_id(minari: Any, dataset_id: str) -> None:
    """Raises for a name that is not a dataset's or is taken, before any episode runs."""
    try:
        minari.dataset.minari_dataset.parse_dataset_id(dataset_id)
    except ValueError as error:
        raise SettingError(f"`{dataset_id}` is not the name of a dataset, such as b2b/office-v0: {error}") from None
    folder = minari.storage.get_dataset_path(dataset_id)
    if folder.exists():
        raise SettingError(f"the dataset {dataset_id} exists in {folder}; remove it, or choose another name or version")


def _selection(building: Building) -> dict[str, Any]:
    """Returns the arguments of :func:`make_env` that select a building, as plain values where possible, so that the
    spec in a dataset can hold them."""
    origin = building.origin
    if isinstance(origin, Found):
        control = {} if origin.control == "actuators" else {"control": origin.control}
        return {"building_id": origin.name, "place": origin.place, "weather": origin.weather, **control}
    return {"building": building}
