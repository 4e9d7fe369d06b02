"""Evaluation of a policy on many buildings, relative to the baseline."""

from __future__ import annotations

import copy
import json
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..buildings import Building, Found, PathLike, as_building
from ..buildings.signatures import check_names, renamed, with_arguments_of
from ..env.layout import Layout
from ..env.morphology import Metadata, Morphology
from ..env.tasks import checked_jobs, task_text
from ..errors import SettingError
from ..process.temporary import temporary_folder
from ..rollouts import CallableController, Controller, PhysicalController
from ..scaling import Scale
from .identity import identity_of

Array = NDArray[Any]
Policy = str | os.PathLike[str] | Callable[[Array], ArrayLike] | Controller | type[Any]


@dataclass(repr=False)
class Evaluation:
    """The result of :func:`evaluate`."""

    #: One dictionary per episode, in the order of the request, with the columns of ``episodes.parquet``
    #: (docs/evaluation.md).
    rows: list[dict[str, Any]]
    #: Interquartile means and confidence intervals by task, run period and type, as printed by ``b2b evaluate --json``.
    summary: dict[str, Any]
    #: Folder with ``episodes.parquet``, ``summary.json`` and ``report.html``; ``None`` if none was requested.
    folder: Path | None
    #: Number of episodes that the folder contained before and that did not run again.
    reused: int = 0

    def column(self, name: str) -> Array:
        """Returns a column, such as ``score``, over all episodes; missing values are NaN or ``None``."""
        if name not in self.rows[0]:
            raise SettingError(f"unknown column `{name}`; expected one of {', '.join(self.rows[0])}")
        values = [row[name] for row in self.rows]
        numbers = all(value is None or isinstance(value, (int, float)) for value in values)
        return np.array(values, dtype=np.float64 if numbers else object)

    def __len__(self) -> int:
        return len(self.rows)

    def __repr__(self) -> str:
        ran = [row for row in self.rows if row["lost"] is None]
        lost = f", {len(self) - len(ran)} lost" if len(ran) < len(self) else ""
        scores = [row["score"] for row in ran if row["score"] is not None]
        score = f", mean score {np.mean(scores):.3f}" if scores else ""
        return f"<Evaluation of {self.summary['policy']}: {len(self)} episodes{lost}{score}>"


class EpisodeContext:
    """The building and spaces of an episode, from which a controller class is instantiated.

    It has the attributes of :class:`BuildingEnv` that describe the spaces, but no simulation.
    """

    def __init__(
        self, spaces: _core.Spaces, building: _core.Building, seed: int, rescale_action: bool, normalize: bool
    ):
        self.layout = Layout(spaces)
        #: Seed of the episode.
        self.seed = seed
        base = building.name.removesuffix("+setpoints")
        control = "actuators" if base == building.name else "setpoints"
        self.building = Building(building, Found(base, None, None, control=control))
        self.rescale_action = rescale_action
        self.metadata = Metadata(self.layout.metadata(), spaces.morphology)
        self.scale: Scale | None = None
        self.observation_space = self.layout.observation_space()
        if normalize:
            low, high = self.layout.observation_low, self.layout.observation_high
            names, steps_per_hour = self.metadata["observation_names"], self.layout.steps_per_hour
            self.scale = Scale(names, low, high, steps_per_hour=steps_per_hour)
            self.observation_space = self.scale.space
        self.action_space = self.layout.action_space(rescale_action)

    @property
    def unwrapped(self) -> EpisodeContext:
        """Itself."""
        return self

    @property
    def morphology(self) -> Morphology:
        """The building as a graph."""
        morphology: Morphology = self.metadata["morphology"]
        return morphology


