"""A native vector environment for Stable-Baselines3."""

from __future__ import annotations

import contextlib
import logging
import os
import warnings
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode

from .errors import SettingError, need

need("stable_baselines3", "train")
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402

from .scaling import Scale  # noqa: E402
from .vector import BuildingVectorEnv, make_vec  # noqa: E402


class SB3VecEnv(VecEnv):
    """Stable-Baselines3's ``VecEnv`` over a :class:`BuildingVectorEnv` that resets in the same step.

    ``infos[i]["terminal_observation"]`` is the last observation of an episode and ``["TimeLimit.truncated"]`` is true,
    so that the value there is bootstrapped; ``["episode"]`` has its return and length for SB3's log.
    """

    def __init__(self, envs: BuildingVectorEnv, normalize: bool = True):
        if envs.autoreset_mode != AutoresetMode.SAME_STEP:
            raise SettingError("Stable-Baselines3 resets in the same step: make with autoreset_mode='SameStep'")
        self.envs = envs
        space = envs.single_observation_space
        self._scale = _scale(envs) if normalize else None
        if self._scale is not None:
            space = self._scale.space
        self._seed: int | None = None
        #: What the last step was judged by, of all environments: made when it is read, so that learners do not pay for
        #: it.
        self.infos: dict[str, Any] = {}
        self._returns = np.zeros(envs.num_envs)
        self._lengths = np.zeros(envs.num_envs, dtype=int)
        self.render_mode = None
        super().__init__(envs.num_envs, space, envs.single_action_space)

    def _seen(self, observations):
        return observations if self._scale is None else self._scale(observations)

    def reset(self):
        observations, _ = self.envs.reset(seed=self._seed)
        self._seed = None
        self._returns[:], self._lengths[:] = 0, 0
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return self._seen(observations)

    def step_async(self, actions):
        self._actions = actions

    def step_wait(self):
        observations, rewards, _, dones, all_infos = self.envs.step(self._actions)
        self._returns += rewards
        self._lengths += 1
        self.infos = all_infos
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for index in np.flatnonzero(dones):
            infos[index] = {
                "terminal_observation": self._seen(all_infos["final_obs"][index][None])[0],
                "TimeLimit.truncated": True,
                "episode": {"r": float(self._returns[index]), "l": int(self._lengths[index]), "t": 0.0},
                "metrics": all_infos["final_info"]["metrics"][index],
            }
            self._returns[index], self._lengths[index] = 0, 0
        return self._seen(observations), rewards.astype(np.float32), dones, infos

    def close(self):
        self.envs.close()

    def seed(self, seed: int | None = None):
        self._seed = seed
        return [seed] * self.num_envs

    def get_attr(self, attr_name, indices=None):
        value = getattr(self.envs, attr_name, None)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name, value, indices=None):
        setattr(self.envs, attr_name, value)

    def env_method(self, method_name, *arguments, indices=None, **options):
        raise NotImplementedError(f"the environments are in other processes: `{method_name}` cannot be called there")

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False for _ in self._get_indices(indices)]


def _scale(envs: BuildingVectorEnv) -> Scale:
    if len({len(each.observation_low) for each in envs.layouts}) > 1:
        raise SettingError("buildings with different observations: normalize=False, and normalise in the policy")
    box = envs.single_observation_space
    return Scale([slot["name"] for slot in envs.layouts[0].data["observation"]], box.low, box.high)


def make_sb3_vec(
    building_type: str | None = None, num_envs: int = 1, *, normalize: bool = True, **arguments
) -> SB3VecEnv:
    """Makes environments for Stable-Baselines3: actions from -1 to 1, observations normalised by fixed bounds.
    Arguments are those of :func:`make_vec`."""
    arguments.setdefault("rescale_action", True)
    return SB3VecEnv(make_vec(building_type, num_envs, autoreset_mode="SameStep", **arguments), normalize)


def export_onnx(model, path: str | os.PathLike) -> None:
    """Writes what a trained model does without exploring as an ONNX file for ``b2b evaluate`` and :func:`evaluate`.

    The file takes observations as the environment has them, ``[1, slots]``, and has their normalisation in it; it gives
    actions from -1 to 1, ``[1, actuators]``. ``model`` was made on :func:`make_sb3_vec`, with a policy that acts on a
    flat observation (PPO, A2C, SAC, TD3...). Needs ``onnxscript``.
    """
    need("onnxscript", "train")
    import torch

    envs = model.get_env()
    if not isinstance(envs, SB3VecEnv):
        raise SettingError("the model is of other environments than make_sb3_vec's: how to normalise is not known")
    if not envs.envs.rescale_action:
        raise SettingError("the model gives physical units: make the environments with rescale_action=True")
    slots = envs.envs.single_observation_space.shape[0]
    acts = _acting(model.policy, envs._scale).to(model.device).eval()
    example = torch.zeros(1, slots, device=model.device)
    aside = f"{os.fspath(path)}.partial"
    try:
        with _quiet_export(), torch.no_grad():
            program = torch.onnx.export(
                acts, (example,), input_names=["observation"], output_names=["action"], dynamo=True, verbose=False
            )
        program.save(aside)
        os.replace(aside, path)
    finally:
        if os.path.exists(aside):
            os.unlink(aside)


@contextlib.contextmanager
def _quiet_export():
    """Without the checks of distributions, which ONNX has no form for, and without the exporter's own words."""
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


def _acting(policy, scale: Scale | None):
    """A torch module from an observation as it is to an action from -1 to 1."""
    import torch

    class Acts(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.policy = policy
            if scale is not None:
                self.register_buffer("low", torch.tensor(scale.low))
                self.register_buffer("span", torch.tensor(scale.span))

        def forward(self, observation):
            if scale is not None:
                observation = (2 * ((observation - self.low) / self.span) - 1).clamp(-1.0, 1.0)
            return self.policy._predict(observation, deterministic=True).clamp(-1.0, 1.0)

    return Acts()
