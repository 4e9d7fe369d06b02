"""A batch of buildings as a Gymnasium vector environment."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..buildings import (
    Building,
    Generator,
    PathLike,
    as_building,
    check_type,
    checked_weather,
    is_dataset_id,
    list_buildings,
    select_building,
)
from ..env.info import Info
from ..env.layout import Layout, rounded_inward
from ..env.open_envs import close_at_exit
from ..env.tasks import check_count, task_text, windows
from ..errors import EpisodeError, ProcessError, SettingError
from ..scaling import Scale
from .info import Row, reward_terms, step_info

Array = NDArray[Any]
_Task = str | dict[str, Any]


class BuildingVectorEnv(VectorEnv[Array, ArrayLike, Array]):
    """N environments stepped together, each in its own process; :func:`make_vec` makes one.

    - Observations: f32 ``[N, slots]``, padded with zeros to the width of the largest building; with ``normalize=True``
      in [-1, 1] by fixed bounds (:attr:`scale`).
    - Actions: f32 or f64 ``[N, actuators]``, padded as well; padding is not read. :meth:`observation_mask` and
      :meth:`action_mask` mark what is not padding.
    - Buildings with different bounds, which drawn buildings have unless ``control`` is ``setpoints``, need
      ``rescale_action=True``, which gives them one action space.
    - With ``resample``, the building of every environment's next episode is prepared while the current episode runs, so
      that hundreds of buildings take the memory of a few. Which buildings an environment runs depends on the seed
      alone; if the next is not ready in time, the environment waits (:attr:`statistics`).
    - Infos: the infos of :class:`BuildingEnv` as arrays with a row per environment, computed when they are read.
      Columns of zones that a building does not have are NaN. ``step`` is 0 where an episode has just begun; then
      ``weather`` and ``first_day`` are those of the new episodes, which ``_weather`` and ``_first_day`` mark.
    - Autoreset: ``metadata["autoreset_mode"]``. With ``SAME_STEP``, ``infos["final_obs"]`` and ``infos["final_info"]``
      describe the end of an episode, as in Gymnasium; ``infos["_final_info"]`` marks the rows that have ended.
    - An environment whose process dies is truncated; ``infos["lost"]`` has the reason, and the next episode begins as
      after any other.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}
    single_observation_space: Box
    single_action_space: Box
    #: Whether all buildings have one action space.
    _shares_actions = True

    def __init__(
        self,
        building_type: str | None = None,
        num_envs: int = 1,
        *,
        split: str | None = None,
        index: int | None = None,
        building_id: str | None = None,
        building: Building | None = None,
        buildings: Sequence[Building | Generator | str] | None = None,
        resample: bool | int = False,
        weights: dict[str, float] | None = None,
        place: str | None = None,
        weather: PathLike | None = None,
        control: str = "actuators",
        task: _Task | Sequence[_Task] = "operate",
        run_period: str = "winter",
        timesteps_per_hour: int = 12,
        rescale_action: bool = False,
        normalize: bool = False,
        by_role: bool = False,
        window_days: int | None = None,
        window_starts: int | None = None,
        weather_years: Sequence[PathLike] = (),
        reward: Callable[[dict[str, Any]], ArrayLike] | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        problem: _core.Problem | None = None,
    ):
        self._core: _core.VecEnv | None = None
        _check(num_envs, reward, render_mode)
        if weights is not None and not resample:
            raise SettingError("weights apply to draws; pass resample=True")
        selection = {"split": split, "index": index, "building_id": building_id, "building": building}
        where = {"place": place, "weather": weather, "control": control}
        count = None if resample else num_envs
        #: Buildings that environments repeat; with ``resample``, the buildings to draw from.
        self.buildings = _candidates(building_type, buildings, selection, where, count)
        if buildings is not None and count is not None and len(buildings) > count:
            remedy = f"pass num_envs={len(buildings)}, or resample=True to draw buildings"
            raise SettingError(f"{len(buildings)} buildings for {count} environments, which repeat theirs; {remedy}")
        if resample and not rescale_action and self._shares_actions and _may_differ(self.buildings, control):
            raise SettingError(_DIFFERENT)
        tasks = [task] if isinstance(task, (str, dict)) else list(task)
        if count is not None and problem is None and len(tasks) > 1 and len(self.buildings) * len(tasks) > count:
            remedy = f"pass num_envs={len(self.buildings) * len(tasks)}, or resample=True to draw tasks"
            raise SettingError(
                f"{len(tasks)} tasks in {len(self.buildings)} buildings for {count} environments, which repeat theirs; "
                f"{remedy}"
            )
        check_count("timesteps_per_hour", timesteps_per_hour)
        self.num_envs = num_envs
        self.render_mode = None
        self.rescale_action = rescale_action
        self.normalize = normalize
        self.autoreset_mode = _autoreset_mode(autoreset_mode)
        self._reward = reward
        self._process = os.getpid()
        self._make_core = partial(
            _core.VecEnv,
            [each if isinstance(each, str) else each._core for each in self.buildings],
            [task_text(each) for each in tasks],
            run_period,
            timesteps_per_hour,
            num_envs,
            self.autoreset_mode.value,
            rescale_action,
            int(resample) or None,
            weights,
            windows(window_days, window_starts),
            problem,
            by_role,
            checked_weather(weather_years),
            control,
        )
        self._core = self._make_core()
        close_at_exit(self)
        self._resample = bool(resample)
        self._steps_per_hour = timesteps_per_hour
        self._by_role = by_role
        self._read_spaces(self._core)
        if by_role and problem is None and all(each.spaces.roles is None for each in self.layouts):
            raise SettingError(_NO_ROLES)
        self._begun = False

    def _read_spaces(self, core: _core.VecEnv) -> None:
        """Reads the spaces of the core's buildings, and makes the arrays of a step."""
        #: Layouts of the buildings; with ``resample``, of a few representative ones.
        self.layouts = [Layout(spaces) for spaces in core.spaces()]
        slots, actuators = core.slots(), core.actuators()
        #: Fixed bounds by which observations are normalized. They cover everything that a slot of the row may hold.
        self.scale = Scale.of_all(slots, self._steps_per_hour)
        self._plain = len(slots) == 1 and not self._by_role
        bounds = np.array([[_bounds(*slot) for slot in row] for row in slots], dtype=np.float32)
        box = Box(bounds[..., 0].min(axis=0), bounds[..., 1].max(axis=0), dtype=np.float32)
        self.single_observation_space = self.scale.space if self.normalize else box
        if self._shares_actions:
            self.single_action_space = _action_space(actuators, core.widths[0], self.rescale_action)
        else:
            self.single_action_space = Box(-np.inf, np.inf, (core.widths[0],), dtype=np.float32)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.metadata = {
            **type(self).metadata,
            "autoreset_mode": self.autoreset_mode,
            **(self.layouts[0].metadata() if self._plain else {}),
            "buildings": [each if isinstance(each, str) else each.name for each in self.buildings],
        }
        if self._plain:
            self.metadata["observation_names"] = [name for name, _, _ in slots[0]]
            self.metadata["action_names"] = [name for name, _, _ in actuators[0]]
            self.metadata["observation_units"], self.metadata["action_units"] = core.units()
        #: Number of steps done in every environment's episode.
        self._steps = np.zeros(self.num_envs, dtype=int)
        self._rows = [Row(self.layouts[i % len(self.layouts)].spaces, self._by_role) for i in range(self.num_envs)]
        self._observations = np.zeros(self.observation_space.shape or (), dtype=np.float32)
        self._done = np.zeros(self.num_envs, dtype=bool)

    def layout_of(self, environment: int) -> Layout:
        """Returns the layout of the building that an environment runs now; before the first episode, of one like it."""
        return self._rows[environment].layout

    @property
    def statistics(self) -> dict[str, Any]:
        """Numbers of ``episodes``, of ``building_changes``, of ``waits`` for a building that was not ready when its
        episode was due to begin, and the total time of these waits (``waited``, s)."""
        return dict(zip(("episodes", "building_changes", "waits", "waited"), self._open_core().statistics()))

    def observation_mask(self) -> Array:
        """Mask of the observations, ``[N, slots]``: ``False`` for padding."""
        return np.array(self._open_core().masks()[0])

    def action_mask(self) -> Array:
        """Mask of the actions, ``[N, actuators]``: ``False`` for numbers that are not read."""
        return np.array(self._open_core().masks()[1])

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begins an episode in every environment, or with ``options={"reset_mask": mask}`` in some.

        ``seed`` determines the buildings with ``resample`` and the days with ``window_days``. A list with a
        number per environment is used as one seed. ``info`` has the name of the building, the weather file and the
        first day (of a year without 29 February, from 1) of every environment.
        """
        self._open_core()
        if unknown := set(options or {}) - {"reset_mask"}:
            raise SettingError(f"unknown options of reset: {', '.join(map(str, sorted(unknown)))}; expected reset_mask")
        number = self._seed_number(seed)
        mask = (options or {}).get("reset_mask")
        if os.getpid() != self._process:
            self._restart_after_fork(mask)
        core = self._open_core()
        if mask is not None:
            self._check_begun()
            if number is not None:
                raise SettingError("a seed applies to all environments; omit seed or reset_mask")
            mask = np.asarray(mask)
            if mask.shape != (self.num_envs,) or mask.dtype != np.bool_ or not mask.any():
                raise SettingError(
                    f"reset_mask must be an array of {self.num_envs} booleans, at least one of them true"
                )
            observations = core.reset_some([int(i) for i in np.flatnonzero(mask)])
            self._done[mask], self._steps = False, np.where(mask, 0, self._steps)
        else:
            observations = core.reset(self._episode_seed(number))
            self._done[:], self._steps = False, np.zeros_like(self._steps)
            self._begun = True
        self._observations = observations
        self._read_rows(np.ones(self.num_envs, dtype=bool) if mask is None else mask)
        return self._seen(observations), self._episodes()

    def _episodes(self) -> dict[str, Array]:
        """Returns what identifies the episode of each environment."""
        buildings, weather, days = zip(*self._open_core().episodes(), strict=True)
        names = {"building": np.array(buildings, dtype=object), "weather": np.array(weather, dtype=object)}
        return {**names, "first_day": np.array(days)}

    def _restart_after_fork(self, mask: Any) -> None:
        """Abandons the processes of the parent, which still owns them, and starts new ones."""
        if mask is not None:
            raise ProcessError("after a fork, the first reset must be of all environments; omit reset_mask")
        self._core, self._process = self._make_core(), os.getpid()

    def _read_rows(self, begun: Array) -> None:
        """Reads the rows of the environments whose episode has begun."""
        if self._resample:
            core = self._open_core()
            self._rows = [
                Row(core.spaces_of(environment), self._by_role) if begun[environment] else row
                for environment, row in enumerate(self._rows)
            ]

    def _seen(self, observations: Array) -> Array:
        """Returns observations for the user, who may change them."""
        return self.scale(observations) if self.normalize else observations.copy()

    def _seed_number(self, seed: int | Sequence[int | None] | None) -> int | None:
        """Returns the seed as one number; ``None`` without."""
        if seed is None:
            return None
        if isinstance(seed, (int, np.integer)):
            return int(seed)
        if len(seed) != self.num_envs:
            raise SettingError(f"seed has {len(seed)} numbers; expected one, or {self.num_envs}")
        if all(each is None for each in seed):
            return None
        given = [0 if each is None else int(each) for each in seed]
        return int(np.random.SeedSequence(given).generate_state(1, np.uint64)[0])

    def _episode_seed(self, seed: int | None) -> int:
        """Returns the seed of the episodes that begin; without a number, draws it."""
        if seed is None:
            return int(self.np_random.integers(2**64, dtype=np.uint64))
        self._np_random, self._np_random_seed = gymnasium.utils.seeding.np_random(seed)
        return seed % 2**64

    def __reduce__(self) -> tuple[Any, ...]:
        raise ProcessError("a batch runs processes of this one; make it again in the other process")

    def _check_begun(self) -> None:
        if not self._begun:
            raise EpisodeError("no episode is in progress; call reset of all environments first")

    def _open_core(self) -> _core.VecEnv:
        if self._core is None:
            raise EpisodeError("the environments are closed")
        return self._core

    def step(self, actions: ArrayLike) -> tuple[Array, Array, Array, Array, dict[str, Any]]:
        """Runs one step of every environment."""
        core = self._open_core()
        self._check_begun()
        observations, rewards, numbers, truncated = core.step(actions)
        before, self._observations = self._observations, observations
        reset, self._done = self._done, truncated
        self._steps = np.where(reset & (self.autoreset_mode == AutoresetMode.NEXT_STEP), 0, self._steps + 1)
        if reset.any() and self.autoreset_mode == AutoresetMode.NEXT_STEP:
            self._read_rows(reset)
        rows, steps = self._rows, self._steps
        if truncated.any():
            info = Info()
            at_end = self._at_end(observations, truncated)
            info.update(step_info(rows, before, at_end, numbers, steps, self._steps_per_hour))
            self._add_final_info(info, truncated)
            if self.autoreset_mode == AutoresetMode.SAME_STEP:
                if "lost" in info:
                    observations = self._begin_after_lost(info["_lost"])
                self._read_rows(truncated)
                self._steps = np.where(truncated, 0, steps)
                self.add_begun(info, truncated)
        else:
            info = Info(lambda: step_info(rows, before, observations, numbers, steps, self._steps_per_hour))
            info["step"] = steps.copy()
            if self._reward is not None:
                # Most rewards read only these.
                info["reward_terms"] = reward_terms(numbers)
        if reset.any() and self.autoreset_mode == AutoresetMode.NEXT_STEP:
            self.add_begun(info, reset)
        if self._reward is not None:
            rewards = np.asarray(self._reward(info), dtype=np.float64)
            if rewards.shape != (self.num_envs,):
                raise SettingError(
                    f"reward returned an array of the shape {rewards.shape}; expected ({self.num_envs},), a value for "
                    "every environment, such as by .mean(axis=-1)"
                )
            if self.autoreset_mode == AutoresetMode.NEXT_STEP:
                # The step after an episode only resets; Gymnasium gives it no reward.
                rewards = np.where(reset, 0.0, rewards)
        terminated = np.zeros(self.num_envs, dtype=bool)
        return self._seen(observations), rewards, terminated, truncated.copy(), info

    def add_begun(self, info: dict[str, Any], begun: Array) -> None:
        """Adds the weather files and first days of the episodes that have begun."""
        episodes = self._episodes()
        for name in ("weather", "first_day"):
            info[name], info[f"_{name}"] = episodes[name], begun.copy()

    def _begin_after_lost(self, lost: Array) -> Array:
        """Begins the episodes after those that were lost, and returns the observations.

        The core leaves this to the next step. An episode that is lost again is reported there.
        """
        for environment in np.flatnonzero(lost):
            with suppress(EpisodeError):
                self._observations = self._open_core().reset_some([int(environment)])
        return self._observations

    def _at_end(self, observations: Array, truncated: Array) -> Array:
        """Returns the observations; where the next episode has begun, the last one of the previous episode."""
        if self.autoreset_mode != AutoresetMode.SAME_STEP:
            return observations
        core, observations = self._open_core(), np.array(observations, dtype=np.float64)
        for environment in np.flatnonzero(truncated):
            final = core.ended(int(environment))[0]
            observations[environment, : len(final)] = final
        return observations

    def _add_final_info(self, info: Info, truncated: Array) -> None:
        """Adds the ends of episodes in the layout of Gymnasium's vector environments."""
        core, step = self._open_core(), info.copy()
        metrics = np.full(self.num_envs, None, dtype=object)
        final_obs = np.full(self.num_envs, None, dtype=object)
        lost = np.full(self.num_envs, None, dtype=object)
        for environment in np.flatnonzero(truncated):
            final, episode_metrics, reason = core.ended(int(environment))
            row = np.zeros(self._observations.shape[1:], dtype=np.float32)
            row[: len(final)] = final
            metrics[environment], lost[environment] = episode_metrics, reason
            final_obs[environment] = self._seen(row)
        if any(reason is not None for reason in lost):
            info["lost"], info["_lost"] = lost, np.array([reason is not None for reason in lost])
        if self.autoreset_mode == AutoresetMode.SAME_STEP:
            info["final_obs"], info["_final_obs"] = final_obs, truncated.copy()
            final_info = {**step, "metrics": metrics}
            info["final_info"] = final_info | {f"_{name}": truncated.copy() for name in final_info}
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


