"""The previous step as a part of the observation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from ..errors import SettingError
from .observation_wrapper import Env, ObservationWrapper, Stepped, VectorWrapper

if TYPE_CHECKING:
    from ..learning.acting import ActingVectorEnv
    from ..vector import BuildingVectorEnv

Array = NDArray[Any]


class _Scaling:
    """Scales the actions of a space to [-1, 1]."""

    def __init__(self, space: gymnasium.Space[Any]):
        if not isinstance(space, Box):
            raise SettingError(f"expected actions in a Box; got {space}")
        self._low = space.low.astype(np.float64)
        span = space.high - self._low
        self._span = np.where(span > 0, span, np.inf)
        ones = np.ones(len(span))
        #: Bounds of the slots of the previous step.
        self.bounds = np.array([*-ones, -np.inf, 0]), np.array([*ones, np.inf, 1])

    def __call__(self, actions: ArrayLike) -> Array:
        scaled = 2 * (np.asarray(actions, np.float64) - self._low) / self._span - 1
        return np.where(np.isfinite(self._span), np.clip(scaled, -1, 1), 0)


def _names(metadata: dict[str, Any]) -> list[str]:
    """Returns the names of the slots of the previous step."""
    return [*(f"previous {name}" for name in metadata["action_names"]), "previous reward", "first step"]


class PreviousStepObservation(ObservationWrapper):
    """Appends the previous step: its action in [-1, 1], its reward, and 1 in the first step of an episode.

    The first two are 0 in the first step. Policies with memory observe the same slots in benchmark problems whose
    episodes share a memory.
    """

    def __init__(self, env: Env):
        super().__init__(env)
        self._update()

    def _read(self) -> None:
        self._scaled = _Scaling(self.env.action_space)
        low, high = self._scaled.bounds
        self._previous = np.append(np.zeros(len(low) - 1), 1)
        self._extend(low, high, _names(self.env.metadata), ["1"] * len(low))

    def observation(self, observation: Array) -> Array:
        return np.concatenate([observation, self._previous.astype(observation.dtype)])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        self._previous[:] = 0
        self._previous[-1] = 1
        return super().reset(seed=seed, options=options)

    def step(self, action: ArrayLike) -> Stepped:
        observation, reward, terminated, truncated, info = self.env.step(action)
        self._previous[:-2] = self._scaled(action)
        self._previous[-2:] = reward, 0
        return self.observation(observation), reward, terminated, truncated, info


class PreviousStepVectorObservation(VectorWrapper):
    """:class:`PreviousStepObservation` for the environments of a batch. Slots of padded actions are 0."""

    env: BuildingVectorEnv | ActingVectorEnv

    def __init__(self, env: BuildingVectorEnv | ActingVectorEnv):
        super().__init__(env)
        self._scaled = _Scaling(env.single_action_space)
        low, high = self._scaled.bounds
        own = env.single_observation_space
        bounds = [np.concatenate([old, new]).astype(np.float32) for old, new in ((own.low, low), (own.high, high))]
        self.single_observation_space = Box(bounds[0], bounds[1], dtype=np.float32)
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)
        self._previous = np.zeros((env.num_envs, len(low)), np.float32)
        self._ended = np.zeros(env.num_envs, bool)
        if "observation_names" in env.metadata:
            names = [*env.metadata["observation_names"], *_names(env.metadata)]
            self.metadata = {**env.metadata, "observation_names": names}

    def reset(
        self, *, seed: int | list[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        observations, infos = self.env.reset(seed=seed, options=options)
        begun = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs)), bool)
        self._begin(begun)
        self._ended = self._ended & ~begun
        return self._seen(observations), infos

    def step(self, actions: ArrayLike) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        # Of the buildings that take the actions; the next episodes may have others.
        mask = self.env.action_mask()
        observations, rewards, terminated, truncated, infos = self.env.step(actions)
        self._previous[:, :-2] = np.where(mask, self._scaled(actions), 0)
        self._previous[:, -2], self._previous[:, -1] = rewards, 0
        ended = terminated | truncated
        mode = self.metadata["autoreset_mode"]
        if mode == AutoresetMode.SAME_STEP:
            for index in np.flatnonzero(ended):
                infos["final_obs"][index] = np.concatenate([infos["final_obs"][index], self._previous[index]])
            self._begin(ended)
        elif mode == AutoresetMode.NEXT_STEP:
            self._begin(self._ended)
        self._ended = ended
        return self._seen(observations), rewards, terminated, truncated, infos

    def observation_mask(self) -> Array:
        """Mask of the observations, ``[N, slots]``: ``False`` for padding and for slots of padded actions."""
        always = np.ones((self.num_envs, 2), dtype=bool)
        return np.concatenate([self.env.observation_mask(), self.env.action_mask(), always], axis=1)

    def _begin(self, environments: Array) -> None:
        self._previous[environments, :-1] = 0
        self._previous[environments, -1] = 1

    def _seen(self, observations: Array) -> Array:
        return np.concatenate([observations, self._previous], axis=1)
