"""Measures the cost of a step: ``python -m building2building.bench``.

CPU times are those of this process, or of the worker process where noted. Alternatives are measured in turn, in random
order.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import building2building as b2b
from building2building import _core

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
    it; ``main``, ``worker`` and ``wall``: CPU times and wall time of an environment in its own process, the default.
    """
    period = f"01-01..01-{days:02d}"
    env = b2b.make_env(building_type, run_period=period)
    local = b2b.make_env(building_type, run_period=period, in_process=True)
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
    envs = b2b.make_vec(building_type, count, run_period=f"01-01..01-{days:02d}")
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


def main() -> None:
    """Measures the cost of steps, resets and imports."""
    parser = argparse.ArgumentParser(prog="python -m building2building.bench", description=main.__doc__)
    parser.add_argument("types", nargs="*", default=b2b.list_building_types(), metavar="TYPE")
    parser.add_argument("--days", type=int, default=7, help="days per episode, up to 31")
    parser.add_argument("--turns", type=int, default=5, help="repetitions of every measurement")
    parser.add_argument("--count", type=int, default=14, help="environments in the vector environment")
    arguments = parser.parse_args()
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
        "switches, and of that of the environment."
    )
    print(f"\n{arguments.count} environments   make_vec, steps/s  Rust VecEnv, steps/s  ratio")
    for each in arguments.types:
        python, rust = vector(each, arguments.count, arguments.days, arguments.turns)
        print(f"{each:<18}  {python:15.0f}  {rust:20.0f}  {python / rust:5.2f}")


if __name__ == "__main__":
    main()
