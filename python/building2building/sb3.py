"""A vector environment for Stable-Baselines3."""

from __future__ import annotations

import contextlib
import logging
import os
import warnings
from collections.abc import Iterator
from typing import Any, cast

import numpy as np
from gymnasium.vector import AutoresetMode

from .errors import SettingError, need

need("stable_baselines3", "train")
from stable_baselines3.common.monitor import Monitor  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402

from .env.physical_actions import warn_of_learner  # noqa: E402
from .learning.acting import ActingVectorEnv  # noqa: E402
from .process.temporary import replacing  # noqa: E402
from .registration import make_vec  # noqa: E402
from .scaling import Scale  # noqa: E402
from .vector import BuildingVectorEnv  # noqa: E402


class SB3VecEnv(VecEnv):
    """Stable-Baselines3's ``VecEnv`` around a :class:`BuildingVectorEnv` that resets in the same step.

    At the end of an episode, ``infos[i]["terminal_observation"]`` is its last observation,
    ``infos[i]["TimeLimit.truncated"]`` is true, so that SB3 bootstraps its value, and ``infos[i]["episode"]`` has
    return and length for SB3's log.
    """

    def __init__(self, envs: BuildingVectorEnv, normalize: bool = True):
        if envs.autoreset_mode != AutoresetMode.SAME_STEP:
            raise SettingError(
                "Stable-Baselines3 resets in the same step; make the environments with autoreset_mode='SameStep'"
            )
        self.envs = envs
        space = envs.single_observation_space
        #: Normalization of the observations that the policy sees; ``None`` without.
        self.scale = envs.scale if normalize or envs.normalize else None
        if self.scale is not None:
            space = self.scale.space
        self._seed: int | None = None
        #: The infos of the last step, computed when they are read, so that learners do not pay for them.
        self.infos: dict[str, Any] = {}
        self._returns = np.zeros(envs.num_envs)
        self._lengths = np.zeros(envs.num_envs, dtype=int)
        self.render_mode = None
        super().__init__(envs.num_envs, space, envs.single_action_space)

    def _scaled(self, observations: Any) -> Any:
        return observations if self.scale is None or self.envs.normalize else self.scale(observations)

    def reset(self) -> Any:
        if not self.envs.rescale_action:
            warn_of_learner()
        observations, begun = self.envs.reset(seed=self._seed)
        self._seed = None
        self._returns[:], self._lengths[:] = 0, 0
        self.reset_infos = [{name: begun[name][index] for name in begun} for index in range(self.num_envs)]
        return self._scaled(observations)

    def step_async(self, actions: Any) -> None:
        self._actions = actions

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        observations, rewards, _, dones, all_infos = self.envs.step(self._actions)
        self._returns += rewards
        self._lengths += 1
        self.infos = all_infos
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for index in np.flatnonzero(dones):
            infos[index] = {
                "terminal_observation": self._scaled(all_infos["final_obs"][index][None])[0],
                "TimeLimit.truncated": True,
                "episode": {"r": float(self._returns[index]), "l": int(self._lengths[index]), "t": 0.0},
                "metrics": all_infos["final_info"]["metrics"][index],
            }
            self.reset_infos[index] = {name: all_infos[name][index] for name in ("weather", "first_day")}
            self._returns[index], self._lengths[index] = 0, 0
        return self._scaled(observations), rewards.astype(np.float32), dones, infos

    def close(self) -> None:
        self.envs.close()

    def seed(self, seed: int | None = None) -> list[int | None]:
        self._seed = seed
        return [seed] * self.num_envs

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Returns an attribute of each environment: ``layout``, a space, or one that all share, such as ``spec``.

        Raises ``AttributeError`` if they do not have it.
        """
        indices = self._get_indices(indices)
        if attr_name == "layout":
            return [self.envs.layout_of(index) for index in indices]
        value = getattr(self if attr_name in ("observation_space", "action_space") else self.envs, attr_name)
        return [value for _ in indices]

    def set_options(self, options: Any = None) -> None:
        """Raises for options, because batches have none."""
        if options:
            raise NotImplementedError(f"options of reset are {options!r}; expected none")

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Raises, because the settings of the environments are fixed."""
        raise AttributeError(f"`{attr_name}` cannot be set; make other environments")

    def env_method(self, method_name: str, *arguments: Any, indices: Any = None, **options: Any) -> list[Any]:
        raise NotImplementedError(f"`{method_name}` cannot be called: the environments are in other processes")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Returns true for :class:`Monitor`, whose ``infos[i]["episode"]`` these environments provide, else false."""
        return [issubclass(Monitor, wrapper_class) for _ in self._get_indices(indices)]


def make_sb3_vec(
    building_type: str | BuildingVectorEnv | ActingVectorEnv | None = None,
    num_envs: int = 1,
    *,
    normalize: bool | None = None,
    **arguments: Any,
) -> SB3VecEnv:
    """Makes environments for Stable-Baselines3, with actions in [-1, 1] and observations normalized by fixed bounds.

    Takes the arguments of :func:`make_vec`, or a vector environment with ``autoreset_mode="SameStep"``, such as from
    :meth:`Problem.make_train_vec <building2building.benchmarks.Problem.make_train_vec>`, and no other arguments but
    ``normalize``. ``normalize=False`` leaves observations in physical units. With ``acting``, observations have their
    own scales, and ``normalize`` is an error.
    """
    acts = isinstance(building_type, ActingVectorEnv) or arguments.get("acting") is not None
    if acts and normalize is not None:
        raise SettingError("the observations of acting have their own scales; leave out normalize")
    if not isinstance(building_type, (BuildingVectorEnv, ActingVectorEnv)):
        if not acts:
            arguments.setdefault("rescale_action", True)
        arguments.setdefault("autoreset_mode", "SameStep")
        envs = make_vec(building_type, num_envs, **arguments)
    elif arguments or num_envs not in (1, building_type.num_envs):
        names = ", ".join(["num_envs", *arguments] if num_envs != 1 else arguments)
        raise SettingError(f"the environments are made already, so these arguments have no effect: {names}")
    else:
        envs = cast(BuildingVectorEnv, building_type)
    return SB3VecEnv(envs, not acts if normalize is None else normalize)


def export_onnx(model: Any, path: str | os.PathLike[str]) -> None:
    """Exports the deterministic policy of a trained model to an ONNX file for ``b2b evaluate`` and :func:`evaluate`.

    The file contains the normalization: it maps the environment's observations, ``[1, slots]``, to actions in [-1, 1],
    ``[1, actuators]``. ``model`` must have been trained on :func:`make_sb3_vec` with a policy for flat observations
    (PPO, A2C, SAC, TD3...). Needs ``onnxscript``.
    """
    need("onnxscript", "train")
    import torch

    envs = model.get_env()
    if not isinstance(envs, SB3VecEnv):
        raise SettingError("the model was not trained on environments of make_sb3_vec, so its normalization is unknown")
    if isinstance(envs.envs, ActingVectorEnv):
        raise SettingError("the model supervises or corrects a controller (acting=); ONNX files set actuators")
    if not envs.envs.rescale_action:
        raise SettingError("the model's actions are in physical units; make the environments with rescale_action=True")
    slots = envs.envs.single_observation_space.shape[0]
    actor = _actor(model.policy, envs.scale).to(model.device).eval()
    example = torch.zeros(1, slots, device=model.device)
    with replacing(path) as partial:
        with _quiet_export(), torch.no_grad():
            program = torch.onnx.export(
                actor, (example,), input_names=["observation"], output_names=["action"], dynamo=True, verbose=False
            )
        program.save(partial)


@contextlib.contextmanager
def _quiet_export() -> Iterator[None]:
    """Disables the validation of distributions, which ONNX cannot represent, and the exporter's messages."""
    from torch.distributions import Distribution

    log, checks = logging.getLogger("torch.onnx"), Distribution._validate_args
    level = log.level
    Distribution.set_default_validate_args(False)
    log.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        Distribution.set_default_validate_args(checks)
        log.setLevel(level)


def _actor(policy: Any, scale: Scale | None) -> Any:
    """Returns a torch module that maps an unnormalized observation to an action in [-1, 1]."""
    import torch

    class Actor(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.policy = policy
            if scale is not None:
                self.register_buffer("low", torch.tensor(scale.low))
                self.register_buffer("span", torch.tensor(scale.span))

        def forward(self, observation: Any) -> Any:
            if scale is not None:
                observation = (2 * ((observation - self.low) / self.span) - 1).clamp(-1.0, 1.0)
            return self.policy._predict(observation, deterministic=True).clamp(-1.0, 1.0)

    return Actor()