class Request:
    """An evaluation to run: the arguments of :func:`evaluate`."""

    def __init__(
        self,
        policy: Policy,
        buildings: str | Building | Sequence[str | Building],
        tasks: str | dict[str, Any] | Sequence[str | dict[str, Any]] | None = None,
        *,
        run_periods: str | Sequence[str] = ("winter",),
        seeds: int | Sequence[int] = (0,),
        timesteps_per_hour: int = 12,
        place: str | None = None,
        weather: PathLike | None = None,
        control: str = "actuators",
        rescale_action: bool | None = None,
        normalize: bool = False,
        folder: PathLike | None = None,
        name: str | None = None,
        version: str = "",
        jobs: int | None = None,
        progress: bool = False,
    ) -> None:
        named = os.fspath(policy) if isinstance(policy, (str, os.PathLike)) else None
        if named is None and not callable(policy):
            raise SettingError(f"{policy!r} is not a policy; expected a function, a controller class or a name")
        if isinstance(policy, PhysicalController):
            raise SettingError(f"this {type(policy).__name__} belongs to an environment; pass the class")
        _check_options(policy, named, rescale_action, normalize=normalize, name=name, version=version)
        tasks = own_task(named) if tasks is None else tasks
        self.episodes = [
            (*found, text, period, seed, timesteps_per_hour)
            for found in (_found(building, place, weather, control) for building in _listed(buildings))
            for period in _listed(run_periods)
            for text in (task_text(task) for task in _listed(tasks))
            for seed in _listed(seeds)
        ]
        self.name = name or ("" if named is not None else name_of(policy))
        rescale = named is not None if rescale_action is None else rescale_action
        self.identity = f"python {self.name} {version}, rescale_action={rescale}, normalize={normalize}"
        if named is None and folder is not None:
            self.identity += f", {identity_of(_function_of(policy), version)}"
        self.rescale = rescale
        self.policy: str | _core._ControllerMaker = (
            ControllerMaker(policy, rescale, normalize) if named is None else named
        )
        self._folder, self._jobs, self._progress = folder, jobs, progress

    def run(self) -> Evaluation:
        """Runs the episodes that the folder does not contain, and scores all of them."""
        folder = self._folder
        with temporary_folder("evaluation") as temporary:
            columns, summary, reused = _core.evaluate(
                self,
                os.fspath(temporary if folder is None else folder),
                checked_jobs(self._jobs),
                ProgressLine() if self._progress else None,
            )
        rows = [dict(zip(columns, row)) for row in zip(*columns.values())]
        return Evaluation(rows, json.loads(summary), None if folder is None else Path(folder), reused)

    def run_part(self, folder: PathLike, numbers: Sequence[int], baselines: PathLike) -> dict[int, str]:
        """Runs some episodes, by their numbers, one at a time, and stores their baselines in another folder.

        Returns the lost episodes with the reason.
        """
        return _core.evaluate_part(self, os.fspath(folder), numbers, os.fspath(baselines))


@with_arguments_of(Request)
def evaluate(*arguments: Any, **options: Any) -> Evaluation:
    """Runs a policy on every building under every task, run period and seed, and scores it, like ``b2b evaluate``.

    ``policy`` is one of:

    - a function from an observation to an action, both as in :func:`make_env`: f32, actions in physical units, or in
      [-1, 1] with ``rescale_action=True``. ``normalize=True`` normalizes observations by the bounds of the episode's
      building, as ``make_sb3_vec`` does for a single building (batches of several have ``envs.scale``). It is called
      once per step, from several threads;
    - a callable object with a ``reset`` method, which is copied for every episode;
    - a controller class such as :class:`ReactiveController`, which is instantiated for every episode with an
      :class:`EpisodeContext`;
    - ``"guideline36"``, ``"own"``, ``"reactive"``, ``"hold"``, ``"off"``, ``"random"``, ``"constant"``,
      ``"linear-supervisor"``, ``"mpc"``, ``"foresight"``, ``"planner"`` or the path of an ONNX file, whose actions are
      in [-1, 1] unless ``rescale_action=False``; these run without Python.

    ``tasks`` are the tasks of the episodes: by default ``operate``, and for an agent the task that it was trained for.
    ``buildings`` are ids, types, paths of models, or results of :func:`find_building`; with ``control="setpoints"``,
    policies set the heating and the cooling setpoint of every zone. ``jobs`` episodes run at a time, each in its own
    process; by default, one per core. With a ``folder``, episodes are written as they end: the same call resumes an
    interrupted evaluation and gives the same bytes; it prints how many episodes are reused. Two calls are the same if
    all their arguments are. A policy is the same if its ``name`` (by default the name of the class or function), its
    code and the values that it refers to are: closures, global variables, attributes, versions of packages. With a
    ``version``, values are not compared, so change it after further training. Observations are not batched, because
    rounding within a batch depends on its other members.

    Raises the policy's own exceptions, which end the evaluation, and
    :class:`~building2building.errors.EvaluationError` if the folder holds finished episodes of another evaluation. An
    episode whose process dies becomes a row with the reason in ``lost``.
    """
    check_names("evaluate", options, (Request,))
    request = Request(*arguments, **options)
    result = request.run()
    say_reused(result.reused, len(result), result.folder)
    return result


