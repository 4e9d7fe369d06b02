"""Controllers, rollouts and trajectories."""

from __future__ import annotations

import copy
import json
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core
from .buildings.signatures import renamed
from .env import unwrap
from .env.layers import is_plain
from .env.layout import Layout, index_of
from .errors import SettingError, need
from .process.temporary import replacing

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


class PhysicalController:
    """A controller that observes f64 and acts in physical units: see :func:`rollout`."""

    def __init__(self, env: gymnasium.Env[Any, Any] | ControlledEnv):
        core: Any = env.unwrapped
        self._layout: Layout = core.layout
        self._rescale: bool = core.rescale_action
        #: Whether it was made for an environment whose observations and actions are the building's.
        self._is_plain = not isinstance(env, gymnasium.Env) or is_plain(env)

    def physical(self, observation: ArrayLike) -> NDArray[np.float64]:
        """Returns the action for an observation in f64 and physical units."""
        raise NotImplementedError

    def reward(self, reward: float) -> None:
        """Takes the reward of the last action. :func:`rollout` calls it."""

    def __call__(self, observation: Array) -> NDArray[np.float64]:
        """Returns the action for an observation, in the environment's action space.

        Raises if wrappers have changed the observations or the actions; :func:`rollout` runs the controller there.
        """
        if not self._is_plain:
            raise SettingError(
                f"{type(self).__name__} was made for wrappers that change observations or actions; use rollout, or "
                "make it for env.unwrapped and step that"
            )
        action = self.physical(observation)
        return self._layout.rescaled(action) if self._rescale else action


class BuiltInController(PhysicalController):
    """A controller of the Rust core by the name of its ``kind``."""

    kind = ""

    def __init__(
        self,
        env: gymnasium.Env[Any, Any] | ControlledEnv,
        seed: int | None = None,
        *,
        kind: str | None = None,
        parameters: Mapping[str, float] | None = None,
    ):
        super().__init__(env)
        #: Its random seed.
        self.seed: int = getattr(env.unwrapped, "seed", 0) if seed is None else seed
        changes = None if parameters is None else dict(parameters)
        #: Name of its kind.
        self.kind = kind or self.kind
        self._core = _core.Controller(self.kind, self._layout.spaces, self.seed, changes)

    def reset(self) -> None:
        """Resets the state for a new episode."""
        self._core.reset()

    def next_episode(self) -> None:
        """Begins another episode in the same building: an agent with memory keeps it."""
        self._core.next_episode()

    def reward(self, reward: float) -> None:
        """Takes the reward of the last action, which an agent with memory may observe."""
        self._core.reward(reward)

    def copy(self) -> BuiltInController:
        """Returns a copy with the same state, for use with snapshots of an environment."""
        other = object.__new__(type(self))
        other.__dict__.update(self.__dict__)
        other._core = self._core.copy()
        return other

    __copy__ = copy

    def __deepcopy__(self, memo: dict[int, Any]) -> BuiltInController:
        return self.copy()

    def physical(self, observation: ArrayLike) -> NDArray[np.float64]:
        return self._core.act(observation)


class ReactiveController(BuiltInController):
    """The paper's reactive controllers, based on ASHRAE Guideline 36.

    They use the parameters tuned for the building and the task (:meth:`tuned`); ``parameters`` overrides some,
    such as ``{"unitary.deadband": 0.5}``.
    """

    kind = "reactive"

    @staticmethod
    def tuned(env: gymnasium.Env[Any, Any] | ControlledEnv) -> dict[str, float]:
        """Returns the tuned parameters for an environment, by name."""
        core: Any = env.unwrapped
        return _core.reactive_parameters(core.layout.spaces)


class Guideline36Controller(BuiltInController):
    """The sequences of ASHRAE Guideline 36, which hold comfort bands: the baseline in tasks of operation."""

    kind = "guideline36"


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


#: The arrays of a trajectory, and its other saved fields.
_ARRAYS = ("observations", "actions", "rewards", "penalties")
_DESCRIBED = ("truncated", "metadata", "metrics", "controller", "seed")


