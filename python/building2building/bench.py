"""What a step costs, printed: ``python -m building2building.bench``.

CPU time is of this process alone (single environments: of it and of the engine's process), wall time by the clock. Each
measure is the best of several turns, taken in turns, so that what else the machine does counts as little as it can.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time

import numpy as np

import building2building as b2b


def _cpu(process: int) -> float:
    """CPU time of a process, s, by the scheduler's own count."""
    with open(f"/proc/{process}/schedstat") as file:
        return int(file.read().split()[0]) / 1e9


def single(building_type: str, days: int, turns: int) -> dict[str, float]:
    """CPU and wall time of a step, us: of Python, of the worker, and of the environment in this process."""
    period = f"01-01..01-{days:02d}"
    env = b2b.make_env(building_type, run_period=period)
    local = b2b.make_env(building_type, run_period=period, in_process=True)
    middle = (env.layout.action_low + env.layout.action_high) / 2
    action = middle.astype(np.float32)
    best: dict[str, float] = {}

    def keep(name, seconds, steps):
        best[name] = min(best.get(name, np.inf), seconds / steps * 1e6)

    for _ in range(turns):
        env.reset()
        process, steps, step = env._core.process, env.episode_steps - 1, env.step
        worker, cpu, wall = _cpu(process), time.process_time(), time.perf_counter()
        for _ in range(steps):
            step(action)
        keep("wall", time.perf_counter() - wall, steps)
        keep("python", time.process_time() - cpu, steps)
        keep("worker", _cpu(process) - worker, steps)
        local.reset()
        core = local._core
        cpu = time.process_time()
        for _ in range(steps):
            core.step(action, False)
        keep("rust", time.process_time() - cpu, steps)
    env.close()
    local.close()
    return best


def vector(building_type: str, count: int, days: int, turns: int) -> float:
    """Steps a second of a vector environment, all its environments together."""
    envs = b2b.make_vec(building_type, count, run_period=f"01-01..01-{days:02d}")
    actions = np.broadcast_to((envs.action_space.low + envs.action_space.high) / 2, envs.action_space.shape).copy()
    best = 0.0
    for _ in range(turns):
        envs.reset(seed=0)
        steps = envs.layouts[0].data["episode_steps"] - 1
        start = time.perf_counter()
        for _ in range(steps):
            envs.step(actions)
        best = max(best, count * steps / (time.perf_counter() - start))
    envs.close()
    return best


def importing(turns: int = 5) -> float:
    """Time of ``import building2building`` in a fresh interpreter, s."""
    code = "import time; t = time.perf_counter(); import building2building; print(time.perf_counter() - t)"
    run = lambda: subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)  # noqa: E731
    return min(float(run().stdout) for _ in range(turns))


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
    parser.add_argument("--turns", type=int, default=3)
    parser.add_argument("--count", type=int, default=14, help="environments of the vector environment")
    arguments = parser.parse_args()
    print(f"import building2building: {importing():.2f} s\n")
    print("type                Env::step, us  beyond it here, us  worker, us  wall, us  reset, ms  own memory, MB")
    for each in arguments.types:
        times = single(each, arguments.days, arguments.turns)
        reset, memory = resetting(each)
        print(
            f"{each:<18}  {times['rust']:13.1f}  {times['python']:18.1f}  {times['worker']:10.1f}  "
            f"{times['wall']:8.1f}  {reset:9.2f}  {memory:14.1f}"
        )
    print(f"\nmake_vec, {arguments.count} environments, steps a second")
    for each in arguments.types:
        print(f"{each:<18}  {vector(each, arguments.count, arguments.days, arguments.turns):10.0f}")


if __name__ == "__main__":
    main()
