"""Many buildings as one Gymnasium vector environment."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from . import _core
from .buildings import Building, find_building
from .env import Layout, _inward, _open, resolve
from .errors import EpisodeError, SettingError
from .info import Info


class BuildingVectorEnv(VectorEnv):
    """N environments, each in a process of its own, stepped together; :func:`make_vec` makes one.

    - Observations: f32 ``[N, slots]``; buildings with fewer slots than the largest are padded with zeros.
    - Actions: f32 or f64 ``[N, actuators]``, padded as well; what is behind a building's last actuator is not read.
    - Buildings with different bounds need ``rescale_action=True``, so that they have one action space.
    - Autoreset: ``metadata["autoreset_mode"]``. With ``SAME_STEP``, ``infos["final_obs"]`` and ``["final_info"]`` have
      the end of an episode, as in Gymnasium.
    - An environment whose process dies is truncated; ``infos["lost"]`` says why, and the next episode begins as after
      any other.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        building_type: str | None = None,
        num_envs: int = 1,
        *,
        split: str = "train",
        index: int | None = None,
        building_id: str | None = None,
        building: Building | None = None,
        buildings: Sequence[Building | str] | None = None,
        resample: bool = False,
        place: str | None = None,
        weather: str | os.PathLike | None = None,
        task: str | dict = "constant",
        run_period: str = "winter",
        timesteps_per_hour: int = 12,
        rescale_action: bool = False,
        window_days: int | None = None,
        window_starts: int = 8,
        reward: Callable[[dict[str, Any]], np.ndarray] | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ):
        self._core = None
        if render_mode is not None:
            raise SettingError("a vector environment draws no pictures: make one environment with render_mode")
        if num_envs < 1:
            raise SettingError(f"num_envs is {num_envs}: a vector environment needs at least one")
        if buildings is None:
            buildings = [resolve(building_type, split, index, building_id, place, weather, building)]
        self.buildings = [each if isinstance(each, Building) else find_building(each) for each in buildings]
        task = json.dumps(task) if isinstance(task, dict) else str(task)
        self._settings = [_core.Setting(each._core, run_period, timesteps_per_hour, task) for each in self.buildings]
        self.num_envs = num_envs
        self.render_mode = None
        self.rescale_action = rescale_action
        self.autoreset_mode = _mode(autoreset_mode)
        self._reward = reward
        window = None if window_days is None else (window_days, window_starts)
        self._process = os.getpid()
        self._core = _core.VecEnv(self._settings, num_envs, self.autoreset_mode.value, rescale_action, resample, window)
        _open.add(self)
        self.layouts = [Layout(spaces) for spaces in self._core.spaces()]
        self._fixed = not resample
        self.single_observation_space = _padded_box(
            [
                (each.observation_low.astype(np.float32), each.observation_high.astype(np.float32))
                for each in self.layouts
            ]
        )
        if rescale_action:
            width = max(len(each.action_low) for each in self.layouts)
            self.single_action_space = gymnasium.spaces.Box(-1.0, 1.0, (width,), dtype=np.float32)
        else:
            bounds = [_inward(each.action_low, each.action_high) for each in self.layouts]
            same = all(len(bounds[0][0]) == len(b[0]) and np.array_equal(bounds[0], b) for b in bounds)
            if not same:
                raise SettingError(
                    "these buildings differ in actuators or bounds: rescale_action=True gives them one action space"
                )
            self.single_action_space = gymnasium.spaces.Box(*bounds[0], dtype=np.float32)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.metadata = {
            **type(self).metadata,
            "autoreset_mode": self.autoreset_mode,
            **(self.layouts[0].metadata() if len(self.layouts) == 1 else {}),
            "buildings": [each.name for each in self.buildings],
        }
        self._before = None
        self._over = np.zeros(num_envs, dtype=bool)

    def layout_of(self, environment: int) -> Layout:
        """Where is what in the row of an environment, as it runs now."""
        if self._fixed:
            return self.layouts[environment % len(self.layouts)]
        name = self._core.buildings()[environment]
        return next(each for each in self.layouts if each.data["name"] == name)

    def reset(self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None):
        """Begins an episode in every environment; with ``options={"reset_mask": mask}`` in some.

        ``seed`` drives what is drawn: buildings with ``resample``, days with ``window_days``.
        """
        mask = (options or {}).get("reset_mask")
        if mask is not None:
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
                raise SettingError(f"reset_mask must be {self.num_envs} booleans, of which one is true")
            observations = self._core_here().reset_some([int(i) for i in np.flatnonzero(mask)])
            self._over[mask] = False
        else:
            if seed is None:
                number = int(np.random.SeedSequence().generate_state(1, np.uint64)[0])
            elif isinstance(seed, (int, np.integer)):
                self._np_random, self._np_random_seed = gymnasium.utils.seeding.np_random(int(seed))
                number = int(seed) % 2**64
            else:
                given = [0 if each is None else int(each) for each in seed]
                number = int(np.random.SeedSequence(given).generate_state(1, np.uint64)[0])
            observations = self._core_here().reset(number)
            self._over[:] = False
        self._before = observations
        return observations, Info(lambda: {"building": np.array(self._core.buildings(), dtype=object)})

    def _core_here(self):
        if self._core is None:
            raise EpisodeError("the environments are closed")
        return self._core

    def step(self, actions):
        """One step of every environment."""
        observations, rewards, penalties, truncated = self._core_here().step(actions)
        before, self._before = self._before, observations
        began, self._over = self._over, truncated
        if truncated.any():
            info = Info()
            info.update(self._judged(before, observations, penalties, truncated))
            self._add_ends(info, truncated)
        else:
            info = Info(lambda: self._judged(before, observations, penalties, truncated))
        if self._reward is not None:
            rewards = np.where(began, 0.0, np.asarray(self._reward(info), dtype=np.float64))
        return observations, rewards, np.zeros(self.num_envs, dtype=bool), truncated.copy(), info

    def _judged(self, before, after, penalties, truncated) -> dict[str, Any]:
        """What the steps were judged by; of a row that is already the next episode's, its last observation's."""
        after = np.array(after, dtype=np.float64)
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            for environment in np.flatnonzero(truncated):
                last = self._core.ended(int(environment))[0]
                after[environment, : len(last)] = last
        info: dict[str, Any] = {
            "reward_terms": {"temperature": -penalties[:, 0], "energy": -penalties[:, 1]},
            "observation": after,
        }
        if len(self.layouts) == 1:
            layout = self.layouts[0]
            temperatures, targets = after[:, layout.temperatures], layout.targets_in(before)
            info["energy"] = {"electricity": after[:, layout.electricity], "gas": after[:, layout.gas]}
            info["zone_temperature"], info["zone_target"] = temperatures, targets
            info["zone_deviation"] = temperatures - targets
        return info

    def _add_ends(self, info: Info, truncated: np.ndarray) -> None:
        """The ends of episodes, as Gymnasium's vector environments tell them."""
        metrics = np.full(self.num_envs, None, dtype=object)
        finals = np.full(self.num_envs, None, dtype=object)
        lost = np.full(self.num_envs, None, dtype=object)
        for environment in np.flatnonzero(truncated):
            last, sums, why = self._core.ended(int(environment))
            row = np.zeros(self.single_observation_space.shape, dtype=np.float32)
            row[: len(last)] = last
            metrics[environment], finals[environment], lost[environment] = sums, row, why
        if any(why is not None for why in lost):
            info["lost"], info["_lost"] = lost, np.array([why is not None for why in lost])
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            info["final_obs"], info["_final_obs"] = finals, truncated.copy()
            info["final_info"] = {"metrics": metrics, "_metrics": truncated.copy()}
            info["_final_info"] = truncated.copy()
        else:
            info["metrics"], info["_metrics"] = metrics, truncated.copy()

    def close_extras(self, **_) -> None:
        """Ends all processes."""
        core, self._core = getattr(self, "_core", None), None
        if core is not None and os.getpid() == self._process:
            core.close()

    def __del__(self):
        try:
            self.close_extras()
        except Exception:  # the interpreter may be half gone
            pass


