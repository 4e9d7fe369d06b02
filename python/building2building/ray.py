"""Evaluation, training, tuning and experiments on a Ray cluster, with the same results as on one machine.

Work is divided into Ray tasks of one core each, unless :class:`Resources` says otherwise: a training uses all cores of
its node. A task runs in the temporary folder of its node and returns its files, which the caller writes into the folder
of the results: nodes need no shared file system. A task whose node is lost runs again on another. Repeating an
interrupted call resumes it: only what the folder does not contain is run.

Every node needs this package, and downloads EnergyPlus on first use. Requires ``pip install ray``.
"""

from __future__ import annotations

import copy
import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, nan
from pathlib import Path
from typing import Any

import ray

from . import _core
from .buildings import Building, PathLike, list_building_types
from .errors import EvaluationError, SettingError
from .evaluation import Evaluation, Policy, Request, say_reused
from .learning import Agent
from .learning import train as train_here
from .process.temporary import replacing, temporary_folder

#: Files by their path in a folder.
Files = dict[str, bytes]
#: The files in an agent's folder.
_AGENT = ("agent.json", "weights.safetensors")


@dataclass(frozen=True)
class Resources:
    """What a task needs, and how often it is repeated after the loss of its node."""

    #: Cores.
    cpus: float = 1
    #: Memory, MB: a process of EnergyPlus has 200 to 300 MB resident, part of it shared; an episode and the template
    #: that it is copied from are two.
    memory_mb: int = 600
    #: Number of repetitions.
    retries: int = 3


def evaluate(
    policy: Policy,
    buildings: str | Building | Sequence[str | Building],
    tasks: str | dict[str, Any] | Sequence[str | dict[str, Any]] | None = None,
    *,
    folder: PathLike,
    chunk: int = 4,
    resources: Resources = Resources(),
    progress: bool = False,
    **arguments: Any,
) -> Evaluation:
    """Evaluates a policy on a cluster, with the arguments and the result of :func:`building2building.evaluate`.

    A task runs ``chunk`` episodes, and their baselines where these are unknown. The files in ``folder``, and the bytes
    of ``episodes.parquet``, are the same as on one machine. A policy in an ONNX file or in the folder of an agent is
    sent to the nodes; models and weather files of your own must have the same absolute path on all of them.
    """
    if chunk < 1:
        raise SettingError(f"chunk={chunk}; expected at least 1")
    if "jobs" in arguments:
        raise SettingError("jobs has no effect: each task runs one episode at a time; pass chunk and resources")
    request = Request(policy, buildings, tasks, folder=folder, **arguments)
    policy_files: Files = {}
    if isinstance(request.policy, str) and _is_path(request.policy):
        # Nodes name the policy by the last part of its path, as this machine then does.
        request.policy = os.path.abspath(request.policy)
        policy_files = _policy_files(Path(request.policy))
    place = Path(folder)
    # Checks that the folder belongs to this evaluation, or creates it.
    request.run_part(place, [], _core.baselines_folder())
    missing = [number for number in range(len(request.episodes)) if not _episode_file(place, number).exists()]
    chunks = [missing[start : start + chunk] for start in range(0, len(missing), chunk)]
    reused = len(request.episodes) - len(missing)
    say_reused(reused, len(request.episodes), folder)
    done = 0
    for number, files, lost in _map(_evaluate_part, chunks, resources, request, policy_files):
        _write_all(place / "episodes", files["episodes"])
        _write_all(_core.baselines_folder(), files["baselines"])
        done += len(chunks[number])
        for episode, reason in lost.items():
            print(f"lost: episode {episode}: {reason}", file=sys.stderr)
        if progress:
            print(f"{done} of {len(missing)} episodes", file=sys.stderr)
    return replace(request.run(), reused=reused)


def train(
    runs: Mapping[str, Mapping[str, Any]], *, folder: PathLike, resources: Resources = Resources()
) -> dict[str, Agent]:
    """Trains agents, such as the seeds of one configuration, one task each.

    ``runs`` maps the name of each run to its arguments for :func:`building2building.train`, without ``out``. Every
    agent is written to the subfolder of ``folder`` with this name. Runs that are already there are not repeated; a lost
    run starts over.

    >>> b2b.ray.train({f"seed-{n}": {"buildings": "OfficeSmall-0509", "seed": n} for n in range(5)}, folder="runs")
    ... # doctest: +SKIP
    """
    places = {name: Path(folder) / name for name in runs}
    missing = [name for name, place in places.items() if not (place / "summary.json").exists()]
    for name in missing:
        if places[name].exists():
            raise SettingError(f"{places[name]} is not a finished run; remove it, or choose another folder")
    for number, files in _map(_train, [dict(runs[name]) for name in missing], resources):
        place = places[missing[number]]
        aside = place.with_name(place.name + ".partial")
        shutil.rmtree(aside, ignore_errors=True)
        summary = json.loads(files["summary.json"]) | {"out": os.fspath(place)}
        _write_all(aside, {**files, "summary.json": json.dumps(summary, indent=2).encode()})
        os.rename(aside, place)
    return {name: Agent.load(place) for name, place in places.items()}


