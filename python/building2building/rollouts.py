"""Controllers, rollouts and trajectories."""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .env import unwrap
from .errors import SettingError, need
from .layout import Layout, index_of

Array = NDArray[Any]


@runtime_checkable
class Controller(Protocol):
    """Maps observations to actions, both in the environment's spaces."""

    def __call__(self, observation: Array) -> ArrayLike: ...

    def reset(self) -> None:
        """Resets the state for a new episode."""


class ControlledEnv(Protocol):
    """The attributes of an environment that the built-in controllers need."""

    layout: Layout
    rescale_action: bool

    @property
    def unwrapped(self) -> Any: ...


class BuiltInController:
    """A controller of the Rust core by the name of its ``kind``. It computes in f64 and physical units; see :func:`rollout`."""

    kind = ""

    def __init__(
        self,
        env: gymnasium.Env[Any, Any] | ControlledEnv,
        seed: int | None = None,
        *,
        kind: str | None = None,
        parameters: Mapping[str, float] | None = None,
    ):
        core: Any = env.unwrapped
        self._layout: Layout = core.layout
        self._rescale: bool = core.rescale_action
        seed = getattr(core, "seed", 0) if seed is None else seed
        changes = None if parameters is None else dict(parameters)
        self._core = _core.Controller(kind or self.kind, self._layout.spaces, seed, changes)

    def reset(self) -> None:
        """Resets the state for a new episode."""
        self._core.reset()

    def copy(self) -> BuiltInController:
        """Returns a copy with the same state, for use with snapshots of an environment."""
        other = object.__new__(type(self))
        other._layout, other._rescale, other._core = self._layout, self._rescale, self._core.copy()
        return other

    def __deepcopy__(self, memo: dict[int, Any]) -> BuiltInController:
        return self.copy()

    def physical(self, observation: ArrayLike) -> NDArray[np.float64]:
        """Returns the action for an observation in f64 and physical units."""
        return self._core.act(observation)

    def __call__(self, observation: Array) -> NDArray[np.float64]:
        """Returns the action for an observation, in the environment's action space."""
        action, layout = self._core.act(observation), self._layout
        if self._rescale:
            span = layout.action_high - layout.action_low
            action = 2 * (action - layout.action_low) / np.where(span > 0, span, 1) - 1
        return action


class ReactiveController(BuiltInController):
    """The paper's reactive controllers, based on ASHRAE Guideline 36.

    They use the parameters that are tuned for the building and the task (:meth:`tuned`), except for those given in
    ``parameters``, such as ``{"unitary.deadband": 0.5}``.
    """

    kind = "reactive"

    @staticmethod
    def tuned(env: gymnasium.Env[Any, Any] | ControlledEnv) -> dict[str, float]:
        """Returns the tuned parameters for an environment, by name."""
        core: Any = env.unwrapped
        return _core.reactive_parameters(core.layout.spaces)


class RandomController(BuiltInController):
    """Draws every action uniformly from the action space; the same seed gives the same actions."""

    kind = "random"


class ConstantController(BuiltInController):
    """Applies the midpoint of the action bounds at every step."""

    kind = "constant"


class CallableController:
    """A function as a controller without state."""

    def __init__(self, function: Callable[[Array], ArrayLike]):
        self.function = function

    def reset(self) -> None:
        """Does nothing."""

    def __call__(self, observation: Array) -> ArrayLike:
        return self.function(observation)


def callable_controller(function: Callable[[Array], ArrayLike]) -> Controller:
    """Makes a controller from a function that maps an observation to an action."""
    return CallableController(function)


#: The arrays of a trajectory.
_ARRAYS = ("observations", "actions", "rewards", "penalties")


