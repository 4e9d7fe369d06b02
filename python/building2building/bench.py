"""Measures the cost of a step: ``python -m building2building.bench``.

CPU times are for this process, or for the worker process where noted. Alternatives are measured in turn, in random
order.
"""

from __future__ import annotations

import argparse
import datetime
import json
import math
import os
import random
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import building2building as b2b
from building2building import _core

from .errors import need

#: Steps that are timed together in a vector environment: an hour.
_STEPS = 12


def _worker(env: b2b.BuildingEnv) -> int:
    """Returns the id of the process that runs an environment's episode."""
    assert isinstance(env._core, _core.Env) and env._core.process is not None
    return env._core.process


def _cpu(process: int) -> float:
    """Returns the CPU time of a process from the scheduler's statistics, s."""
    with open(f"/proc/{process}/schedstat") as file:
        return int(file.read().split()[0]) / 1e9


def _trimmed_mean(values: NDArray[Any]) -> float:
    """Returns the mean without the lowest and highest tenth, which a shared machine disturbs."""
    cut = len(values) // 10
    return float(np.sort(values)[cut : len(values) - cut].mean())


def _timed_pairs(
    calls: tuple[Callable[[], Any], Callable[[], Any]], pairs: int, clock: Callable[[], float]
) -> NDArray[Any]:
    """Returns the times of two functions, s, ``[pairs, 2]``. Their order is random, so that neither gets the costlier
    hours of a day."""
    spent, generator = np.empty((pairs, 2)), random.Random(0)
    for pair in spent:
        first = generator.randrange(2)
        for which in (first, 1 - first):
            start = clock()
            calls[which]()
            pair[which] = clock() - start
    return spent


class _Times:
    """Times per step, µs, by name."""

    def __init__(self) -> None:
        self._all: defaultdict[str, list[float]] = defaultdict(list)

    def add(self, name: str, seconds: float, steps: int) -> None:
        self._all[name].append(seconds / steps * 1e6)

    def medians(self) -> dict[str, float]:
        return {name: float(np.median(values)) for name, values in self._all.items()}


