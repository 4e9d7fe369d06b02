"""A batch of buildings as a Gymnasium vector environment."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from . import _core
from .buildings import Building, PathLike, find_building, select_building
from .errors import EpisodeError, SettingError
from .info import Info
from .layout import Layout
from .open_envs import close_at_exit

Array = NDArray[Any]


class BuildingVectorEnv(VectorEnv[Any, Any, Any]):
    """N environments stepped together, each in its own process; :func:`make_vec` makes one.

    - Observations: f32 ``[N, slots]``, padded with zeros to the width of the largest building.
    - Actions: f32 or f64 ``[N, actuators]``, padded as well; padding is not read.
    - Buildings with different bounds need ``rescale_action=True``, which gives them one action space.
    - Autoreset: ``metadata["autoreset_mode"]``. With ``SAME_STEP``, ``infos["final_obs"]`` and ``infos["final_info"]``
      describe the end of an episode, as in Gymnasium.
    - An environment whose process dies is truncated; ``infos["lost"]`` has the reason, and the next episode begins as
      after any other.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}
    single_observation_space: Box
    single_action_space: Box

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
        weather: PathLike | None = None,
        task: str | dict[str, Any] = "constant",
        run_period: str = "winter",
        timesteps_per_hour: int = 12,
        rescale_action: bool = False,
        window_days: int | None = None,
        window_starts: int = 8,
        reward: Callable[[dict[str, Any]], ArrayLike] | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ):
        self._core: _core.VecEnv | None = None
        if render_mode is not None:
            raise SettingError("a vector environment cannot render; make a single environment with render_mode")
        if num_envs < 1:
            raise SettingError(f"num_envs is {num_envs}; expected 1 or more")
        if buildings is None:
            buildings = [select_building(building_type, split, index, building_id, place, weather, building)]
        self.buildings = [each if isinstance(each, Building) else find_building(each) for each in buildings]
        task = json.dumps(task) if isinstance(task, dict) else str(task)
        settings = [_core.Setting(each._core, run_period, timesteps_per_hour, task) for each in self.buildings]
        self.num_envs = num_envs
        self.render_mode = None
        self.rescale_action = rescale_action
        self.autoreset_mode = _autoreset_mode(autoreset_mode)
        self._reward = reward
        window = None if window_days is None else (window_days, window_starts)
        self._process = os.getpid()
        self._core = _core.VecEnv(settings, num_envs, self.autoreset_mode.value, rescale_action, resample, window)
        close_at_exit(self)
        self.layouts = [Layout(spaces) for spaces in self._core.spaces()]
        self._resample = resample
        self.single_observation_space = _padded_box([each.observation_bounds() for each in self.layouts])
        self.single_action_space = _action_space(self.layouts, rescale_action)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.metadata = {
            **type(self).metadata,
            "autoreset_mode": self.autoreset_mode,
            **(self.layouts[0].metadata() if len(self.layouts) == 1 else {}),
            "buildings": [each.name for each in self.buildings],
        }
        self._observations = np.zeros(self.observation_space.shape or (), dtype=np.float32)
        self._done = np.zeros(num_envs, dtype=bool)

    def layout_of(self, environment: int) -> Layout:
        """Returns the layout of the building that an environment runs now."""
        if not self._resample:
            return self.layouts[environment % len(self.layouts)]
        name = self._open_core().buildings()[environment]
        return next(each for each in self.layouts if each.spaces.name == name)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begins an episode in every environment, or with ``options={"reset_mask": mask}`` in some.

        ``seed`` determines the buildings with ``resample`` and the days with ``window_days``.
        """
        core = self._open_core()
        mask = (options or {}).get("reset_mask")
        if mask is not None:
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
                raise SettingError(
                    f"reset_mask must be an array of {self.num_envs} booleans, at least one of them true"
                )
            observations = core.reset_some([int(i) for i in np.flatnonzero(mask)])
            self._done[mask] = False
        else:
            observations = core.reset(self._episode_seed(seed))
            self._done[:] = False
        self._observations = observations
        return observations, Info(lambda: {"building": np.array(core.buildings(), dtype=object)})

    def _episode_seed(self, seed: int | Sequence[int | None] | None) -> int:
        if isinstance(seed, (int, np.integer)):
            self._np_random, self._np_random_seed = gymnasium.utils.seeding.np_random(int(seed))
            return int(seed) % 2**64
        given = None if seed is None else [0 if each is None else int(each) for each in seed]
        return int(np.random.SeedSequence(given).generate_state(1, np.uint64)[0])

    def _open_core(self) -> _core.VecEnv:
        if self._core is None:
            raise EpisodeError("the environments are closed")
        return self._core

    def step(self, actions: ArrayLike) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Runs one step of every environment."""
        observations, rewards, penalties, truncated = self._open_core().step(actions)
        before, self._observations = self._observations, observations
        reset, self._done = self._done, truncated
        if truncated.any():
            info = Info()
            info.update(self._step_info(before, observations, penalties, truncated))
            self._add_final_info(info, truncated)
        else:
            info = Info(lambda: self._step_info(before, observations, penalties, truncated))
        if self._reward is not None:
            # The step after an episode only resets; Gymnasium gives it no reward.
            rewards = np.where(reset, 0.0, np.asarray(self._reward(info), dtype=np.float64))
        return observations, rewards, np.zeros(self.num_envs, dtype=bool), truncated.copy(), info

    def _step_info(self, before: Array, after: Array, penalties: Array, truncated: Array) -> dict[str, Any]:
        """Computes the info of a step. Where the next episode has begun, it describes the one that ended."""
        after = np.array(after, dtype=np.float64)
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            core = self._open_core()
            for environment in np.flatnonzero(truncated):
                final = core.ended(int(environment))[0]
                after[environment, : len(final)] = final
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

    def _add_final_info(self, info: Info, truncated: Array) -> None:
        """Adds the ends of episodes in the layout of Gymnasium's vector environments."""
        core = self._open_core()
        metrics = np.full(self.num_envs, None, dtype=object)
        final_obs = np.full(self.num_envs, None, dtype=object)
        lost = np.full(self.num_envs, None, dtype=object)
        for environment in np.flatnonzero(truncated):
            final, episode_metrics, reason = core.ended(int(environment))
            row = np.zeros(self._observations.shape[1:], dtype=np.float32)
            row[: len(final)] = final
            metrics[environment], final_obs[environment], lost[environment] = episode_metrics, row, reason
        if any(reason is not None for reason in lost):
            info["lost"], info["_lost"] = lost, np.array([reason is not None for reason in lost])
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            info["final_obs"], info["_final_obs"] = final_obs, truncated.copy()
            info["final_info"] = {"metrics": metrics, "_metrics": truncated.copy()}
            info["_final_info"] = truncated.copy()
        else:
            info["metrics"], info["_metrics"] = metrics, truncated.copy()

    def close_extras(self, **_: Any) -> None:
        """Ends all processes."""
        core, self._core = getattr(self, "_core", None), None
        if core is not None and os.getpid() == self._process:
            core.close()

    def __del__(self) -> None:
        try:
            self.close_extras()
        except Exception:  # modules may be gone while the interpreter exits
            pass


