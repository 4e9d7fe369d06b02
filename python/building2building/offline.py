"""Episodes of controllers as a Minari dataset."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from .buildings import Building
from .errors import SettingError, need


def collect(
    controller: Callable[[Any], Any],
    buildings: Sequence[str | Building],
    dataset_id: str,
    *,
    episodes: int = 1,
    steps: int | None = None,
    seed: int = 0,
    author: str = "",
    description: str = "",
    **arguments,
):
    """Runs a controller on buildings of one type and writes what happened as a Minari dataset, with the spec of the
    environment: ``minari.load_dataset(dataset_id).recover_environment()`` makes it again.

    ``controller`` is a class or function that makes one for an environment (``ReactiveController``). Each building runs
    ``episodes`` episodes, of ``steps`` steps at most; ``arguments`` go to :func:`make_env`. Needs
    ``minari[hdf5,create]``.
    """
    minari = need("minari", "'minari[hdf5,create]'")
    import gymnasium

    from .buildings import find_building

    found = [each if isinstance(each, Building) else find_building(each) for each in buildings]
    types = {each.building_type for each in found}
    if len(types) != 1 or None in types:
        raise SettingError("a dataset is of buildings of one type: collect one for each")
    several = len(found) > 1
    if several:
        arguments.setdefault("rescale_action", True)
    kind, *named = found[0]._recipe
    if kind == "found":
        # By its names, which the spec in the dataset can hold.
        building_id, place, weather = named
        named = {"building_id": building_id, "place": place, "weather": None if weather is None else str(weather)}
    else:
        named = {"building": found[0]}
    env = gymnasium.make(f"b2b/{types.pop()}-v0", **named, **{"rescale_action": False, **arguments})
    collector = minari.DataCollector(env)
    try:
        for number, building in enumerate(found):
            if building is not env.unwrapped.building:
                env.unwrapped.set_building(building)
            acts = controller(env)
            for episode in range(episodes):
                if hasattr(acts, "reset"):
                    acts.reset()
                observation, _ = collector.reset(seed=seed + number * episodes + episode)
                done, count = False, 0
                while not done and (steps is None or count < steps):
                    action = acts(observation)
                    observation, _, terminated, truncated, _ = collector.step(
                        env.action_space.dtype.type(action).clip(env.action_space.low, env.action_space.high)
                    )
                    done, count = terminated or truncated, count + 1
        return collector.create_dataset(
            dataset_id=dataset_id,
            author=author or "building2building",
            description=description or f"{getattr(controller, '__name__', 'controller')} on {len(found)} buildings",
            algorithm_name=getattr(controller, "__name__", "controller"),
        )
    finally:
        collector.close()
