"""What the wrappers of an environment leave as it is."""

from __future__ import annotations

from typing import Any

import gymnasium


def is_own(env: gymnasium.Env[Any, Any]) -> bool:
    """Returns whether no wrapper has changed the observation of the building. Zeros may follow it."""
    while isinstance(env, gymnasium.Wrapper):
        inner = env.env
        if not getattr(env, "appends_zeros", False) and (
            isinstance(env, gymnasium.ObservationWrapper)
            or env.observation_space != inner.observation_space
            or env.metadata.get("observation_names") != inner.metadata.get("observation_names")
        ):
            return False
        env = inner
    return True


def is_plain(env: gymnasium.Env[Any, Any]) -> bool:
    """Returns whether observations and actions are the building's."""
    return is_own(env) and env.action_space == env.unwrapped.action_space
