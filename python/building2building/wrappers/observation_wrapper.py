"""The base of wrappers that change the observation, the action or both."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray

from ..buildings import Building
from ..env import BuildingEnv, unwrap
from ..errors import SettingError

Array = NDArray[Any]
Env = gymnasium.Env[Any, Any]
Stepped = tuple[Array, Any, bool, bool, dict[str, Any]]


class ObservationWrapper(gymnasium.Wrapper[Any, Any, Any, Any], gymnasium.utils.RecordConstructorArgs):
    """A wrapper that records its arguments for the environment's spec, and reads the building again when it changes."""

    #: Whether the wrapper only appends zeros to the observation.
    appends_zeros = False

    def __init__(self, env: Env, **arguments: Any):
        if not isinstance(env, gymnasium.Env):
            raise SettingError(f"{type(self).__name__} wraps an environment; got {env!r}")
        gymnasium.utils.RecordConstructorArgs.__init__(self, **arguments)
        gymnasium.Wrapper.__init__(self, env)
        self._core: BuildingEnv = unwrap(env)
        self._building: Building | None = None

    def _update(self) -> None:
        """Reads the building if it is another one than before. Wrappers call it at the end of their construction."""
        building = self._core.building
        if self._building is None or self._building.origin != building.origin:
            self._read()
            self._building = building

    def _read(self) -> None:
        """Reads what depends on the building: spaces, names and positions of slots."""

    def _rename(self, names: list[str], units: list[str]) -> None:
        self.metadata = self.env.metadata | {"observation_names": names, "observation_units": units}

    def _extend(self, low: ArrayLike, high: ArrayLike, names: list[str], units: list[str]) -> None:
        """Appends slots to the observation space."""
        box = box_of(self.env)
        bounds = [np.concatenate([old, new]).astype(box.dtype) for old, new in ((box.low, low), (box.high, high))]
        self.observation_space = Box(bounds[0], bounds[1], dtype=box.dtype)
        metadata = self.env.metadata
        self._rename([*metadata["observation_names"], *names], [*metadata["observation_units"], *units])

    def observation(self, observation: Array) -> Array:
        """Converts an observation of the wrapped environment."""
        return observation

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        observation, info = self.env.reset(seed=seed, options=options)
        self._update()
        return self.observation(observation), info

    def step(self, action: Any) -> Stepped:
        observation, reward, terminated, truncated, info = self.env.step(action)
        return self.observation(observation), reward, terminated, truncated, info


class VectorWrapper(gymnasium.vector.VectorWrapper):
    """A wrapper of a batch that also has the attributes of the batch, such as ``layout_of``."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "env":
            raise AttributeError(name)
        return getattr(self.env, name)


def box_of(env: Env) -> Box:
    box, names = env.observation_space, env.metadata["observation_names"]
    if not isinstance(box, Box) or box.shape != (len(names),):
        raise SettingError(
            f"expected observations in a Box with {len(names)} numbers; got {box}: wrap the environment before "
            "FrameStackObservation and others that change the shape"
        )
    return box