def single(building_type: str, days: int, turns: int) -> dict[str, float]:
    """Returns the times of a step, µs.

    ``rust``: CPU time of ``Env::step`` in this process, called from Rust; ``python``: what a step from Python adds to
    it; ``main``, ``worker`` and ``wall``: CPU times and wall time with an environment in its own process, the default.
    """
    period = f"01-01..01-{days:02d}"
    env = b2b.make_env(building_type, run_period=period, task="constant")
    local = b2b.make_env(building_type, run_period=period, task="constant", in_process=True)
    action = ((env.layout.action_low + env.layout.action_high) / 2).astype(np.float32)
    times, steps = _Times(), env.episode_steps - 1
    for _ in range(turns):
        env.reset()
        process, step = _worker(env), env.step
        worker, cpu, wall = _cpu(process), time.process_time(), time.perf_counter()
        for _ in range(steps):
            step(action)
        times.add("wall", time.perf_counter() - wall, steps)
        times.add("main", time.process_time() - cpu, steps)
        times.add("worker", _cpu(process) - worker, steps)
        local.reset()
        core = local._core
        assert isinstance(core, _core.LocalEnv)
        calls = partial(core.hold, action, 1), partial(local.step, action)
        spent = _timed_pairs(calls, steps // 2, time.thread_time)
        times.add("rust", _trimmed_mean(spent[:, 0]), 1)
        times.add("python", _trimmed_mean(spent[:, 1] - spent[:, 0]), 1)
    env.close()
    local.close()
    return times.medians()


def vector(building_type: str, count: int, days: int, turns: int) -> tuple[float, float]:
    """Returns the throughput of a vector environment in steps per second, from Python and from Rust alone."""
    envs = b2b.make_vec(building_type, count, task="constant", run_period=f"01-01..01-{days:02d}")
    low, high = envs.layouts[0].action_bounds()
    actions = np.broadcast_to((low + high) / 2, (count, len(low))).copy()
    hours = envs.layouts[0].episode_steps // _STEPS - 1
    core = envs._core
    assert core is not None

    def step_from_python() -> None:
        for _ in range(_STEPS):
            envs.step(actions)

    def step_from_rust() -> None:
        core.hold(actions, _STEPS)

    spent = []
    for _ in range(turns):
        envs.reset(seed=0)
        spent.append(_timed_pairs((step_from_python, step_from_rust), hours // 2, time.perf_counter))
    envs.close()
    python, rust = (_STEPS * count / _trimmed_mean(each) for each in np.concatenate(spent).T)
    return python, rust


def _memory(processes: list[int]) -> float:
    """Returns the memory of processes, counting shared memory once, MB."""
    total = 0.0
    for process in processes:
        try:
            with open(f"/proc/{process}/smaps_rollup") as file:
                total += sum(int(line.split()[1]) for line in file if line.startswith("Pss:")) / 1e3
        except (FileNotFoundError, ProcessLookupError):  # it has ended since it was listed
            continue
    return total


def resampling(problem: str, count: int, days: int, changes: int) -> Iterator[dict[str, float]]:
    """Steps all training buildings of a problem and one of them in turn, a round of ``days`` each, until ``count``
    environments have changed their building ``changes`` times. Yields the measurements after each round.

    ``first_step``: time from the call of ``make_train_vec`` to the end of the first step, s; ``many``, ``one``: steps
    per second; ``memory``: of this process and the workers of ``many``, MB; ``waits`` and ``waited``: number of waits
    for a building, and their total time, s.
    """
    made = b2b.benchmarks.Problem(problem)
    period: dict[str, Any] = {"run_period": f"01-01..{datetime.date(2023, 1, 1) + datetime.timedelta(days - 1):%m-%d}"}
    start = time.perf_counter()
    many = made.make_train_vec(count, **period)
    many.reset(seed=0)
    actions = np.zeros(many.action_space.shape or (), dtype=np.float32)
    many.step(actions)
    first_step = time.perf_counter() - start
    one = made.make_train_vec(count, building_ids=made.train_building_ids(1), resample=False, **period)
    one.reset(seed=0)
    steps = one.layouts[0].episode_steps + 1
    while True:
        rates = []
        for envs in (many, one):
            start = time.perf_counter()
            for _ in range(steps):
                envs.step(actions)
            rates.append(steps * count / (time.perf_counter() - start))
        assert many._core is not None
        statistics = many.statistics
        yield {
            "first_step": first_step,
            "many": rates[0],
            "one": rates[1],
            "memory": _memory([os.getpid(), *many._core.processes()]),
            **statistics,
        }
        if statistics["building_changes"] >= changes:
            break
    many.close()
    one.close()


#: Steps of each environment between updates, as in the preset ``paper`` of ``b2b train``.
_ROLLOUT = 672


def training(building_id: str, count: int, steps: int) -> dict[str, float | None]:
    """Returns the speed of Stable-Baselines3's PPO on :func:`make_sb3_vec <building2building.sb3.make_sb3_vec>`.

    It has the hyperparameters of the preset ``paper`` of ``b2b train``. The first rollout is excluded; whole rollouts
    of at least ``steps`` steps follow.

    ``steps``: steps that were measured, of all environments; ``steps_per_s``; ``steps_per_cpu_s``: per CPU time of this
    process and its workers, ``None`` if an episode ended.
    """
    need("stable_baselines3", "train")
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import BaseCallback

    from .sb3 import make_sb3_vec

    envs = make_sb3_vec(num_envs=count, building_id=building_id)
    marks: list[tuple[float, dict[int, float]]] = []

    def mark() -> None:
        assert envs.envs._core is not None
        cpu = {process: _cpu(process) for process in envs.envs._core.processes()}
        marks.append((time.perf_counter(), {0: time.process_time(), **cpu}))

    class Marks(BaseCallback):
        def _on_rollout_start(self) -> None:
            mark()

        def _on_step(self) -> bool:
            return True

    model = PPO(
        "MlpPolicy",
        envs,
        learning_rate=5e-5,
        n_steps=_ROLLOUT,
        batch_size=336,
        n_epochs=5,
        gamma=0.98,
        gae_lambda=0.95,
        clip_range=0.2,
        ent_coef=0.01,
        vf_coef=0.5,
        max_grad_norm=0.5,
        target_kl=0.02,
        policy_kwargs={"net_arch": {"pi": [256, 256], "vf": [256, 256]}, "log_std_init": -1.0},
        seed=0,
        device="cpu",
    )
    rollouts = math.ceil(steps / (_ROLLOUT * count))
    model.learn((1 + rollouts) * _ROLLOUT * count, callback=Marks())
    mark()
    envs.close()
    (start, before), (end, after) = marks[1], marks[-1]
    measured = rollouts * _ROLLOUT * count
    cpu = sum(after.values()) - sum(before.values()) if before.keys() == after.keys() else None
    return {
        "steps": measured,
        "steps_per_s": measured / (end - start),
        "steps_per_cpu_s": measured / cpu if cpu else None,
    }


def _print_training(arguments: argparse.Namespace) -> None:
    trained = training(arguments.train, arguments.count, arguments.steps)
    if arguments.json:
        print(json.dumps(trained))
    else:
        print(f"{arguments.train}, {arguments.count} environments: {trained['steps_per_s']:.0f} steps/s")


def _print_resampling(arguments: argparse.Namespace) -> None:
    print("changes  many, steps/s  one, steps/s  ratio  memory, MB  waits  waited, s")
    for row in resampling(arguments.resample, arguments.count, arguments.days, arguments.changes):
        print(
            f"{row['building_changes']:7.0f}  {row['many']:13.0f}  {row['one']:12.0f}  "
            f"{row['many'] / row['one']:5.2f}  "
            f"{row['memory']:10.0f}  {row['waits']:5.0f}  {row['waited']:9.1f}",
            flush=True,
        )
    print(f"\nfirst step of {arguments.resample} with {arguments.count} environments: {row['first_step']:.1f} s")


def importing(turns: int = 5) -> float:
    """Returns the median time of ``import building2building`` in a new interpreter, s."""
    code = "import time; t = time.perf_counter(); import building2building; print(time.perf_counter() - t)"

    def run() -> float:
        return float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)

    return float(np.median([run() for _ in range(turns)]))


def resetting(building_type: str, turns: int = 20) -> tuple[float, float]:
    """Returns the median time of a reset, ms, and the private memory of an episode's process, MB."""
    env = b2b.make_env(building_type)
    times = []
    for _ in range(turns):
        start = time.perf_counter()
        env.reset()
        times.append(time.perf_counter() - start)
        env.step(env.action_space.low)
    with open(f"/proc/{_worker(env)}/smaps_rollup") as file:
        private = sum(int(line.split()[1]) for line in file if line.startswith("Private"))
    env.close()
    return float(np.median(times)) * 1e3, private / 1e3


def _print_steps(arguments: argparse.Namespace) -> None:
    print(f"import building2building: {importing():.2f} s\n")
    print("type                Rust, µs  + Python, µs  main, µs  worker, µs  wall, µs  reset, ms  private memory, MB")
    for each in arguments.types:
        times = single(each, arguments.days, arguments.turns)
        reset, memory = resetting(each)
        print(
            f"{each:<18}  {times['rust']:8.1f}  {times['python']:12.1f}  {times['main']:8.1f}  "
            f"{times['worker']:10.1f}  {times['wall']:8.1f}  {reset:9.2f}  {memory:18.1f}"
        )
    print(
        "\nRust: CPU time of Env::step in this process, called from Rust. + Python: what a step from Python adds.\n"
        "main, worker: CPU time of a step of an environment in its own process: of this process, with its context\n"
        "switches, and of the environment's."
    )
    print(f"\n{arguments.count} environments   make_vec, steps/s  Rust VecEnv, steps/s  ratio")
    for each in arguments.types:
        python, rust = vector(each, arguments.count, arguments.days, arguments.turns)
        print(f"{each:<18}  {python:15.0f}  {rust:20.0f}  {python / rust:5.2f}")


def main() -> None:
    """Measures the cost of steps, resets and imports."""
    parser = argparse.ArgumentParser(prog="python -m building2building.bench", description=main.__doc__)
    parser.add_argument("types", nargs="*", default=b2b.list_building_types(), metavar="TYPE")
    parser.add_argument("--days", type=int, default=7, help="days per episode, up to 31; up to 365 with --resample")
    parser.add_argument("--turns", type=int, default=5, help="repetitions of every measurement")
    parser.add_argument(
        "--count", "--environments", type=int, default=14, help="environments in the vector environment"
    )
    parser.add_argument(
        "--resample", metavar="PROBLEM", help="compare stepping all training buildings of a problem with stepping one"
    )
    parser.add_argument("--changes", type=int, default=200, help="building changes after which --resample ends")
    parser.add_argument(
        "--train", metavar="ID", help="measure training by Stable-Baselines3 on a building, and nothing else"
    )
    parser.add_argument("--steps", type=int, default=56_448, help="steps of all environments that --train measures")
    parser.add_argument("--json", action="store_true", help="print the result of --train as JSON")
    arguments = parser.parse_args()
    longest = 365 if arguments.resample else 31
    if not 1 <= arguments.days <= longest:
        parser.error(f"--days is {arguments.days}; expected 1 to {longest}")
    try:
        if arguments.train:
            _print_training(arguments)
        elif arguments.resample:
            _print_resampling(arguments)
        else:
            _print_steps(arguments)
    except b2b.Error as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