def trainable(**fixed: Any) -> Callable[[dict[str, Any]], None]:
    """Returns a trainable for Ray Tune: a function that trains an agent with the arguments of a trial.

    ``fixed`` are arguments of :func:`building2building.train` that all trials share, without ``out`` and ``callback``;
    a trial's arguments override and extend them. A trial reports the metrics of every evaluation (``score``, ``steps``,
    …) with the folder of its run as a checkpoint, from which a trial that was interrupted resumes, and the summary at
    the end (``resolved_score``, …). ``Agent.load(result.checkpoint.path)`` is the agent of a result. Needs
    ``pip install "ray[tune]"``.

    >>> from ray import tune  # doctest: +SKIP
    >>> fixed = {"buildings": "OfficeSmall-0509", "task": "occupancy", "steps": 200_000}  # doctest: +SKIP
    >>> space = {"ppo": {"learning_rate": tune.loguniform(1e-4, 3e-3)}}  # doctest: +SKIP
    >>> best = tune.TuneConfig(metric="score", mode="min", num_samples=16)  # doctest: +SKIP
    >>> tune.Tuner(b2b.ray.trainable(**fixed), param_space=space, tune_config=best).fit()  # doctest: +SKIP
    """

    def trial(config: dict[str, Any]) -> None:
        with temporary_folder("ray") as temporary:
            _train_trial(_merged(fixed, config), temporary / "run")

    return trial


def tune(
    classes: Sequence[tuple[str, int | None]],
    *,
    folder: PathLike,
    resources: Resources = Resources(),
    **options: Any,
) -> None:
    """Tunes the reactive controllers, like ``b2b tune``, one task for each building type and climate zone.

    ``options`` are ``objectives``, ``buildings``, ``validation``, ``evaluations``, ``seed`` and ``periods``, as in the
    command; the zone of a house is ``None``.

    >>> b2b.ray.tune([("OfficeSmall", zone) for zone in range(1, 9)], folder="tuning")  # doctest: +SKIP
    """
    if not classes:
        raise SettingError("classes is empty; pass at least one building type with its climate zone")
    types = [name.lower() for name in list_building_types()]
    ordered = sorted(
        {(name, zone) for name, zone in classes},
        key=lambda each: (_position(each[0].lower(), types), each[1] or 0),
    )
    selected = [{"types": [name], "zones": [] if zone is None else [zone]} for name, zone in ordered]
    orders = [{"classes": classes, "jobs": 1, **options} for classes in selected]
    results = _carry_out_all("tune", orders, Path(folder), "evaluations", resources)
    # A single order would tune every listed type in every listed zone.
    names = ("tuned.json", "energy_scale.json")
    _write_all(Path(folder), {name: _joined([files[name] for files in results]) for name in names})


def experiment(
    name: str, *, folder: PathLike, shards: int, budget: str = "full", resources: Resources = Resources()
) -> Path:
    """Runs an experiment, like ``b2b experiment run``, in ``shards`` tasks, and returns the path of its page.

    A job that fails does not stop the others; the error is raised when all have ended. ``name`` may also be the path of
    an experiment's file (``.toml``), which every node must have.
    """
    source = os.path.abspath(name) if name.endswith(".toml") else name
    order = {"experiment": source, "budget": budget}
    orders = [{**order, "shard": f"{number}/{shards}", "jobs": 1} for number in range(shards)]
    _carry_out_all("experiment", orders, Path(folder), "jobs", resources)
    _core.carry_out("experiment", json.dumps({**order, "out": os.fspath(folder)}))
    return Path(folder, "report.html")


def _is_path(policy: str) -> bool:
    """Returns whether the name of a policy is the path of an ONNX file or of an agent's folder."""
    return Path(policy).suffix.lower() == ".onnx" or Path(policy, _AGENT[0]).exists()


def _policy_files(policy: Path) -> Files:
    """Returns the files of a policy by their paths next to it."""
    files = [policy / name for name in _AGENT] if policy.is_dir() else [policy]
    return {file.relative_to(policy.parent).as_posix(): file.read_bytes() for file in files}


