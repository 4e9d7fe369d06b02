"""Training of agents, and agents as controllers."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..buildings import Building, PathLike
from ..env.tasks import Task, checked_jobs, task_text
from ..errors import SettingError
from ..rollouts import BuiltInController, ControlledEnv, PhysicalController

Array = NDArray[Any]
#: Called with the metrics of every update, as in ``progress.csv``; ends the run when it returns ``False``.
Callback = Callable[[dict[str, float]], object]


class AgentController(BuiltInController):
    """The controller of an :class:`Agent` in an environment. It acts without exploration. In a loop of your own, an
    agent that observes its rewards also needs :meth:`reward` after every step."""

    def __init__(self, folder: PathLike, env: gymnasium.Env[Any, Any] | ControlledEnv):
        PhysicalController.__init__(self, env)
        self._core = _core.Controller.agent(os.fspath(folder), self._layout.spaces)
        self.kind, self.seed = os.fspath(folder), 0
        observed = json.loads(_core.agent_info(self.kind))["interface"]["observation"]
        if observed["forecast"] and getattr(env.unwrapped, "has_weather_years", False):
            raise SettingError(
                f"the agent {self.kind} observes a forecast, which it reads once, and weather_years draws other "
                "weather for every episode; make the environment with weather=... instead"
            )


@dataclass(frozen=True)
class Agent:
    """A trained agent: the folder that :func:`train` or ``b2b train`` wrote.

    :func:`building2building.evaluate` takes it as a policy.

    >>> agent = b2b.Agent.load("runs/x")  # doctest: +SKIP
    >>> trajectory = b2b.rollout(env, agent.controller(env))  # doctest: +SKIP
    """

    #: Its folder.
    path: Path
    #: ``agent.json``: what it observes and controls, its network and its training.
    info: dict[str, Any] = field(repr=False)
    #: ``summary.json`` of its training: score, resolved score, RMS deviation (K), energy relative to the
    #: baseline; ``None`` for an agent without one.
    summary: dict[str, Any] | None = field(default=None, repr=False)

    @classmethod
    def load(cls, path: PathLike) -> Agent:
        """Reads the folder of an agent.

        Raises :class:`~building2building.errors.EvaluationError` for a folder without an agent or a damaged one.
        """
        folder = Path(path)
        info = json.loads(_core.agent_info(os.fspath(folder)))
        result = folder / "summary.json"
        summary = json.loads(result.read_text()) if result.is_file() else None
        return cls(folder, info, summary)

    def controller(self, env: gymnasium.Env[Any, Any] | ControlledEnv) -> AgentController:
        """Returns the agent's controller for an environment.

        Raises :class:`~building2building.errors.EvaluationError` for a building that the agent was not made for.
        """
        return AgentController(self.path, env)

    def __fspath__(self) -> str:
        return os.fspath(self.path)


def train(
    buildings: PathLike | Sequence[PathLike] | None = None,
    *,
    out: PathLike,
    place: str | None = None,
    weather: PathLike | None = None,
    building_type: str | Sequence[str] | None = None,
    problem: str | None = None,
    preset: str | None = None,
    config: PathLike | None = None,
    task: Task | Sequence[Task] | None = None,
    run_period: str | None = None,
    steps: float | None = None,
    seed: int | None = None,
    resume: bool = False,
    jobs: int | None = None,
    callback: Callback | None = None,
    progress: bool = False,
    **options: Any,
) -> Agent:
    """Trains an agent, like ``b2b train``, and returns it.

    ``buildings`` are assigned to the environments in turn, at their own places, at ``place`` (such as ``"Miami"``) or
    with ``weather`` (an EPW file, which a model of your own needs); with ``building_type``, every episode draws a
    building of the type's training split, and with ``problem``, the run uses only the training side of a benchmark
    problem. Several types need the preset ``"graph"`` or ``"supervisory-graph"``, whose agents control buildings of any
    type. ``task`` is a task as for :func:`make_env`, or several, one of which is drawn for every episode. ``preset`` is
    ``"residual"``, ``"direct"``, ``"paper"``, ``"recurrent"``, ``"graph"``, ``"supervisory"`` or
    ``"supervisory-graph"``, by default the one of ``b2b train`` for the other arguments; ``options`` are any other
    options of a run's ``config.toml``, such as ``environments=4`` or ``ppo={"gamma": 0.99}``. ``config`` is such a
    file, for example of an earlier run; other arguments take precedence. ``out`` is the folder of the run and of the
    agent. If it already has a run with the same options, that run continues from its last checkpoint; with ``resume``,
    only ``steps`` can be given. ``jobs`` is the number of episodes to evaluate in parallel, by default the number of
    CPU cores; the environments of the training use all of them.

    ``callback`` is called with the metrics of every update; when it returns ``False``, or at Ctrl-C, the run writes a
    checkpoint and ends with ``KeyboardInterrupt``. ``progress`` shows the steps and the last score on standard error.

    >>> agent = b2b.train("OfficeSmall-0509", task="occupancy", out="runs/x")  # doctest: +SKIP
    """
    tasks = [task] if isinstance(task, (str, dict)) else task
    named = {
        "buildings": _names(buildings),
        "place": place,
        # A configuration without a weather file has an empty string.
        "weather": os.path.abspath(weather) if weather else weather,
        "building_type": [building_type] if isinstance(building_type, str) else building_type and list(building_type),
        "problem": problem,
        "task": None if tasks is None else [task_text(each) for each in tasks],
        "period": run_period,
        "steps": _whole(steps),
        "seed": seed,
    }
    if config is not None and (buildings or building_type):
        # Either replaces the buildings of the file.
        named["buildings"], named["building_type"] = named["buildings"] or [], named["building_type"] or []
    given = {name: value for name, value in named.items() if value is not None} | options
    if "run_periods" in given or "tasks" in given:
        raise TypeError("train() takes `run_period` and `task`; omit the `s`")
    changes = set(given) | ({"preset"} if preset else set()) | ({"config"} if config else set())
    if resume and changes - {"steps"}:
        wrong = ", ".join(sorted(changes - {"steps"}))
        raise SettingError(f"resume=True takes the options of the run's folder; remove {wrong}")
    line = ProgressLine(callback) if progress else None
    try:
        _core.train(
            json.dumps(given, default=_plain),
            os.fspath(out),
            checked_jobs(jobs),
            resume,
            preset,
            config,
            callback if line is None else line.update,
            None if line is None else line.stage,
        )
    finally:
        if line is not None:
            line.end()
    return Agent.load(out)


def _names(buildings: Any) -> list[str] | None:
    """Returns the names and paths of buildings for a configuration."""
    if buildings is None:
        return None
    given = [buildings] if isinstance(buildings, (str, os.PathLike, Building)) else list(buildings)
    names = []
    for each in given:
        if isinstance(each, Building):
            raise SettingError(
                f"{each!r} is prepared already; pass its name or its model, with place=, weather= or control="
            )
        names.append(os.fspath(each))
    return names


class ProgressLine:
    """A line on standard error for every stage of a run, with the steps and the last score while it trains."""

    def __init__(self, callback: Callback | None):
        self._callback = callback
        self._score = ""
        self._open = False

    def stage(self, what: str) -> None:
        """Begins work other than updates."""
        self.end()
        print(what, file=sys.stderr, flush=True)

    def end(self) -> None:
        """Ends the line of updates."""
        if self._open:
            print(file=sys.stderr, flush=True)
        self._open = False

    def update(self, numbers: dict[str, float]) -> object:
        """Shows an update and calls the callback."""
        if np.isfinite(numbers.get("score", np.nan)):
            self._score = f", score {numbers['score']:.3f}"
        speed = numbers.get("steps_per_s", np.nan)
        text = f"{numbers['steps']:.0f} steps, {speed:.0f} steps/s{self._score}"
        print(f"\r{text:<60}", end="", file=sys.stderr, flush=True)
        self._open = True
        return None if self._callback is None else self._callback(numbers)


def _whole(steps: float | None) -> float | None:
    """Returns a number of steps such as 1e5 as an integer."""
    if isinstance(steps, float) and steps.is_integer():
        return int(steps)
    return steps


def _plain(value: ArrayLike) -> Any:
    """Converts a NumPy number to a Python number."""
    if isinstance(value, np.generic):
        return value.item()
    raise SettingError(f"{value!r} is not a valid configuration value")
