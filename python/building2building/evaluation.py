"""A policy on many buildings, against the reactive controllers."""

from __future__ import annotations

import copy
import json
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import _core
from .buildings import Building
from .env import Layout, action_box, observation_box
from .errors import SettingError
from .morphology import Morphology
from .rollouts import Controller, _BuiltIn, _Callable
from .scaling import Scale


@dataclass
class Evaluation:
    """What :func:`evaluate` found."""

    #: A dictionary an episode, in the order asked for, with the columns of ``episodes.parquet`` (docs/evaluation.md).
    rows: list[dict[str, Any]]
    #: Interquartile means and intervals, by task, run period and type: what ``b2b evaluate --json`` prints.
    summary: dict[str, Any]
    #: Folder with ``episodes.parquet``, ``summary.json`` and ``report.html``; ``None`` if none was asked for.
    folder: Path | None

    def column(self, name: str) -> np.ndarray:
        """A column over all episodes, such as ``score``; what is not known is NaN or ``None``."""
        if name not in self.rows[0]:
            raise SettingError(f"there is no column `{name}`: there are {', '.join(self.rows[0])}")
        values = [row[name] for row in self.rows]
        numbers = all(value is None or isinstance(value, (int, float)) for value in values)
        return np.array(values, dtype=np.float64 if numbers else object)

    def __len__(self) -> int:
        return len(self.rows)


class Scene:
    """A building in an episode, as a class of controllers is asked to act in it: what :class:`BuildingEnv` says of its
    spaces, without a simulation to step."""

    def __init__(
        self, spaces: _core.Spaces, building: _core.Building, seed: int, rescale_action: bool, normalize: bool
    ):
        self.layout = Layout(spaces)
        #: Seed of the episode.
        self.seed = seed
        self.building = Building(building, ("found", building.name, None, None))
        self.rescale_action = rescale_action
        self.metadata = self.layout.metadata()
        self.scale = None
        self.observation_space = observation_box(self.layout)
        if normalize:
            layout = self.layout
            self.scale = Scale(self.metadata["observation_names"], layout.observation_low, layout.observation_high)
            self.observation_space = self.scale.space
        self.action_space = action_box(self.layout, rescale_action)

    @property
    def unwrapped(self) -> Scene:
        """Itself, as an environment has it."""
        return self

    @property
    def morphology(self) -> Morphology:
        """The building as a graph."""
        return Morphology(self.layout.core.morphology())


def evaluate(
    policy: str | os.PathLike | Callable[[np.ndarray], Any] | Controller | type,
    buildings: str | Building | Sequence[str | Building],
    tasks: str | dict | Sequence[str | dict] = ("constant",),
    *,
    run_periods: str | Sequence[str] = ("winter",),
    seeds: int | Sequence[int] = (0,),
    timesteps_per_hour: int = 12,
    place: str | None = None,
    weather: str | os.PathLike | None = None,
    rescale_action: bool | None = None,
    normalize: bool = False,
    folder: str | os.PathLike | None = None,
    name: str | None = None,
    version: str = "",
    jobs: int | None = None,
    progress: bool = False,
) -> Evaluation:
    """Runs a policy on every building under every task, run period and seed, and scores it, as ``b2b evaluate`` does.

    ``policy`` is one of these:

    - a function from an observation to an action, both as :func:`make_env` has them: f32, actions in physical units, or
      from -1 to 1 with ``rescale_action=True``. ``normalize=True`` gives observations from -1 to 1, as
      ``make_sb3_vec`` and ``wrap_env_for_rl`` do. It is called once a step, from several threads;
    - an object that is called in the same way and has ``reset``: every episode has a copy of it;
    - a class of controllers, such as :class:`ReactiveController`: made for every episode, with a :class:`Scene` that
      tells spaces, metadata, morphology and ``seed``;
    - ``"reactive"``, ``"random"``, ``"constant"``, ``"planner"``, or the path of an ONNX file, whose actions are from
      -1 to 1 unless ``rescale_action=False``: no Python runs then.

    ``buildings`` are ids, types, paths of models, or what :func:`find_building` gives. As many episodes run at a time
    as ``jobs``, one for each core by default, each in a process of its own. With a ``folder``, every episode is on disk
    as it ends; the same call goes on where it was interrupted, and gives the same bytes. Whether it is the same is told
    by all arguments, and of the policy by ``name`` (by default that of the class or function) and ``version``: name
    another version after training on. An observation is given alone: sums in a batch depend on what else is in it, and
    an evaluation that was resumed would have other bits.

    Raises what the policy raises, which ends the evaluation; :class:`~building2building.errors.EvaluationError` for a
    folder of another evaluation. An episode whose process dies is a row with the reason in ``lost``.
    """
    named = isinstance(policy, (str, os.PathLike))
    if not named and not callable(policy):
        raise SettingError(f"{policy!r} is no policy: give a function, a class of controllers, or a name")
    if isinstance(policy, _BuiltIn):
        raise SettingError(f"this {type(policy).__name__} is of one environment: give the class")
    asked = [
        (*found, text, period, seed, timesteps_per_hour)
        for found in (_named(building, place, weather) for building in _listed(buildings))
        for period in _listed(run_periods)
        for text in (json.dumps(task) if isinstance(task, dict) else str(task) for task in _listed(tasks))
        for seed in _listed(seeds)
    ]
    name = name or ("" if named else _name_of(policy))
    rescale = named if rescale_action is None else rescale_action
    identity = f"python {name} {version}, rescale_action={rescale}, normalize={normalize}"
    given = os.fspath(policy) if named else _Makes(policy, rescale, normalize)
    physical = not named and isinstance(policy, type) and issubclass(policy, _BuiltIn)
    with tempfile.TemporaryDirectory(prefix="b2b-evaluation-") as aside:
        columns, summary = _core.evaluate(
            given,
            asked,
            os.fspath(folder) if folder is not None else aside,
            jobs or len(os.sched_getaffinity(0)),
            rescale and not physical,
            name,
            identity,
            _Line() if progress else None,
        )
    rows = [dict(zip(columns, row)) for row in zip(*columns.values())]
    return Evaluation(rows, json.loads(summary), None if folder is None else Path(folder))