@renamed(
    positions=4,
    cumulative_return="pass episode_return, the building's id, task and run_period",
    building_type="pass the building's id as building",
    building_id="pass it as building",
)
def compute_normalized_score(
    episode_return: float,
    building: str | Building,
    task: str | dict[str, Any] = "constant",
    run_period: str = "winter",
    *,
    timesteps_per_hour: int = 12,
    place: str | None = None,
    weather: PathLike | None = None,
    control: str = "actuators",
) -> float | None:
    """Divides a return by the reactive controllers' return for the same building, task and run period.

    Both are negated penalties, so lower is better, and the baseline scores 1. Baseline returns of the
    ``test_small`` split come with the package; others take an episode to compute and are cached. ``None`` if the ratio
    is undefined. Tasks of operation are scored by cost at comfort instead (:func:`evaluate`) and raise an error.

    >>> b2b.compute_normalized_score(-30.0, "SingleFamilyHouse-0018", "constant+energy0.5", "winter")

    Raises :class:`~building2building.errors.EvaluationError` if the building cannot be simulated.
    """
    episode = (*_found(building, place, weather, control), task_text(task), run_period, 0, timesteps_per_hour)
    return _core.normalized_score(float(episode_return), _core.baseline(episode)[0])


def compute_resolved_score(
    episode_return: float,
    building: str | Building,
    task: str | dict[str, Any] = "constant",
    run_period: str = "winter",
    *,
    timesteps_per_hour: int = 12,
    place: str | None = None,
    weather: PathLike | None = None,
    control: str = "actuators",
) -> float | None:
    """The resolved score: like :func:`compute_normalized_score`, after adding an RMS deviation of 0.2 K to both.

    0.2 K is the accuracy that ISO 7726 calls desirable for an air temperature sensor: differences below it count
    little.
    """
    episode = (*_found(building, place, weather, control), task_text(task), run_period, 0, timesteps_per_hour)
    baseline, _, steps = _core.baseline(episode)
    return _core.resolved_score(float(episode_return), baseline, steps)


def say_reused(reused: int, episodes: int, folder: PathLike | None) -> None:
    """Prints on standard error how many episodes of a folder are reused."""
    if reused:
        print(f"{folder}: {reused} of {episodes} episodes had finished before and are reused", file=sys.stderr)


class _WithMemory:
    """The controller of consecutive episodes in a building: a function with the policy's own methods."""

    def __init__(self, act: Callable[[Array], ArrayLike], policy: Any):
        self._act = act
        #: Begins another episode in the same building.
        self.next_episode = policy.next_episode
        if hasattr(policy, "reward"):
            #: Takes the reward of the last action.
            self.reward = policy.reward

    def __call__(self, observation: Array) -> ArrayLike:
        return self._act(observation)