@dataclass
class Trajectory:
    """The steps of an episode. ``observations`` has one row more than the others: the first is that of the reset."""

    #: f64 ``[steps + 1, slots]``.
    observations: Array
    #: f64 ``[steps, actuators]``, as applied, in physical units.
    actions: Array
    #: f64 ``[steps]``.
    rewards: Array
    #: f64 ``[steps, 2]``: temperature and energy penalty.
    penalties: Array
    #: Whether the last step ended the episode.
    truncated: bool
    #: The environment's metadata: names, units, building.
    metadata: dict[str, Any] = field(repr=False)
    #: Metrics of the episode; ``None`` if it did not run to its end.
    metrics: dict[str, Any] | None = None

    def __len__(self) -> int:
        return len(self.rewards)

    @property
    def episode_return(self) -> float:
        """Sum of the rewards."""
        return float(self.rewards.sum())

    def observed(self, name: str) -> Array:
        """Returns the values of an observation slot, ``[steps + 1]``."""
        return self.observations[:, index_of(self.metadata["observation_names"], "observation slot", name)]

    def acted(self, name: str) -> Array:
        """Returns the values of an actuator, ``[steps]``."""
        return self.actions[:, index_of(self.metadata["action_names"], "actuator", name)]

    def hash(self) -> str:
        """Returns the SHA-256 of all values, which ``b2b run`` prints for the same episode."""
        return _core.trajectory_hash(self.observations[1:], self.actions, self.penalties)

    def to_dict(self) -> dict[str, Array]:
        """Returns the columns of a table: observations at the ends of the steps, actions, penalties and the reward."""
        columns = {name: self.observations[1:, i] for i, name in enumerate(self.metadata["observation_names"])}
        columns |= {f"action: {name}": self.actions[:, i] for i, name in enumerate(self.metadata["action_names"])}
        columns |= {"temperature penalty": self.penalties[:, 0], "energy penalty": self.penalties[:, 1]}
        return columns | {"reward": self.rewards}

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a NumPy file (.npz) atomically, which :meth:`load` reads."""
        described = {"truncated": self.truncated, "metadata": self.metadata, "metrics": self.metrics}
        text = json.dumps(described, default=lambda value: np.asarray(value).tolist())
        partial = f"{os.fspath(path)}.partial"
        try:
            with open(partial, "wb") as file:
                np.savez_compressed(file, described=np.array(text), **{name: getattr(self, name) for name in _ARRAYS})
            os.replace(partial, path)
        finally:
            if os.path.exists(partial):
                os.unlink(partial)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Trajectory:
        """Reads a file that :meth:`save` wrote."""
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in _ARRAYS}
                described = json.loads(str(file["described"]))
        except (KeyError, ValueError, zipfile.BadZipFile) as error:
            raise SettingError(f"{os.fspath(path)} is not a trajectory; expected a file of Trajectory.save") from error
        return cls(**arrays, **described)

    def to_parquet(self, path: str | os.PathLike[str]) -> None:
        """Writes a Parquet file atomically. Needs ``pyarrow``."""
        pyarrow, parquet = need("pyarrow", "pyarrow"), need("pyarrow.parquet", "pyarrow")
        partial = f"{os.fspath(path)}.partial"
        try:
            parquet.write_table(pyarrow.table(self.to_dict()), partial)
            os.replace(partial, path)
        finally:
            if os.path.exists(partial):
                os.unlink(partial)


def rollout(
    env: gymnasium.Env[Any, Any],
    controller: Controller | Callable[[Array], ArrayLike],
    *,
    steps: int | None = None,
    seed: int | None = None,
) -> Trajectory:
    """Runs an episode from its reset to its end, or for at most ``steps`` steps.

    The built-in controllers observe f64 and act in physical units, so an episode equals that of ``b2b run`` bit for
    bit; other controllers see what the environment's wrappers return.
    """
    core = unwrap(env)
    if isinstance(controller, Controller):
        controller.reset()
    observation, _ = env.reset(seed=seed)
    observations = [core.observation]
    actions: list[Array] = []
    rewards: list[float] = []
    penalties: list[tuple[float, float]] = []
    truncated = False
    info: dict[str, Any] = {}
    while not truncated and (steps is None or len(rewards) < steps):
        if isinstance(controller, BuiltInController):
            action = controller.physical(core.observation)
            observation, reward, _, truncated, info = core.step(action, rescale=False)
        else:
            observation, step_reward, terminated, truncated, info = env.step(controller(observation))
            reward, truncated = float(step_reward), truncated or terminated
        observations.append(core.observation)
        actions.append(core.applied_action())
        rewards.append(reward)
        penalties.append(core.penalties)
    return Trajectory(
        np.array(observations),
        np.array(actions).reshape(len(rewards), len(core.layout.action)),
        np.array(rewards),
        np.array(penalties).reshape(len(rewards), 2),
        truncated,
        dict(core.metadata),
        info.get("metrics") if truncated else None,
    )
