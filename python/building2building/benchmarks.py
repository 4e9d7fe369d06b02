"""The benchmark problems: training and test environments, and scores.

>>> problem = DynamicsAdaptation("house")
>>> envs = problem.make_train_envs(4)                  # four training buildings, spread over the split
>>> result = problem.evaluate(policy)                  # on every test environment

``b2b benchmark`` has the same problems, evaluates ONNX policies under the same rules and writes verifiable results.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from . import _core
from .env import BuildingEnv, unwrap
from .env.tasks import checked_jobs
from .errors import SettingError
from .evaluation import ControllerMaker, ProgressLine, is_built_in, name_of
from .evaluation.identity import identity_of
from .learning import Agent, AgentController
from .rollouts import (
    BuiltInController,
    PhysicalController,
    ReactiveController,
    Trajectory,
    record_of,
    rollout,
    run_episode,
)
from .vector import BuildingVectorEnv
from .wrappers import AugmentObservationWithBuildingParams, PadObservation, RoleObservation, action_of_shape

__all__ = [
    "ActionSpaceTransfer",
    "CrossDomainGeneralization",
    "DynamicsAdaptation",
    "GoalAdaptation",
    "Problem",
    "RestrictedAction",
    "Result",
    "list_problems",
]

_Env = gymnasium.Env[Any, Any]


def list_problems() -> list[str]:
    """Returns the names of the problems, as ``b2b benchmark list`` prints them."""
    return _core.Problem.names()


class RestrictedAction(gymnasium.Wrapper[Any, Any, Any, Any]):
    """Restricts the action to the actuators that a side of a problem leaves to the agent.

    The building does not change: as the problem defines, the others follow the reactive controllers or are pinned.
    """

    def __init__(self, env: _Env, problem: Problem, side: str):
        super().__init__(env)
        self._building_env = core = unwrap(env)
        restriction = problem.restriction(side, core)
        if restriction is None:
            raise SettingError(f"side `{side}` of {problem.name} has no restricted actuators")
        if core.rescale_action:
            raise SettingError("restricted actions are in physical units; make the environment without rescale_action")
        self._restriction = restriction
        kept = restriction.kept()
        low, high = core.layout.action_bounds()
        self.action_space = Box(low[kept], high[kept], dtype=np.float32)
        metadata = env.metadata
        names = {key: [metadata[key][each] for each in kept] for key in ("action_names", "action_units")}
        self.metadata = metadata | names

    @property
    def kept(self) -> list[int]:
        """Indices of the actuators that the agent controls."""
        return self._restriction.kept()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        self._restriction.reset()
        return self.env.reset(seed=seed, options=options)

    def step(self, action: ArrayLike) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        action = action_of_shape(action, self.action_space.shape or ())
        return self.env.step(self._restriction.complete(self._building_env.observation, action))


@dataclass(frozen=True)
class Result:
    """The result of a policy on the test environments of a problem."""

    #: Name of the problem.
    problem: str
    #: One dictionary per test environment: building, task, period, return, baseline_return, score, resolved_score,
    #: relative_energy, energies of the policy and the baseline (energy, baseline_energy; Wh/m²), and the episode's
    #: metrics.
    episodes: list[dict[str, Any]] = field(repr=False)
    #: Measures of the scores and, under ``resolved``, of the resolved scores: interquartile mean, median, mean and
    #: share below 1, each with its 95 % confidence interval, minimum, maximum, and the number below 1.
    measures: dict[str, Any]

    @property
    def interquartile_mean(self) -> float:
        """Interquartile mean of the scores: lower is better; the reactive controllers have 1."""
        return self.measures["test"]["interquartile_mean"]["value"]

    @property
    def resolved_interquartile_mean(self) -> float:
        """Interquartile mean of the resolved scores, which ranks the leaderboard: lower is better."""
        return self.measures["test"]["resolved"]["interquartile_mean"]["value"]

    @property
    def rms_deviation(self) -> float:
        """RMS deviation from target, mean over episodes, K."""
        return sum(each["rms_deviation_k"] for each in self.episodes) / len(self.episodes)

    @property
    def relative_energy(self) -> float:
        """HVAC energy of all episodes divided by the baseline's; NaN if that is 0."""
        own, baseline = (sum(each[name] for each in self.episodes) for name in ("energy", "baseline_energy"))
        return own / baseline if baseline > 0 else math.nan

    @property
    def scores(self) -> dict[tuple[str, ...], float]:
        """Score by building and task, and by run period if there are several."""
        return self._by_environment("score")

    @property
    def resolved_scores(self) -> dict[tuple[str, ...], float]:
        """Resolved score by building and task, and by run period if there are several."""
        return self._by_environment("resolved_score")

    def _by_environment(self, name: str) -> dict[tuple[str, ...], float]:
        """Returns a column by test environment."""
        keys = ["building", "task"]
        if len({each["period"] for each in self.episodes}) > 1:
            keys.append("period")
        return {tuple(each[key] for key in keys): each[name] for each in self.episodes}


