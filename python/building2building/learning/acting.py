"""Environments as agents of ``b2b train`` see them, with actions that correct or supervise a controller."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..env import BuildingEnv
from ..errors import EpisodeError, SettingError
from ..rollouts import ControlledEnv, PhysicalController
from ..vector import BuildingVectorEnv
from ..wrappers.observation_wrapper import VectorWrapper

Array = NDArray[Any]


def _spaces(pilot: _core.Pilot) -> tuple[Box, Box]:
    """Returns the spaces of observations and actions."""
    slots, actions = len(pilot.observation_names()), len(pilot.action_names())
    return Box(-np.inf, np.inf, (slots,), np.float32), Box(-1.0, 1.0, (actions,), np.float32)


def _named(metadata: dict[str, Any], pilot: _core.Pilot) -> dict[str, Any]:
    """Returns the metadata of a building with the names of the pilot, whose values have no unit."""
    for side, names in [("observation", pilot.observation_names()), ("action", pilot.action_names())]:
        metadata = metadata | {f"{side}_names": names, f"{side}_units": ["1"] * len(names)}
    return metadata


class ActingEnv(gymnasium.Wrapper[Array, ArrayLike, Array, ArrayLike]):
    """A building for an agent with an *acting*; ``make_env(acting=...)`` makes one.

    A step is a decision: with ``supervisory:60``, twelve steps of five minutes, whose rewards are added and whose last
    info is returned. Actions are in [-1, 1]; zeros leave the controller unchanged. Names are in ``metadata``.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], acting: str, observation: str = "features"):
        super().__init__(env)
        core = env.unwrapped
        if not isinstance(core, BuildingEnv) or core.rescale_action:
            raise SettingError("acting sets actuators in physical units; make the environment without rescale_action")
        self._building = core
        self._interface = observation, acting
        self._read()

    def __reduce__(self) -> tuple[Any, ...]:
        # The copy begins without an episode, as that of the building.
        observation, acting = self._interface
        return type(self), (self.env, acting, observation)

    def _read(self) -> None:
        self._spaces = self._building.layout.spaces
        self._pilot = _core.Pilot(self._spaces, *self._interface)
        self.observation_space, self.action_space = _spaces(self._pilot)
        self.metadata = _named(self.env.metadata, self._pilot)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        _, info = self.env.reset(seed=seed, options=options)
        if self._building.layout.spaces is not self._spaces:
            self._read()
        self._pilot.reset()
        return self._pilot.observe(self._building.observation), info

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        total = 0.0
        for _ in range(self._pilot.hold):
            _, reward, terminated, truncated, info = self.env.step(self._pilot.act(action))
            total += float(reward)
            observation = self._pilot.observe(self._building.observation)
            if terminated or truncated:
                break
        return observation, total, terminated, truncated, info


class PhysicalVectorEnv(BuildingVectorEnv):
    """A batch of buildings that :class:`ActingVectorEnv` drives, each in its own physical units."""

    _shares_actions = False