def compute_normalized_score(
    episode_return: float,
    building: str | Building,
    task: str | dict = "constant",
    run_period: str = "winter",
    *,
    timesteps_per_hour: int = 12,
    place: str | None = None,
    weather: str | os.PathLike | None = None,
) -> float | None:
    """An episode's return over that of the reactive controllers for the same building, task and days.

    Both are sums of penalties: lower is better, and below 1 beats the controllers. What they get comes with the package
    for the small test, and is otherwise computed, which takes an episode, and kept in the cache. ``None`` where nothing
    was to be lost.

    >>> b2b.compute_normalized_score(-30.0, "SingleFamilyHouse-0018", "constant+energy0.5", "winter")

    Raises :class:`~building2building.errors.EvaluationError` for a building that cannot be run.
    """
    text = json.dumps(task) if isinstance(task, dict) else str(task)
    asked = (*_named(building, place, weather), text, run_period, 0, timesteps_per_hour)
    return _core.compute_normalized_score(float(episode_return), asked)


class _Makes:
    """Makes what acts in an episode: a function of an f64 observation, in physical units, that gives an action."""

    def __init__(self, policy, rescale_action: bool, normalize: bool):
        self._policy = policy._function if isinstance(policy, _Callable) else policy
        self._rescale, self._normalize = rescale_action, normalize

    def __call__(self, spaces: _core.Spaces, building: _core.Building, seed: int):
        policy, scene = self._policy, None
        if isinstance(policy, type) or self._normalize:
            scene = Scene(spaces, building, seed, self._rescale, self._normalize)
        if isinstance(policy, type):
            policy = policy(scene)
        elif hasattr(policy, "reset"):
            policy = copy.deepcopy(policy)
        if hasattr(policy, "reset"):
            policy.reset()
        if isinstance(policy, _BuiltIn):
            return policy.physical
        if scene is not None and scene.scale is not None:
            scale = scene.scale
            return lambda observation: policy(scale(observation))
        return lambda observation: policy(observation.astype(np.float32))


class _Line:
    """A line on standard error that says how far it is."""

    def __init__(self):
        self._last = ""

    def __call__(self, what: str, done: int, days: int) -> None:
        text = f"\r{what}: {done} of {days} simulated days"
        if days and text != self._last:
            self._last = text
            print(text, end="\n" if done == days else "", file=sys.stderr, flush=True)


def _listed(given) -> list:
    return [given] if isinstance(given, (str, int, dict, Building)) else list(given)


def _name_of(policy) -> str:
    policy = policy._function if isinstance(policy, _Callable) else policy
    name = getattr(policy, "__name__", None) or type(policy).__name__
    if name == "<lambda>":
        raise SettingError("a lambda has no name for the table: give evaluate(..., name=...)")
    return name


def _named(building: str | os.PathLike | Building, place, weather) -> tuple:
    """A building as the evaluation finds it: name, place, weather."""
    if isinstance(building, Building):
        kind, *found = building._recipe
        if kind != "found":
            raise SettingError(
                f"{building.name} was generated, and an evaluation takes buildings by their names: write its "
                "to_epjson() to a file, and give the path with weather=..."
            )
        if place is not None or weather is not None:
            raise SettingError(f"{building!r} has its place: leave out place and weather")
        building, place, weather = found
    weather = None if weather is None else os.path.abspath(weather)
    return os.fspath(building), place, weather
