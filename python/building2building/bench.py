"""What a step costs, printed: ``python -m building2building.bench``.

CPU time is of this process alone, or of an environment's process where it says worker; wall time is by the clock. What
is compared takes turns, in an order by lot.
"""

from __future__ import annotations

import argparse
import random
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable

import numpy as np

import building2building as b2b


def _cpu(process: int) -> float:
    """CPU time of a process, s, by the scheduler's own count."""
    with open(f"/proc/{process}/schedstat") as file:
        return int(file.read().split()[0]) / 1e9


def _middle(values: np.ndarray) -> float:
    """Mean without the tenth at either end: a shared machine has moments."""
    cut = len(values) // 10
    return float(np.sort(values)[cut : len(values) - cut].mean())


def _in_turns(calls: tuple[Callable, Callable], pairs: int, clock: Callable[[], float]) -> np.ndarray:
    """Calls both, in an order by lot, so many times: neither has the hours with more to compute. Times of each, s, in rows."""
    spent, chance = np.empty((pairs, 2)), random.Random(0)
    for pair in spent:
        first = chance.randrange(2)
        for which in (first, 1 - first):
            start = clock()
            calls[which]()
            pair[which] = clock() - start
    return spent


class _Times:
    """Times of a step, us, by name."""

    def __init__(self):
        self._all = defaultdict(list)

    def keep(self, name: str, seconds: float, steps: int) -> None:
        self._all[name].append(seconds / steps * 1e6)

    def medians(self) -> dict[str, float]:
        return {name: float(np.median(values)) for name, values in self._all.items()}


def single(building_type: str, days: int, turns: int) -> dict[str, float]:
    """CPU and wall time of a step, us.

    ``rust``: ``Env::step`` in this process, called from Rust; ``beyond``: what a step of it from Python takes more;
    ``owner``, ``worker`` and ``wall``: of an environment with a process of its own, which is the default.
    """
    period = f"01-01..01-{days:02d}"
    env = b2b.make_env(building_type, run_period=period)
    local = b2b.make_env(building_type, run_period=period, in_process=True)
    action = ((env.unwrapped.layout.action_low + env.unwrapped.layout.action_high) / 2).astype(np.float32)
    times, steps = _Times(), env.unwrapped.episode_steps - 1
    for _ in range(turns):
        env.reset()
        process, step = env.unwrapped._core.process, env.step
        worker, cpu, wall = _cpu(process), time.process_time(), time.perf_counter()
        for _ in range(steps):
            step(action)
        times.keep("wall", time.perf_counter() - wall, steps)
        times.keep("owner", time.process_time() - cpu, steps)
        times.keep("worker", _cpu(process) - worker, steps)
        local.reset()
        step, hold = local.step, local.unwrapped._core.hold
        calls = (lambda: hold(action, 1)), (lambda: step(action))
        spent = _in_turns(calls, steps // 2, time.thread_time)
        times.keep("rust", _middle(spent[:, 0]), 1)
        times.keep("beyond", _middle(spent[:, 1] - spent[:, 0]), 1)
    env.close()
    local.close()
    return times.medians()


def vector(building_type: str, count: int, days: int, turns: int) -> tuple[float, float]:
    """Steps a second of a vector environment, all its environments together: from Python, and from Rust alone."""
    envs = b2b.make_vec(building_type, count, run_period=f"01-01..01-{days:02d}")
    actions = np.broadcast_to((envs.action_space.low + envs.action_space.high) / 2, envs.action_space.shape).copy()
    hours = envs.unwrapped.layouts[0].data["episode_steps"] // 12 - 1

    def an_hour():
        for _ in range(12):
            envs.step(actions)

    calls, spent = (an_hour, lambda: envs.unwrapped._core.hold(actions, 12)), []
    for _ in range(turns):
        envs.reset(seed=0)
        spent.append(_in_turns(calls, hours // 2, time.perf_counter))
    envs.close()
    python, rust = (12 * count / _middle(each) for each in np.concatenate(spent).T)
    return python, rust


def importing(turns: int = 5) -> float:
    """Time of ``import building2building`` in a fresh interpreter, s: the median."""
    code = "import time; t = time.perf_counter(); import building2building; print(time.perf_counter() - t)"
    run = lambda: subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: E731
    return float(np.median([float(run().stdout) for _ in range(turns)]))


def resetting(building_type: str, turns: int = 20) -> tuple[float, float]:
    """Median time of a reset, ms, and memory of an episode's process that it shares with nobody, MB."""
    env = b2b.make_env(building_type)
    times = []
    for _ in range(turns):
        start = time.perf_counter()
        env.reset()
        times.append(time.perf_counter() - start)
        env.step(env.action_space.low)
    with open(f"/proc/{env._core.process}/smaps_rollup") as file:
        own = sum(int(line.split()[1]) for line in file if line.startswith("Private"))
    env.close()
    return float(np.median(times)) * 1e3, own / 1e3


def main() -> None:
    """Prints all of it."""
    parser = argparse.ArgumentParser(prog="python -m building2building.bench", description=main.__doc__)
    parser.add_argument("types", nargs="*", default=b2b.list_building_types(), metavar="TYPE")
    parser.add_argument("--days", type=int, default=7, help="days of an episode, up to 31")
    parser.add_argument("--turns", type=int, default=5, help="over which the medians are")
    parser.add_argument("--count", type=int, default=14, help="environments of the vector environment")
    arguments = parser.parse_args()
    print(f"import building2building: {importing():.2f} s\n")
    print(
        "type                Env::step, us  beyond it, us  owner, us  worker, us  wall, us  reset, ms  own memory, MB"
    )
    for each in arguments.types:
        times = single(each, arguments.days, arguments.turns)
        reset, memory = resetting(each)
        print(
            f"{each:<18}  {times['rust']:13.1f}  {times['beyond']:13.1f}  {times['owner']:9.1f}  "
            f"{times['worker']:10.1f}  {times['wall']:8.1f}  {reset:9.2f}  {memory:14.1f}"
        )
    print(
        "\nEnv::step: in this process, called from Rust; beyond it: what a step of it from Python takes more.\n"
        "owner: what this process takes for a step of an environment with a process of its own, switching to it and\n"
        "back included; worker: what that process takes."
    )
    print(f"\n{arguments.count} environments   make_vec, steps/s  VecEnv in Rust, steps/s  ratio")
    for each in arguments.types:
        python, rust = vector(each, arguments.count, arguments.days, arguments.turns)
        print(f"{each:<18}  {python:15.0f}  {rust:23.0f}  {python / rust:5.2f}")


if __name__ == "__main__":
    main()