def _evaluate_part(
    numbers: list[int], request: Request, policy_files: Files
) -> tuple[dict[str, Files], dict[int, str]]:
    with temporary_folder("ray") as temporary:
        place, baselines = temporary / "evaluation", temporary / "baselines"
        if policy_files and isinstance(request.policy, str):
            policies = temporary / "policy"
            _write_all(policies, policy_files)
            name = os.path.basename(request.policy)
            request = copy.copy(request)
            request.policy = os.fspath(policies / name)
        lost = request.run_part(place, numbers, baselines)
        return {"episodes": _read_all(place / "episodes"), "baselines": _read_all(baselines)}, lost


def _train(arguments: dict[str, Any]) -> Files:
    with temporary_folder("ray") as temporary:
        place = temporary / "run"
        train_here(**{"jobs": 1, **arguments}, out=place)
        return _read_all(place)


def _train_trial(arguments: dict[str, Any], place: Path) -> None:
    """Trains an agent in a folder, from the checkpoint of the trial if it has one."""
    from ray import tune as ray_tune

    def report(numbers: Mapping[str, Any]) -> None:
        finite = {name: value for name, value in numbers.items() if isinstance(value, int | float) and isfinite(value)}
        ray_tune.report(finite, checkpoint=ray_tune.Checkpoint.from_directory(place))

    def report_evaluation(numbers: dict[str, float]) -> None:
        if isfinite(numbers.get("score", nan)):
            report(numbers)

    checkpoint = ray_tune.get_checkpoint()
    if checkpoint is not None:
        checkpoint.to_directory(place)
    agent = train_here(**{"jobs": 1, **arguments}, out=place, callback=report_evaluation)
    report(agent.summary or {})


def _merged(fixed: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Returns options with changes; tables, such as ``ppo``, are merged."""
    merged = dict(fixed)
    for name, value in changes.items():
        before = merged.get(name)
        merged[name] = _merged(before, value) if isinstance(before, dict) and isinstance(value, dict) else value
    return merged


def _carry_out(order: dict[str, Any], action: str, before: Files) -> tuple[Files, str]:
    """Carries out an action in a folder with some files; returns the files that it leaves, and its error."""
    with temporary_folder("ray") as temporary:
        place, error = temporary / "out", ""
        _write_all(place, before)
        try:
            _core.carry_out(action, json.dumps({**order, "out": os.fspath(place)}))
        except EvaluationError as failure:
            error = str(failure)
        return _read_all(place), error


def _carry_out_all(
    action: str, orders: list[dict[str, Any]], folder: Path, kept: str, resources: Resources
) -> list[Files]:
    """Carries out orders of an action. Each resumes from the files in the subfolder ``kept``, to which new ones are
    added. Returns the files that each order leaves."""
    before = {f"{kept}/{name}": content for name, content in _read_all(folder / kept).items()}
    results: list[Files] = [{} for _ in orders]
    errors = []
    for number, files, error in _map(_carry_out, orders, resources, action, before):
        results[number] = files
        new = {name: content for name, content in files.items() if before.get(name) != content}
        _write_all(folder, {name: content for name, content in new.items() if name.startswith(f"{kept}/")})
        errors += [error] if error else []
    if errors:
        raise EvaluationError("\n".join(errors))
    return results


def _joined(lists: Sequence[bytes]) -> bytes:
    """Joins non-empty JSON lists as text, which keeps the digits of their numbers."""
    items = [each.strip().removeprefix(b"[").removesuffix(b"]").strip(b"\n") for each in lists]
    return b"[\n" + b",\n".join(items) + b"\n]\n"


def _position(name: str, names: Sequence[str]) -> int:
    """Returns the position of a name, or the last for an unknown name, which its command reports."""
    return names.index(name) if name in names else len(names)


def _map(function: Callable[..., Any], items: Sequence[Any], resources: Resources, *shared: Any) -> Iterator[Any]:
    """Runs a function as a task for every item, with shared arguments; yields number and results as tasks end."""
    if not ray.is_initialized():
        ray.init(logging_level="warning", log_to_driver=False)
    task = ray.remote(function).options(
        num_cpus=resources.cpus, memory=resources.memory_mb * 10**6, max_retries=resources.retries
    )
    kept = [ray.put(each) for each in shared]
    running = {task.remote(item, *kept): number for number, item in enumerate(items)}
    try:
        while running:
            ended, _ = ray.wait(list(running), num_returns=1)
            result = ray.get(ended[0])
            yield (running.pop(ended[0]), *(result if isinstance(result, tuple) else (result,)))
    finally:
        for left in running:
            ray.cancel(left)


def _episode_file(folder: Path, number: int) -> Path:
    return folder / "episodes" / f"{number:06}.json"


def _read_all(folder: Path) -> Files:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def _write_all(folder: Path, files: Files) -> None:
    """Writes files, each under a temporary name that is then changed to its own."""
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as aside:
            Path(aside).write_bytes(content)