def _check(num_envs: int, reward: Callable[[dict[str, Any]], ArrayLike] | None, render_mode: str | None) -> None:
    """Raises an error for the first argument that is invalid."""
    if render_mode is not None:
        raise SettingError("a vector environment cannot render; make a single environment with render_mode")
    if reward is not None and not callable(reward):
        raise SettingError(f"reward is {reward!r}; expected a function of a step's info")
    if not isinstance(num_envs, int | np.integer) or num_envs < 1:
        raise SettingError(f"num_envs is {num_envs!r}; expected a number from 1 on")


def _autoreset_mode(given: str | AutoresetMode) -> AutoresetMode:
    if isinstance(given, AutoresetMode):
        return given
    for mode in AutoresetMode:
        if str(given).replace("_", "").lower() == mode.value.lower():
            return mode
    expected = ", ".join(mode.value for mode in AutoresetMode)
    raise SettingError(f"unknown autoreset_mode `{given}`; expected one of {expected}")


def _bounds(name: str, low: float, high: float) -> tuple[float, float]:
    """Returns the bounds of a slot. A building's attributes have only typical bounds, for scaling."""
    return (-np.inf, np.inf) if name.startswith("building ") else (low, high)


def _candidates(
    building_type: str | None,
    buildings: Sequence[Building | Generator | str] | None,
    selection: dict[str, Any],
    where: dict[str, Any],
    count: int | None,
) -> list[Building | Generator | str]:
    """Returns the buildings that the arguments of :func:`make_vec` select: ``count`` at most, or those to draw from.

    ``selection`` and ``where`` are the arguments that :func:`make_env` has, too.
    """
    chosen = [name for name, value in selection.items() if value is not None]
    if buildings is None and count is None and building_type is not None and chosen in ([], ["split"]):
        buildings, chosen = list_buildings(building_type, selection["split"] or "train"), []
    if buildings is None:
        return [select_building(building_type, **selection, **where)]
    if not buildings:
        raise SettingError("buildings is empty; pass at least one")
    if chosen:
        raise SettingError(f"`buildings` selects all buildings; omit {' and '.join(chosen)}")
    return [_candidate(each, building_type, where, count is None) for each in buildings[:count]]


