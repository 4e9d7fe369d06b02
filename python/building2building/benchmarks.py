"""The four benchmark problems: what to train on, what to test on, and how.

>>> problem = DynamicsAdaptation("house")
>>> envs = problem.make_train_envs(4)                  # training buildings, spread over the split
>>> result = problem.evaluate(policy)                  # on every test environment

The problems are those of ``b2b benchmark``, which runs policies in ONNX files under the same rules and leaves results that
others can check. What is in a problem, the Rust crates decide.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from . import _core
from .env import BuildingEnv
from .errors import SettingError
from .rollouts import ReactiveController, rollout
from .vector import BuildingVectorEnv
from .wrappers import AugmentObservationWithBuildingParams, PadObservation, action_of_shape

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


def list_problems() -> list[str]:
    """Names of the problems, as ``b2b benchmark list`` has them."""
    return _core.Problem.names()


class RestrictedAction(gymnasium.Wrapper):
    """The action without the actuators that a side of a problem takes away. The building stays as it is: the reactive
    controllers drive them, or they are pinned, as the problem says."""

    def __init__(self, env: gymnasium.Env, problem: Problem, side: str):
        super().__init__(env)
        core = env.unwrapped
        self._restriction = problem._core.restricted(side, core.layout.core)
        if self._restriction is None:
            raise SettingError(f"no actuator is taken away on side `{side}` of {problem.name}")
        if core.rescale_action:
            raise SettingError("what is taken away is in physical units: make the environment without rescale_action")
        kept = self._restriction.kept()
        self.action_space = Box(core.action_space.low[kept], core.action_space.high[kept], dtype=np.float32)
        metadata = env.metadata
        names = {key: [metadata[key][each] for each in kept] for key in ("action_names", "action_units")}
        self.metadata = {**metadata, **names}

    def reset(self, **options):
        self._restriction.reset()
        return self.env.reset(**options)

    def step(self, action):
        action = action_of_shape(action, self.action_space.shape)
        return self.env.step(self._restriction.complete(self.unwrapped.observation, action))


@dataclass(frozen=True)
class Result:
    """What a policy got on the test environments of a problem."""

    #: Name of the problem.
    problem: str
    #: One for each test environment: building, task, return, baseline_return, score, and the episode's metrics.
    episodes: list[dict[str, Any]] = field(repr=False)
    #: Interquartile mean, median, mean and share below 1, each with its 95 % interval.
    measures: dict[str, Any]

    @property
    def interquartile_mean(self) -> float:
        """Of the scores: lower is better, 1 is the reactive controllers."""
        return self.measures["test"]["interquartile_mean"]["value"]

    @property
    def scores(self) -> dict[tuple[str, str], float]:
        """Score of each building and task."""
        return {(each["building"], each["task"]): each["score"] for each in self.episodes}


class Problem:
    """A problem by its name; ``changes`` make another of it (``windows=["01-10..01-11"]``, ``test=[ids]``)."""

    def __init__(self, name: str, **changes):
        self._core = _core.Problem(name, json.dumps(_given(changes)))

    @classmethod
    def _of(cls, core: _core.Problem) -> Problem:
        problem = object.__new__(cls)
        problem._core = core
        return problem

    @property
    def definition(self) -> dict[str, Any]:
        """All of it, as ``b2b benchmark show --json`` has it."""
        return json.loads(self._core.to_json())

    @property
    def name(self) -> str:
        """What it is called."""
        return self.definition["name"]

    @property
    def hash(self) -> str:
        """SHA-256 of all that matters: results of the same hash can be compared."""
        return self._core.hash()

    @property
    def changes(self) -> list[str] | None:
        """In what it differs from the one that is shipped under its name."""
        return self._core.changes()

    def train_building_ids(self, sample: int | None = None) -> list[str]:
        """Buildings to train on; with ``sample`` so many, spread evenly."""
        return self._core.building_ids("train", sample)

    def test_building_ids(self) -> list[str]:
        """Buildings to test on."""
        return self._core.building_ids("test")

    def _spread(self, n: int, building_ids: Sequence[str] | None) -> list[tuple[str, str]]:
        """Training buildings and tasks for so many environments."""
        if n < 1:
            raise SettingError(f"{n} environments: give 1 or more")
        known = self.train_building_ids()
        ids = self.train_building_ids(min(n, len(known))) if building_ids is None else list(building_ids)
        if not ids:
            raise SettingError("there is no building: give building_ids, or leave them out")
        for each in ids:
            self._core.check_training_building(each)
        tasks = self.definition["train"]["tasks"]
        # Every building under a task before any under the next.
        return [(ids[i % len(ids)], tasks[i // len(ids) % len(tasks)]) for i in range(n)]

    def _make(self, side: str, building_id: str, task: str, **arguments) -> gymnasium.Env:
        protocol = self.definition["protocol"]
        period = protocol["training_period"] if side == "train" else protocol["windows"][0]
        arguments = {"run_period": period, "timesteps_per_hour": protocol["steps_per_hour"], **arguments}
        env: gymnasium.Env = BuildingEnv(building_id=building_id, task=task, **arguments)
        if "restriction" in self.definition[side]:
            env = RestrictedAction(env, self, side)
        if "observation_width" in protocol:
            env = PadObservation(env, protocol["observation_width"])
        if protocol["attributes"] == "given":
            env = AugmentObservationWithBuildingParams(env)
        return env

    def make_train_envs(self, n: int, building_ids: Sequence[str] | None = None, **arguments) -> list[gymnasium.Env]:
        """So many environments to train on: buildings spread over the training side, then its tasks in turn. A building that
        is not to train on is refused. ``arguments`` go to :func:`make_env`."""
        return [self._make("train", *each, **arguments) for each in self._spread(n, building_ids)]

    def make_test_envs(self, n: int | None = None, **arguments) -> list[gymnasium.Env]:
        """The environments to test on, or the first of them: every building under every task."""
        return [self._make("test", *each, **arguments) for each in self._tests()[:n]]

    def make_train_vec(self, n: int, building_ids: Sequence[str] | None = None, **arguments) -> gymnasium.vector.VectorEnv:
        """The same as :meth:`make_train_envs` in one vector environment: a native one where a problem has one training task
        and leaves spaces as they are, else Gymnasium's around single ones. Actions are from -1 to 1, so that all buildings
        have the same, but in physical units where actuators are taken away."""
        protocol, train = self.definition["protocol"], self.definition["train"]
        spread = self._spread(n, building_ids)
        arguments = {"rescale_action": "restriction" not in train, **arguments}
        plain = "restriction" not in train and "observation_width" not in protocol and len(train["tasks"]) == 1
        if plain and protocol["attributes"] == "withheld":
            return BuildingVectorEnv(
                num_envs=n,
                buildings=[building for building, _ in spread],
                task=train["tasks"][0],
                **{
                    "run_period": protocol["training_period"],
                    "timesteps_per_hour": protocol["steps_per_hour"],
                    **arguments,
                },
            )
        makers = [lambda each=each: self._make("train", *each, **arguments) for each in spread]
        # Houses have attics and garages or not: the bounds of their slots differ.
        return gymnasium.vector.SyncVectorEnv(makers, observation_mode="different")

    def _tests(self) -> list[tuple[str, str]]:
        tasks = self.definition["test"]["tasks"]
        return [(building, task) for building in self.test_building_ids() for task in tasks]

    def evaluate(
        self,
        policy: Callable[[Any], Any],
        *,
        n: int | None = None,
        wrap: Callable[[gymnasium.Env], gymnasium.Env] | None = None,
        **arguments,
    ) -> Result:
        """Runs a policy, a function from an observation to an action, on every test environment (or the first ``n``), and the
        reactive controllers beside it. ``wrap`` is what training put around an environment. A class, such as
        ``ReactiveController``, is made for each environment."""
        episodes, strata = [], {}
        for building, task in self._tests()[:n]:
            made = self._make("test", building, task, **arguments)
            try:
                env = made if wrap is None else wrap(made)
                baseline = rollout(made, ReactiveController(made)).episode_return
                ran = rollout(env, policy(made) if isinstance(policy, type) else policy)
                score = _core.normalized_score(ran.episode_return, baseline)
                row = {"building": building, "task": task, "return": ran.episode_return}
                row |= {"baseline_return": baseline, "score": score}
                episodes.append({**(ran.metrics or {}), **row})
                if score is not None:
                    strata.setdefault((building.split("-")[0], task), []).append([score])
            finally:
                made.close()
        return Result(self.name, episodes, json.loads(_core.measures(list(strata.values()))))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"


def _given(changes: dict[str, Any]) -> dict[str, Any]:
    """What was given; a list for what is one."""
    return {
        name: [value] if isinstance(value, str) and name in _LISTS else value
        for name, value in changes.items()
        if value is not None
    }


_LISTS = {"buildings", "train", "test", "train_tasks", "test_tasks", "windows"}


def _choose(what: str, given: Any, choices: dict[Any, str]) -> str:
    key = given.lower().replace("_", "-") if isinstance(given, str) else given
    if key not in choices:
        raise SettingError(f"there is no {what} `{given}`: give one of {', '.join(map(str, choices))}")
    return choices[key]


class GoalAdaptation(Problem):
    """One building, and other tasks to test on than to train on.

    ``partition`` is ``energy-weight``, ``setpoint-mode`` or ``leave-one-out`` (of the six tasks, ``left_out`` is tested
    on); or give ``train_tasks`` and ``test_tasks``. ``building_id`` is another building than the problem's own.
    """

    def __init__(self, partition: str = "energy-weight", building_id: str | None = None, **changes):
        names = {each: f"goal-{each}" for each in ("energy-weight", "setpoint-mode", "leave-one-out")}
        super().__init__(_choose("partition", partition, names), buildings=building_id, **changes)


class DynamicsAdaptation(Problem):
    """Buildings of one type, others to test on than to train on. ``difficulty`` is 1 or ``house``, 2 or ``office-small``,
    3 or ``office-medium``."""

    def __init__(self, difficulty: int | str = 1, **changes):
        kinds = ("house", "office-small", "office-medium")
        names: dict[Any, str] = {number + 1: f"dynamics-{kind}" for number, kind in enumerate(kinds)}
        names |= {kind: f"dynamics-{kind}" for kind in kinds}
        super().__init__(_choose("difficulty", difficulty, names), **changes)


class ActionSpaceTransfer(Problem):
    """One building, and other actuators to test with than to train with. ``system_type`` is ``unitary`` or ``central``,
    ``direction`` is ``more`` (5 to 10 actuators, or 33 to 36) or ``fewer``."""

    def __init__(self, system_type: str = "unitary", direction: str = "more", **changes):
        few, all_ = _choose("system_type", system_type, {"unitary": "5 10", "central": "33 36"}).split()
        ways = {"more": f"{few}-{all_}", "fewer": f"{all_}-{few}", f"{few}-{all_}": f"{few}-{all_}"}
        ways[f"{all_}-{few}"] = f"{all_}-{few}"
        super().__init__(f"{system_type.lower()}-{_choose('direction', direction, ways)}", **changes)


class CrossDomainGeneralization(Problem):
    """Other types of building to test on than to train on: ``setting`` 1 (shops to small offices), 2 (shops to warehouses),
    3 (small to medium offices), or any ``train_types`` and ``test_types``."""

    def __init__(
        self,
        setting: int | str | None = None,
        *,
        train_types: Sequence[str] | None = None,
        test_types: Sequence[str] | None = None,
        **changes,
    ):
        if (train_types is None) != (test_types is None) or (setting is None) == (train_types is None):
            raise SettingError("give a setting, or train_types and test_types")
        if train_types is not None and test_types is not None:
            made = json.dumps(_given(changes))
            self._core = _core.Problem.cross_domain(list(train_types), list(test_types), made)
            return
        names = ("retail-to-office-small", "retail-to-warehouse", "office-small-to-office-medium")
        choices: dict[Any, str] = {number + 1: name for number, name in enumerate(names)}
        super().__init__(_choose("setting", setting, choices | {name: name for name in names}), **changes)
