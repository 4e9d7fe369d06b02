"""The previous step as a part of the observation."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray

from ..errors import SettingError
from .observation_wrapper import Env, ObservationWrapper, Stepped

Array = NDArray[Any]


class PreviousStepObservation(ObservationWrapper):
    """Appends the previous step: its action in [-1, 1], its reward, and 1 in the first step of an episode.

    The first two are 0 in the first step. Policies with memory observe the same slots in benchmark problems where they
    keep their memory.
    """

    def __init__(self, env: Env):
        super().__init__(env)
        if not isinstance(env.action_space, Box):
            raise SettingError(f"expected actions in a Box; got {env.action_space}")
        self._low = env.action_space.low.astype(np.float64)
        span = env.action_space.high - self._low
        self._span = np.where(span > 0, span, np.inf)
        self._previous = np.zeros(len(span) + 2)
        ones = np.ones(len(span))
        names = [f"previous {name}" for name in env.metadata["action_names"]]
        self._extend(
            [*-ones, -np.inf, 0],
            [*ones, np.inf, 1],
            [*names, "previous reward", "first step"],
            ["1"] * len(self._previous),
        )

    def observation(self, observation: Array) -> Array:
        return np.concatenate([observation, self._previous.astype(observation.dtype)])

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        self._previous[:] = 0
        self._previous[-1] = 1
        return super().reset(seed=seed, options=options)

    def step(self, action: ArrayLike) -> Stepped:
        observation, reward, terminated, truncated, info = self.env.step(action)
        scaled = 2 * (np.asarray(action, np.float64) - self._low) / self._span - 1
        self._previous[:-2] = np.where(np.isfinite(self._span), np.clip(scaled, -1, 1), 0)
        self._previous[-2:] = reward, 0
        return self.observation(observation), reward, terminated, truncated, info