def _autoreset_mode(given: str | AutoresetMode) -> AutoresetMode:
    if isinstance(given, AutoresetMode):
        return given
    for mode in AutoresetMode:
        if str(given).replace("_", "").lower() == mode.value.lower():
            return mode
    expected = ", ".join(mode.value for mode in AutoresetMode)
    raise SettingError(f"unknown autoreset_mode `{given}`; expected one of {expected}")


def _action_space(layouts: list[Layout], rescale: bool) -> Box:
    """Returns the action space that all buildings share."""
    if rescale:
        return Box(-1.0, 1.0, (max(len(each.action_low) for each in layouts),), dtype=np.float32)
    low, high = layouts[0].action_bounds()
    for each in layouts:
        if not (np.array_equal(each.action_bounds()[0], low) and np.array_equal(each.action_bounds()[1], high)):
            raise SettingError(
                "the buildings differ in actuators or bounds; pass rescale_action=True for one action space"
            )
    return Box(low, high, dtype=np.float32)


def _padded_box(bounds: list[tuple[Array, Array]]) -> Box:
    """Returns the smallest box that contains these boxes padded with zeros."""
    width = max(len(low) for low, _ in bounds)
    low, high = np.full(width, np.inf, np.float32), np.full(width, -np.inf, np.float32)
    for each_low, each_high in bounds:
        padding = width - len(each_low)
        low = np.minimum(low, np.pad(each_low, (0, padding)))
        high = np.maximum(high, np.pad(each_high, (0, padding)))
    return Box(low, high, dtype=np.float32)