class ActingVectorEnv(VectorWrapper):
    """A batch of buildings for an agent with an *acting*; ``make_vec(acting=...)`` makes one.

    Steps are decisions, as in :class:`ActingEnv`. All buildings must have the same observation and actions. An
    environment that is lost during a decision is truncated, and its next episode begins with the next decision.
    """

    env: BuildingVectorEnv
    single_observation_space: Box
    single_action_space: Box

    def __init__(self, env: BuildingVectorEnv, acting: str, observation: str = "features"):
        super().__init__(env)
        if env.rescale_action or env.normalize:
            message = "acting has its own scales; make the environments without rescale_action and normalize"
            raise SettingError(message)
        if env.autoreset_mode != AutoresetMode.SAME_STEP:
            raise SettingError("acting resets with the last step of a decision; pass autoreset_mode='SameStep'")
        self._interface = observation, acting
        first = _core.Pilot(env.layout_of(0).spaces, *self._interface)
        self.single_observation_space, self.single_action_space = _spaces(first)
        self._pilots = [self._pilot(index) for index in range(env.num_envs)]
        self._seen = np.zeros((env.num_envs, *self.single_observation_space.shape), np.float32)
        self.observation_space = batch_space(self.single_observation_space, env.num_envs)
        self.action_space = batch_space(self.single_action_space, env.num_envs)
        self.metadata = _named(env.metadata, first)

    def observation_mask(self) -> Array:
        """Mask of the observations, ``[N, observations]``: none is padding."""
        return np.ones((self.num_envs, *self.single_observation_space.shape), dtype=bool)

    def action_mask(self) -> Array:
        """Mask of the actions, ``[N, actions]``: all are read."""
        return np.ones((self.num_envs, *self.single_action_space.shape), dtype=bool)

    def _pilot(self, index: int) -> _core.Pilot:
        """Returns the pilot of an environment's building; raises if its spaces are not the batch's."""
        pilot = _core.Pilot(self.env.layout_of(index).spaces, *self._interface)
        if _spaces(pilot) != (self.single_observation_space, self.single_action_space):
            raise SettingError("the buildings differ in observations or actions; choose buildings of one type")
        return pilot

    def reset(
        self, *, seed: int | list[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        observations, info = self.env.reset(seed=seed, options=options)
        self._seen = self._seen.copy()
        for index in np.flatnonzero((options or {}).get("reset_mask", np.ones(self.num_envs))):
            self._pilots[index] = self._pilot(int(index))
            self._seen[index] = self._pilots[index].observe(observations[index])
        return self._seen.copy(), info

    def step(self, actions: ArrayLike) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        rows, total, ended = np.asarray(actions), np.zeros(self.num_envs), np.zeros(self.num_envs, bool)
        ends: list[tuple[Array, dict[str, Any]]] = []
        for _ in range(self._pilots[0].hold):
            early = ended
            physical = np.stack([pilot.act(row) for pilot, row in zip(self._pilots, rows, strict=True)])
            observations, rewards, terminated, truncated, infos = self.env.step(physical)
            total += np.where(early, 0.0, rewards)
            if truncated.any():
                self._end(truncated, infos)
                ends.append((truncated & ~early, infos))
                ended = early | truncated
            self._seen = np.stack([pilot.observe(row) for pilot, row in zip(self._pilots, observations, strict=True)])
        if ended.any():
            for environments, earlier in ends:
                _add_ends(infos, earlier, environments)
            self._begin_with_decision(early)
            self.env.add_begun(infos, ended)
        return self._seen.copy(), total, terminated, ended, infos

    def _begin_with_decision(self, environments: Array) -> None:
        """Begins the episodes after those that were lost, so that these, too, are whole days and end with a decision.

        An episode that is lost again is reported in the next step, which begins another.
        """
        for index in np.flatnonzero(environments):
            with suppress(EpisodeError):
                self.reset(options={"reset_mask": np.arange(self.num_envs) == index})

    def _end(self, truncated: Array, infos: dict[str, Any]) -> None:
        """Converts the last observations of episodes that ended, and begins the next."""
        for index in np.flatnonzero(truncated):
            infos["final_obs"][index] = self._pilots[index].observe(infos["final_obs"][index])
            self._pilots[index] = self._pilot(int(index))


def _add_ends(infos: dict[str, Any], earlier: dict[str, Any], ended: Array) -> None:
    """Adds the episodes that ended in an earlier step of a decision to the infos of the last."""
    for name in ("final_obs", "lost"):
        for key in [name, f"_{name}"] if name in earlier else []:
            infos[key] = np.where(ended, earlier[key], infos[key]) if key in infos else earlier[key]
    if "final_info" not in infos:
        infos["final_info"], infos["_final_info"] = earlier["final_info"], earlier["_final_info"]


class ActingController(PhysicalController):
    """A policy for an *acting* as a controller of the building; :func:`acting_controller` makes a class of them."""

    #: The policy, from the observation to the action of :class:`ActingEnv`, and the names of both.
    policy: Callable[[Array], ArrayLike]
    acting: str
    observation: str

    def __init__(self, env: gymnasium.Env[Any, Any] | ControlledEnv):
        super().__init__(env)
        self._pilot = _core.Pilot(self._layout.spaces, self.observation, self.acting)
        self.reset()

    def reset(self) -> None:
        """Resets the state for a new episode."""
        self._pilot.reset()
        self._steps, self._decision = 0, np.zeros(0)

    def physical(self, observation: ArrayLike) -> NDArray[np.float64]:
        seen = self._pilot.observe(observation)
        if self._steps % self._pilot.hold == 0:
            self._decision = np.array(self.policy(seen))
        self._steps += 1
        return self._pilot.act(self._decision)


def acting_controller(
    policy: Callable[[Array], ArrayLike], acting: str, observation: str = "features"
) -> type[ActingController]:
    """Returns a policy, trained on ``make_env(acting=...)``, ``make_vec`` or ``make_sb3_vec``, as a controller class.

    :func:`building2building.evaluate` and :func:`building2building.rollout` take it.
    """
    # The class is the caller's, so that the policy is part of what identifies its results.
    values = {"policy": staticmethod(policy), "acting": acting, "observation": observation, "__module__": "__main__"}
    return type(getattr(policy, "__name__", "ActingController"), (ActingController,), values)