def _widths(metadata: dict[str, Any]) -> tuple[int, int]:
    return len(metadata["observation_names"]), len(metadata["action_names"])


@dataclass(repr=False)
class Trajectory:
    """The steps of an episode. ``observations`` has one row more than the others: the first is from the reset."""

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
    metadata: dict[str, Any]
    #: Metrics of the episode; ``None`` if it did not run to its end.
    metrics: dict[str, Any] | None = None
    #: Name of the controller.
    controller: str = ""
    #: Seed of the controller.
    seed: int = 0
    #: Spaces and report of the engine, and the duration of the steps (s), for :meth:`write`; neither saved nor pickled.
    _record: tuple[_core.Record, float] | None = field(default=None, compare=False)

    def __len__(self) -> int:
        return len(self.rewards)

    def __repr__(self) -> str:
        end = "" if self.truncated else ", before the end of the episode"
        return (
            f"<Trajectory of {self.metadata.get('building')}: {len(self)} steps, return {self.episode_return:.6g}{end}>"
        )

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_record": None}

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

    def write(
        self, folder: str | os.PathLike[str], *, controller: str | None = None, seed: int | None = None
    ) -> list[Path]:
        """Writes the files of ``b2b run`` to a folder: ``trajectory.parquet`` (the steps, with date and time),
        ``summary.json`` and ``picture.html``. Returns their paths.

        ``b2b compare`` and ``b2b score`` read them. If the episode did not run to its end, only the steps are written.
        ``controller`` and ``seed`` name the run, by default after the controller. The reward in the files is the
        task's. Raises :class:`~building2building.errors.SettingError` for a trajectory that was loaded or pickled,
        which lacks the engine's report.
        """
        record, seconds = record_of(self)
        return record.write(
            folder,
            controller or self.controller or "policy",
            self.seed if seed is None else seed,
            seconds,
            self.observations[1:],
            self.actions,
            self.penalties,
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a NumPy file (.npz) atomically, which :meth:`load` reads."""
        described = {name: getattr(self, name) for name in _DESCRIBED}
        text = json.dumps(described, default=lambda value: np.asarray(value).tolist())
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        with replacing(path) as partial, open(partial, "wb") as file:
            np.savez_compressed(file, described=np.array(text), **arrays)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Trajectory:
        """Reads a file that :meth:`save` wrote.

        Raises :class:`~building2building.errors.SettingError` for a file that is missing, damaged or another one.
        """
        try:
            with open(path, "rb") as opened:
                return cls._read(opened)
        except OSError as error:
            raise SettingError(f"cannot read {os.fspath(path)}: {error.strerror or error}") from error
        except Exception as error:  # damaged files raise whatever zipfile, zlib, NumPy and json do
            raise SettingError(f"{os.fspath(path)} is not a trajectory; expected a file of Trajectory.save") from error

    @classmethod
    def _read(cls, opened: Any) -> Trajectory:
        with np.load(opened, allow_pickle=False) as file:
            arrays = {name: file[name] for name in _ARRAYS}
            described = json.loads(str(file["described"]))
        trajectory = cls(**arrays, **{name: described[name] for name in _DESCRIBED if name in described})
        steps, slots, actuators = len(trajectory), *_widths(trajectory.metadata)
        expected = ((steps + 1, slots), (steps, actuators), (steps,), (steps, 2))
        if tuple(array.shape for array in arrays.values()) != expected:
            raise ValueError("the arrays do not belong together")
        return trajectory

    def to_parquet(self, path: str | os.PathLike[str]) -> None:
        """Writes a Parquet file atomically. Needs ``pyarrow``."""
        pyarrow, parquet = need("pyarrow", "pyarrow"), need("pyarrow.parquet", "pyarrow")
        with replacing(path) as partial:
            parquet.write_table(pyarrow.table(self.to_dict()), partial)


@renamed(max_steps="pass steps", stop_on_terminated="no episode terminates")
def rollout(
    env: gymnasium.Env[Any, Any],
    controller: Controller | Callable[[Array], ArrayLike],
    *,
    steps: int | None = None,
    seed: int | None = None,
) -> Trajectory:
    """Runs an episode from its reset to its end, or for at most ``steps`` steps.

    Built-in controllers observe f64 and act in physical units, so an episode equals ``b2b run`` bit for bit; other
    controllers see what the environment's wrappers return. Rewards and the end are the wrappers'. Built-in controllers
    also act where wrappers change the action space, but not where wrappers change rewards or steps as well.
    """
    if isinstance(controller, Controller):
        controller.reset()
    return run_episode(env, controller, steps=steps, seed=seed)


def record_of(trajectory: Trajectory) -> tuple[_core.Record, float]:
    """Returns the core's record of an episode that ran in this process, and the time that it took, s."""
    if trajectory._record is None:
        raise SettingError("this trajectory was loaded or copied; write it in the process that ran its episode")
    return trajectory._record


def run_episode(
    env: gymnasium.Env[Any, Any],
    controller: Controller | Callable[[Array], ArrayLike],
    *,
    steps: int | None = None,
    seed: int | None = None,
) -> Trajectory:
    """Like :func:`rollout`, for a controller that has been reset or has begun another episode."""
    core = unwrap(env)
    with core.finishing_runs():
        observation, _ = env.reset(seed=seed)
    began = time.monotonic()
    observations = [core.observation]
    actions: list[Array] = []
    rewards: list[float] = []
    penalties: list[tuple[float, float]] = []
    truncated = False
    info: dict[str, Any] = {}
    step = _through_wrappers(env, controller) if isinstance(controller, PhysicalController) else None
    while not truncated and (steps is None or len(rewards) < steps):
        before = core.steps
        stepped = env.step(controller(observation)) if step is None else step()
        if core.steps > before + 1:
            raise SettingError(
                f"a step of this environment is {core.steps - before} steps of the building, and a trajectory has all; "
                "roll out acting_controller(policy, acting) in an environment without acting"
            )
        observation, reward, terminated, truncated, info = stepped
        truncated = truncated or terminated
        observations.append(core.observation)
        actions.append(core.applied_action())
        rewards.append(float(reward))
        penalties.append(core.penalties)
    return Trajectory(
        np.array(observations),
        np.array(actions).reshape(len(rewards), len(core.layout.action)),
        np.array(rewards),
        np.array(penalties).reshape(len(rewards), 2),
        truncated,
        dict(core.metadata),
        info.get("metrics") if truncated else None,
        _name_of(controller),
        getattr(controller, "seed", 0) if isinstance(controller, BuiltInController) else 0,
        (core.record(), time.monotonic() - began),
    )


def _through_wrappers(
    env: gymnasium.Env[Any, Any], controller: PhysicalController
) -> Callable[[], tuple[Any, Any, bool, bool, dict[str, Any]]]:
    """Returns a function that runs a step with the controller's action, exact whatever wrappers make of it.

    Wrappers that change the action space get a valid action of theirs instead. What they do with it cannot matter if
    they leave rewards and steps alone, otherwise the function raises.
    """
    core = unwrap(env)
    stand_in = None if env.action_space is core.action_space else copy.deepcopy(env.action_space).sample()

    def step() -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        action, steps = controller.physical(core.observation), core.steps
        carried = core.layout.rescaled(action) if core.rescale_action else action
        core._exact = (carried, action) if stand_in is None else (None, action)
        try:
            stepped = env.step(carried if stand_in is None else stand_in)
        finally:
            core._exact = None
        _, reward, terminated, truncated, _ = stepped
        own = core._last_reward, core._truncated, steps + 1
        if stand_in is not None and (reward, terminated or truncated, core.steps) != own:
            raise SettingError(
                f"{_name_of(controller)} cannot act through {env}, which changes both actions and rewards or steps; "
                "pass env.unwrapped to leave wrappers out, or use rescale_action=True and reward= of make_env instead"
            )
        controller.reward(float(reward))
        return stepped

    return step


def _name_of(controller: Any) -> str:
    if isinstance(controller, CallableController):
        controller = controller.function
    name = getattr(controller, "kind", "") if isinstance(controller, BuiltInController) else ""
    return name or getattr(controller, "__name__", "") or type(controller).__name__