class Problem:
    """A problem by its name. ``changes`` redefine fields, such as ``windows=["01-10..01-11"]`` or ``test=[ids]``."""

    def __init__(self, name: str, **changes: Any):
        self._core = _core.Problem(name, json.dumps(_without_none(changes)))

    @property
    def definition(self) -> dict[str, Any]:
        """The whole definition, as ``b2b benchmark show --json`` prints it."""
        return json.loads(self._core.to_json())

    @property
    def name(self) -> str:
        """Name."""
        return self.definition["name"]

    @property
    def hash(self) -> str:
        """SHA-256 of the definition; only results with the same hash are comparable."""
        return self._core.hash()

    @property
    def changes(self) -> list[str] | None:
        """Fields that differ from the built-in problem of the same name; ``None`` if there is none."""
        return self._core.changes()

    def train_building_ids(self, sample: int | None = None) -> list[str]:
        """Returns the training buildings; with ``sample``, that many, evenly spaced."""
        return self._core.building_ids("train", sample)

    def test_building_ids(self) -> list[str]:
        """Returns the test buildings."""
        return self._core.building_ids("test")

    def restriction(self, side: str, env: BuildingEnv) -> _core.Restriction | None:
        """Returns the restricted action space of an environment on a side, ``train`` or ``test``; ``None`` if all
        actuators are available."""
        return self._core.restricted(side, env.layout.spaces)

    def _spread(self, n: int, building_ids: Sequence[str] | None) -> list[tuple[str, str]]:
        """Returns building and task of ``n`` training environments."""
        if n < 1:
            raise SettingError(f"the number of environments is {n}; expected 1 or more")
        known = self.train_building_ids()
        ids = self.train_building_ids(min(n, len(known))) if building_ids is None else list(building_ids)
        if not ids:
            raise SettingError("building_ids is empty; omit it to use the problem's training buildings")
        for each in ids:
            self._core.check_training_building(each)
        tasks = self.definition["train"]["tasks"]
        # All buildings under one task, then all under the next.
        return [(ids[i % len(ids)], tasks[i // len(ids) % len(tasks)]) for i in range(n)]

    def _make(self, side: str, building_id: str, task: str, **arguments: Any) -> _Env:
        protocol = self.definition["protocol"]
        arguments = {"timesteps_per_hour": protocol["steps_per_hour"], **arguments}
        if side == "train":
            arguments.setdefault("run_period", protocol["training_period"])
        building_env = BuildingEnv(building_id=building_id, task=task, **arguments)
        env: _Env = building_env
        if "restriction" in self.definition[side]:
            env = RestrictedAction(env, self, side)
        if protocol.get("observation", "roles") == "roles" and building_env.layout.spaces.roles is not None:
            env = RoleObservation(env)
        elif "observation_width" in protocol:
            env = PadObservation(env, width=protocol["observation_width"])
        if protocol["attributes"] == "given":
            env = AugmentObservationWithBuildingParams(env)
        return env

    def make_train_envs(self, n: int, building_ids: Sequence[str] | None = None, **arguments: Any) -> list[_Env]:
        """Makes ``n`` training environments: buildings spread over the training split, then its tasks in turn.

        Raises for a building that must not be used for training. ``arguments`` go to :func:`make_env`.
        """
        return [self._make("train", *each, **arguments) for each in self._spread(n, building_ids)]

    def make_test_envs(self, n: int | None = None, **arguments: Any) -> list[_Env]:
        """Makes the test environments, every building under every task in every test period, or the first ``n`` of
        them."""
        return [
            self._make("test", building, task, **{"run_period": period, **arguments})
            for building, task, period in self._tests()[:n]
        ]

    def make_train_vec(
        self,
        n: int,
        building_ids: Sequence[str] | None = None,
        *,
        resample: bool | int = True,
        **arguments: Any,
    ) -> BuildingVectorEnv:
        """Makes ``n`` training environments as one vector environment.

        Every episode draws a training building and a training task; with ``resample=k``, every ``k`` episodes;
        ``weights={type: weight}`` weights the building types. With ``resample=False``, the environments are the ones
        from :meth:`make_train_envs`, repeated. Observations are the same as in the test: padded, with the building's
        attributes if the problem gives them. Actions are in [-1, 1], so that all buildings share one action space, and
        actuators that the problem withholds are not among them. Further arguments go to :func:`make_vec`.
        """
        protocol = self.definition["protocol"]
        if "task" in arguments:
            raise SettingError(f"{self.name} has its own training tasks; omit task, or redefine its train_tasks")
        spread = [building for building, _ in self._spread(n, building_ids)]
        known = self.train_building_ids() if building_ids is None else list(building_ids)
        options = {
            "task": self.definition["train"]["tasks"],
            "run_period": protocol["training_period"],
            "timesteps_per_hour": protocol["steps_per_hour"],
            "rescale_action": True,
            "by_role": protocol.get("observation", "roles") == "roles",
            **arguments,
        }
        buildings = known if resample else list(dict.fromkeys(spread))
        return BuildingVectorEnv(None, n, buildings=buildings, resample=resample, problem=self._core, **options)

    def _tests(self) -> list[tuple[str, str, str]]:
        """Returns building, task and run period of the test environments."""
        tasks, periods = self.definition["test"]["tasks"], self.definition["protocol"]["windows"]
        return [
            (building, task, period) for building in self.test_building_ids() for task in tasks for period in periods
        ]

    def _keeps_memory(self) -> bool:
        """Whether policies keep their memory over the episodes in a building."""
        return self.definition["protocol"].get("memory") == "building"

    def evaluate(
        self,
        policy: Callable[[Any], Any] | Agent,
        *,
        n: int | None = None,
        wrap: Callable[[_Env], _Env] | None = None,
        **arguments: Any,
    ) -> Result:
        """Runs a policy and the baseline on every test environment, or on the first ``n``.

        The baseline and the scores are the task's: the reactive controllers, or in tasks of operation
        ``Guideline36Controller`` and the score at comfort.

        ``policy`` is a function from an observation to an action, an :class:`Agent`, or a controller class such as
        ``ReactiveController``, which is instantiated for every environment. ``wrap`` applies the wrappers of training.
        Known baselines do not run again. With ``arguments`` that draw days, weather or targets, the number of the test
        environment is the seed of the policy's episode and of its baseline's. An agent keeps its memory where the
        problem says so; for other policies with memory, there is :meth:`run`.
        """
        if "run_period" in arguments:
            raise SettingError(f"{self.name} has its own run periods; omit run_period, or redefine its windows")
        self._check_actuators(policy)
        if hasattr(policy, "next_episode") and not is_built_in(policy) and self._keeps_memory():
            raise SettingError(
                f"{name_of(policy)} has the method next_episode, and policies keep their memory in {self.name}; call "
                "Problem.run, which runs consecutive episodes"
            )
        tests = self._tests()[:n]
        # Baselines are kept only for the problem's own episodes, without other arguments.
        baselines = None if arguments else self._core.baselines(tests, checked_jobs(None))
        agent = _AgentWithMemory(policy) if isinstance(policy, Agent) and self._keeps_memory() else None
        episodes = []
        for number, (building, task, period) in enumerate(tests):
            env = made = self._make("test", building, task, **{"run_period": period, **arguments})
            try:
                env = made if wrap is None else wrap(made)
                baseline = _baseline(made, number) if baselines is None else baselines[number]
                if agent is None:
                    trajectory = rollout(env, _controller(policy, env), seed=number)
                else:
                    trajectory = run_episode(env, agent.begin(building, task, made), seed=number)
            finally:
                env.close()
            row = {"building": building, "task": task, "period": period}
            episodes.append({**(trajectory.metrics or {}), **row, **_scores(trajectory, baseline)})
        return Result(self.name, episodes, _measures(episodes))

    def _check_actuators(self, policy: Any) -> None:
        """Raises for a policy that controls actuators that the test withholds."""
        restriction = self.definition["test"].get("restriction")
        if restriction is None or not (isinstance(policy, Agent) or is_built_in(policy)):
            return
        if policy is ReactiveController and restriction["left_to"] == "reactive":
            return
        name = f"the agent {policy.path}" if isinstance(policy, Agent) else policy.__name__
        raise SettingError(
            f"{name} controls all actuators, and {self.name} withholds some; pass a function from the observation to "
            "the other actuators"
        )

    def run(
        self,
        policy: Callable[[Any], Any] | type[Any],
        folder: str | os.PathLike[str],
        *,
        train_policy: Callable[[Any], Any] | type[Any] | None = None,
        name: str | None = None,
        version: str = "",
        rescale_action: bool = False,
        by_seed: bool = False,
        description: str | None = None,
        training_steps: int | None = None,
        jobs: int | None = None,
        progress: bool = False,
    ) -> dict[str, Any]:
        """Runs a policy on the problem like ``b2b benchmark run``, ``jobs`` episodes at a time; returns the result.

        ``policy`` is one of:

        - a function from an observation to an action, both as the problem defines them: actions in physical units, or
          in [-1, 1] with ``rescale_action=True``. It is called from several threads;
        - a controller class, which is instantiated for every episode with an :class:`EpisodeContext` and observes and
          controls the whole building. ``context.morphology`` is the building as a graph: ``split_observation`` gives
          one array ``[nodes, slots]`` for each node type, ``to_pyg()["edge_index"]`` the edges, and ``join_actions``
          makes an action from one array for each node type. A graph policy of your own can thus control any building.

        Where the problem says that policies keep their memory (``protocol["memory"] == "building"``), a class or an
        object with a method ``next_episode()`` controls all episodes with the same building, task and seed: it is made
        or copied for the first, and ``next_episode()`` is called before each of the others. If it has a method
        ``reward(value)``, it is called after each step. An object, which observes what the problem defines, also
        observes the previous step, as with :class:`PreviousStepObservation`.

        The folder receives ``result.json`` and the episodes, for ``b2b benchmark report`` and ``b2b benchmark verify``.
        ``verify`` checks them like any other result, but reports that it did not rerun the policy, which is your
        program. The same call resumes an interrupted run; a policy is identified as by :func:`evaluate`. With
        ``by_seed=True``, every seed of the protocol is run (``context.seed``), otherwise only the first.
        ``train_policy`` runs in the training buildings if the problem leaves the agent other actuators there than in
        the test buildings.
        """
        for each in (policy, train_policy):
            if each is not None and not callable(each):
                raise SettingError(f"{each!r} is not a policy; expected a function or a controller class")
            if isinstance(each, PhysicalController):
                raise SettingError(f"this {type(each).__name__} belongs to an environment; pass the class")
            if rescale_action and is_built_in(each):
                raise SettingError(f"actions of {each.__name__} are in physical units; omit rescale_action")
        whole = isinstance(policy, type)
        if train_policy is not None and isinstance(train_policy, type) != whole:
            raise SettingError("policy and train_policy must both be functions, or both controller classes")
        name = name or name_of(policy)
        identity = f"python {name} {version}, rescale_action={rescale_action}"
        identity += ", ".join(
            ["", *(identity_of(each, version) for each in (policy, train_policy) if each is not None)]
        )
        result = self._core.run(
            ControllerMaker(policy, rescale_action, normalize=False),
            None if train_policy is None else ControllerMaker(train_policy, rescale_action, normalize=False),
            os.fspath(folder),
            checked_jobs(jobs),
            rescale_action,
            whole,
            by_seed,
            name,
            identity,
            description,
            training_steps,
            ProgressLine() if progress else None,
        )
        return json.loads(result)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"


def _controller(policy: Callable[[Any], Any] | Agent, env: _Env) -> Callable[[Any], Any]:
    """Returns the controller of an episode of the environment."""
    if isinstance(policy, Agent):
        return policy.controller(env)
    return policy(env) if isinstance(policy, type) else policy


class _AgentWithMemory:
    """An agent whose controller continues from one episode of a building and task to the next."""

    def __init__(self, agent: Agent):
        self._agent = agent
        self._last: tuple[str, str, AgentController] | None = None

    def begin(self, building: str, task: str, env: _Env) -> AgentController:
        """Returns the controller for the next episode."""
        if self._last is not None and self._last[:2] == (building, task):
            self._last[2].next_episode()
        else:
            self._last = (building, task, self._agent.controller(env))
            self._last[2].reset()
        return self._last[2]


def _scores(trajectory: Trajectory, baseline: _core.Baseline) -> dict[str, Any]:
    """Returns the columns of an episode that compare it to its baseline."""
    score, resolved_score, energy = baseline.compare(record_of(trajectory)[0])
    return {
        "baseline_return": baseline.episode_return,
        "score": score,
        "resolved_score": resolved_score,
        "energy": energy,
        "baseline_energy": baseline.energy,
        "relative_energy": energy / baseline.energy if baseline.energy > 0 else math.nan,
    }


def _measures(episodes: list[dict[str, Any]]) -> dict[str, Any]:
    """Aggregates the scores of the episodes that have them."""
    rows = [
        (each["building"], each["task"], each["period"], 0, each["score"], each["resolved_score"]) for each in episodes
    ]
    return json.loads(_core.measures([row for row in rows if None not in row]))


def _baseline(env: _Env, seed: int) -> _core.Baseline:
    """Runs the baseline in an environment."""
    trajectory = rollout(env, BuiltInController(env, kind=unwrap(env).setting.baseline), seed=seed)
    return _core.Baseline.of(record_of(trajectory)[0])


_LISTS = {"buildings", "train", "test", "train_tasks", "test_tasks", "windows"}


def _without_none(changes: dict[str, Any]) -> dict[str, Any]:
    """Removes fields that are ``None``, and wraps single values in lists where the definition has lists."""
    return {
        name: [value] if isinstance(value, str) and name in _LISTS else value
        for name, value in changes.items()
        if value is not None
    }


def _choose(what: str, given: Any, choices: dict[Any, str]) -> str:
    key = given.lower().replace("_", "-") if isinstance(given, str) else given
    if key not in choices:
        raise SettingError(f"unknown {what} `{given}`; expected one of {', '.join(map(str, choices))}")
    return choices[key]


class GoalAdaptation(Problem):
    """Transfer between tasks in one building.

    ``partition`` is ``energy-weight``, ``setpoint-mode`` or ``leave-one-out``, which tests on the task ``left_out`` of
    the six; or pass ``train_tasks`` and ``test_tasks``. ``building_id`` replaces the problem's building.
    """

    def __init__(self, partition: str = "energy-weight", building_id: str | None = None, **changes: Any):
        names: dict[Any, str] = {each: f"goal-{each}" for each in ("energy-weight", "setpoint-mode", "leave-one-out")}
        super().__init__(_choose("partition", partition, names), buildings=building_id, **changes)


class DynamicsAdaptation(Problem):
    """Transfer between buildings of one type. ``difficulty`` is 1 or ``house``, 2 or ``office-small``, 3 or
    ``office-medium``."""

    def __init__(self, difficulty: int | str = 1, **changes: Any):
        kinds = ("house", "office-small", "office-medium")
        names: dict[Any, str] = {number + 1: f"dynamics-{kind}" for number, kind in enumerate(kinds)}
        names |= {kind: f"dynamics-{kind}" for kind in kinds}
        original = dict(zip(("easy", "medium", "hard"), kinds))
        if difficulty in original:
            kind = original[difficulty]
            raise SettingError(f"unknown difficulty `{difficulty}`, which is called {kind} here (docs/coming_from.md)")
        super().__init__(_choose("difficulty", difficulty, names), **changes)


class ActionSpaceTransfer(Problem):
    """Transfer between sets of actuators in one building. ``system_type`` is ``unitary`` or ``central``;
    ``direction`` is ``more`` (from 5 to 10 actuators, or from 33 to 36) or ``fewer``."""

    def __init__(self, system_type: str = "unitary", direction: str = "more", **changes: Any):
        few, all_ = _choose("system_type", system_type, {"unitary": "5 10", "central": "33 36"}).split()
        ways: dict[Any, str] = {"more": f"{few}-{all_}", "fewer": f"{all_}-{few}"}
        ways |= {way: way for way in (f"{few}-{all_}", f"{all_}-{few}")}
        super().__init__(f"{system_type.lower()}-{_choose('direction', direction, ways)}", **changes)


class CrossDomainGeneralization(Problem):
    """Transfer between building types: ``setting`` 1 (retail to small offices), 2 (retail to warehouses), 3 (small to
    medium offices), or any ``train_types`` and ``test_types``."""

    def __init__(
        self,
        setting: int | str | None = None,
        *,
        train_types: Sequence[str] | None = None,
        test_types: Sequence[str] | None = None,
        **changes: Any,
    ):
        if (train_types is None) != (test_types is None) or (setting is None) == (train_types is None):
            raise SettingError("pass either a setting, or both train_types and test_types")
        if train_types is not None and test_types is not None:
            changes_json = json.dumps(_without_none(changes))
            self._core = _core.Problem.cross_domain(list(train_types), list(test_types), changes_json)
            return
        names = ("retail-to-office-small", "retail-to-warehouse", "office-small-to-office-medium")
        choices: dict[Any, str] = {number + 1: name for number, name in enumerate(names)}
        super().__init__(_choose("setting", setting, choices | {name: name for name in names}), **changes)