def _mode(given: str | AutoresetMode) -> AutoresetMode:
    if isinstance(given, AutoresetMode):
        return given
    for mode in AutoresetMode:
        if str(given).replace("_", "").lower() == mode.value.lower():
            return mode
    raise SettingError(f"there is no autoreset mode `{given}`: give {', '.join(mode.value for mode in AutoresetMode)}")


def _padded_box(bounds) -> gymnasium.spaces.Box:
    """Room for each of these: padding is 0."""
    width = max(len(low) for low, _ in bounds)
    low, high = np.full(width, np.inf, np.float32), np.full(width, -np.inf, np.float32)
    for each_low, each_high in bounds:
        padding = width - len(each_low)
        low = np.minimum(low, np.pad(each_low, (0, padding)))
        high = np.maximum(high, np.pad(each_high, (0, padding)))
    return gymnasium.spaces.Box(low, high, dtype=np.float32)


def make_vec(building_type: str | None = None, num_envs: int = 1, **arguments) -> BuildingVectorEnv:
    """Makes a vector environment. Arguments are those of :func:`make_env`, and these.

    - ``buildings``: several, as :class:`Building` or ids; environment i runs the i-th over and over, or with
      ``resample=True`` every episode is any of them.
    - ``autoreset_mode``: ``NextStep`` (Gymnasium's default), ``SameStep`` or ``Disabled``.
    """
    if building_type is None:
        return BuildingVectorEnv(None, num_envs, **arguments)
    from .env import _type_name

    return gymnasium.make_vec(
        f"b2b/{_type_name(building_type)}-v0", num_envs=num_envs, **{"rescale_action": False, **arguments}
    )