def _candidate(
    given: Building | Generator | str, building_type: str | None, where: dict[str, Any], draws: bool
) -> Building | Generator | str:
    """Returns a building; if buildings are drawn, an id stays an id until then."""
    if isinstance(given, Generator) or (draws and isinstance(given, str) and is_dataset_id(given)):
        if not draws:
            raise SettingError("a generator has no fixed building; pass resample=True")
        if where["place"] is not None or where["weather"] is not None:
            name = given if isinstance(given, str) else given.name
            remedy = "omit place and weather, or pass buildings=[Generator(..., places=...)]"
            raise SettingError(f"{name} is drawn at its own place; {remedy}")
    else:
        given = as_building(given, **where)
    check_type(given, building_type)
    return given


def _may_differ(buildings: list[Building | Generator | str], control: str) -> bool:
    """Returns whether drawn buildings may have different bounds of actions.

    The actuators of each are sized for it; setpoints have the same bounds everywhere.
    """
    sized = any((each.control if isinstance(each, Building) else control) == "actuators" for each in buildings)
    return sized and (len(buildings) > 1 or isinstance(buildings[0], Generator))


_NO_ROLES = "by_role gives slots to the zones of the generator's houses in tasks without bands; there are none here"
_DIFFERENT = "the buildings differ in actuators or bounds; pass rescale_action=True for one action space"


def _action_space(actuators: list[list[tuple[str, float, float]]], width: int, rescale: bool) -> Box:
    """Returns the action space that all buildings share."""
    if rescale:
        return Box(-1.0, 1.0, (width,), dtype=np.float32)
    bounds = [[(low, high) for _, low, high in row] for row in actuators]
    if any(each != bounds[0] for each in bounds):
        raise SettingError(_DIFFERENT)
    low, high = rounded_inward(*np.array(bounds[0], dtype=np.float64).T)
    return Box(low, high, dtype=np.float32)