class ControllerMaker:
    """Makes the controller of an episode for the core: a function from an f64 observation to an action."""

    def __init__(self, policy: Any, rescale_action: bool, normalize: bool):
        self._policy = _function_of(policy)
        self._rescale, self._normalize = rescale_action, normalize
        #: Whether its controllers can keep their memory over several episodes in a building.
        self.has_memory = hasattr(self._policy, "next_episode")

    def __call__(self, spaces: _core.Spaces, building: _core.Building, seed: int) -> Callable[[Array], ArrayLike]:
        policy, act = self._make(spaces, building, seed)
        return _WithMemory(act, policy) if self.has_memory else act

    def _make(
        self, spaces: _core.Spaces, building: _core.Building, seed: int
    ) -> tuple[Any, Callable[[Array], ArrayLike]]:
        """Returns the policy and its function from an f64 observation to an action."""
        policy, scale = self._policy, None
        if isinstance(policy, type) or self._normalize:
            context = EpisodeContext(spaces, building, seed, self._rescale, self._normalize)
            scale = context.scale
            if isinstance(policy, type):
                policy = policy(context)
        has_state = self.has_memory or hasattr(policy, "reset")
        if not isinstance(self._policy, type) and has_state:
            policy = copy.deepcopy(policy)
        if hasattr(policy, "reset"):
            policy.reset()
        if isinstance(policy, PhysicalController):
            return policy, policy.physical
        if scale is not None:
            return policy, lambda observation: policy(scale(observation))
        return policy, lambda observation: policy(observation.astype(np.float32))


class ProgressLine:
    """A line on standard error with the progress of an evaluation."""

    def __init__(self) -> None:
        self._last = ""

    def __call__(self, label: str, done: int, total: int) -> None:
        text = f"\r{label}: {done} of {total} simulated days"
        if total and text != self._last:
            self._last = text
            print(text, end="\n" if done == total else "", file=sys.stderr, flush=True)


def own_task(policy: str | None) -> str | dict[str, Any]:
    """Returns the task of an evaluation that names none: an agent's own, otherwise ``operate``."""
    if policy is None or not os.path.isfile(os.path.join(policy, "agent.json")):
        return "operate"
    task: dict[str, Any] = json.loads(_core.agent_info(policy))["task"]
    return task


def _listed(given: Any) -> Iterable[Any]:
    return [given] if isinstance(given, (str, int, np.integer, dict, os.PathLike, Building)) else list(given)


def is_built_in(policy: Any) -> TypeGuard[type[PhysicalController]]:
    """Returns whether a policy is a class of built-in controllers, whose actions are in physical units."""
    return isinstance(policy, type) and issubclass(policy, PhysicalController)


def _check_options(policy: Any, named: str | None, rescale_action: bool | None, **options: Any) -> None:
    """Raises for options that have no effect on a policy."""
    given = [name for name, value in options.items() if value]
    if named is not None:
        if rescale_action is not None and ".onnx" not in named.lower():
            given.append("rescale_action")
        if given:
            raise SettingError(f"{' and '.join(given)}: for policies in Python, and {named} is not one; omit it")
    elif is_built_in(policy) and (rescale_action or options["normalize"]):
        raise SettingError(f"{policy.__name__} observes and acts in physical units; omit rescale_action and normalize")


def _function_of(policy: Any) -> Any:
    return policy.function if isinstance(policy, CallableController) else policy


def name_of(policy: Any) -> str:
    policy = _function_of(policy)
    name = getattr(policy, "__name__", None) or type(policy).__name__
    if name == "<lambda>":
        raise SettingError("a lambda has no name for the results; pass name=...")
    return name


def _found(
    building: PathLike | Building, place: str | None, weather: PathLike | None, control: str
) -> tuple[str, str | None, str | None, bool, str, bool]:
    """Returns building, place, weather, allow_external, control and keep_design_days as the evaluation finds them."""
    allow_external = keep_design_days = False
    if isinstance(building, Building):
        origin = building.origin
        if not isinstance(origin, Found):
            raise SettingError(
                f"{building.name} was generated, but an evaluation finds buildings by name; write its to_epjson() to a "
                "file and pass the path with weather=..."
            )
        as_building(building, place, weather, control)
        building, place, weather, allow_external, control, keep_design_days = origin
    weather = None if weather is None else os.path.abspath(weather)
    return os.fspath(building), place, weather, allow_external, control, keep_design_days
