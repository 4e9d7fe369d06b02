"""Controllers, and episodes as they ran."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from . import _core
from .errors import SettingError, need


class Controller(Protocol):
    """Something that acts: it is called with an observation and gives an action, both as the environment's spaces have
    them."""

    def __call__(self, observation: np.ndarray) -> np.ndarray: ...

    def reset(self) -> None:
        """Forgets everything: a new episode begins."""


class _BuiltIn:
    """A controller of the Rust crates. It takes f64 and gives physical units: see :func:`rollout`."""

    kind = ""

    def __init__(self, env, seed: int | None = None):
        self._env = env.unwrapped
        if seed is None:
            seed = getattr(self._env, "seed", 0)
        self._core = _core.Controller(self.kind, self._env.layout.core, seed)

    def reset(self) -> None:
        self._core.reset()

    def copy(self):
        """Another that stands where this one does, for snapshots of an environment."""
        other = object.__new__(type(self))
        other._env, other._core = self._env, self._core.copy()
        return other

    def physical(self, observation: np.ndarray) -> np.ndarray:
        """The action in physical units, f64."""
        return self._core.act(observation)

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """The action as the environment's space has it."""
        action, layout = self._core.act(observation), self._env.layout
        if self._env.rescale_action:
            span = layout.action_high - layout.action_low
            action = 2 * (action - layout.action_low) / np.where(span > 0, span, 1) - 1
        return action


class ReactiveController(_BuiltIn):
    """The paper's reactive controllers, after ASHRAE Guideline 36."""

    kind = "reactive"


class RandomController(_BuiltIn):
    """A fresh uniform action at every step; the same seed gives the same actions."""

    kind = "random"


class ConstantController(_BuiltIn):
    """The middle of every bound, always."""

    kind = "constant"


class _Callable:
    def __init__(self, function: Callable[[np.ndarray], Any]):
        self._function = function

    def reset(self) -> None:
        pass

    def __call__(self, observation):
        return self._function(observation)


def callable_controller(function: Callable[[np.ndarray], Any]) -> Controller:
    """A controller of any function from an observation to an action."""
    return _Callable(function)


@dataclass
class Trajectory:
    """An episode, a row a step. Observations have one row more: the first is that of the reset."""

    #: f64, ``[steps + 1, slots]``: states between the steps.
    observations: np.ndarray
    #: f64, ``[steps, actuators]``: as carried out, physical units.
    actions: np.ndarray
    #: f64, ``[steps]``.
    rewards: np.ndarray
    #: f64, ``[steps, 2]``: temperature and energy penalty.
    penalties: np.ndarray
    #: Whether the last step was the end of the episode.
    truncated: bool
    #: The environment's metadata: names, units, building.
    metadata: dict[str, Any] = field(repr=False)
    #: Sums over the episode, if it ran to its end.
    metrics: dict[str, Any] | None = None

    def __len__(self) -> int:
        return len(self.rewards)

    @property
    def episode_return(self) -> float:
        """Sum of the rewards."""
        return float(self.rewards.sum())

    def observed(self, name: str) -> np.ndarray:
        """A slot of the observation by its name, ``[steps + 1]``."""
        return self.observations[:, _index(self.metadata["observation_names"], name)]

    def acted(self, name: str) -> np.ndarray:
        """An actuator by its name, ``[steps]``."""
        return self.actions[:, _index(self.metadata["action_names"], name)]

    def hash(self) -> str:
        """SHA-256 of every bit: that of ``b2b run`` for the same episode."""
        return _core.trajectory_hash(self.observations[1:], self.actions, self.penalties)

    def to_dict(self) -> dict[str, np.ndarray]:
        """A column for each slot, actuator and term, as in ``trajectory.parquet``: states at the ends of the steps."""
        columns = {name: self.observations[1:, i] for i, name in enumerate(self.metadata["observation_names"])}
        columns |= {f"action: {name}": self.actions[:, i] for i, name in enumerate(self.metadata["action_names"])}
        columns |= {"temperature penalty": self.penalties[:, 0], "energy penalty": self.penalties[:, 1]}
        return columns | {"reward": self.rewards}

    def to_parquet(self, path: str | os.PathLike) -> None:
        """Writes it as a Parquet file (needs ``pyarrow``): aside first, so that no half is left."""
        pyarrow, parquet = need("pyarrow", "pyarrow"), need("pyarrow.parquet", "pyarrow")
        aside = f"{os.fspath(path)}.partial"
        try:
            parquet.write_table(pyarrow.table(self.to_dict()), aside)
            os.replace(aside, path)
        finally:
            if os.path.exists(aside):
                os.unlink(aside)


def _index(names: list[str], name: str) -> int:
    if name not in names:
        raise SettingError(f"there is no `{name}`: there are {', '.join(names)}")
    return names.index(name)


def rollout(env, controller: Controller | Callable, *, steps: int | None = None, seed: int | None = None) -> Trajectory:
    """Runs an episode from reset to its end, or for so many steps.

    The controllers of this package see f64 and act in physical units, so that an episode is that of ``b2b run`` to the
    bit; others get what the environment's wrappers give.
    """
    core = env.unwrapped
    if hasattr(controller, "reset"):
        controller.reset()
    built_in = isinstance(controller, _BuiltIn)
    observation, _ = env.reset(seed=seed)
    observations, actions, rewards, penalties = [core.observation], [], [], []
    truncated, info = False, {}
    while not truncated and (steps is None or len(rewards) < steps):
        if built_in:
            action = controller.physical(core.observation)
            observation, reward, _, truncated, info = core.step(action, rescale=False)
        else:
            observation, reward, terminated, truncated, info = env.step(controller(observation))
            truncated = truncated or terminated
        observations.append(core.observation)
        actions.append(core.carried_out())
        rewards.append(reward)
        penalties.append(core.penalties)
    return Trajectory(
        np.array(observations),
        np.array(actions).reshape(len(rewards), -1),
        np.array(rewards),
        np.array(penalties).reshape(len(rewards), 2),
        truncated,
        dict(core.metadata),
        info.get("metrics") if truncated else None,
    )
