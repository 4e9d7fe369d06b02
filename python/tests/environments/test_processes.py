"""Threads, forks, signals, and processes that are left behind."""

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import building2building as b2b
import numpy as np
import pytest
from building2building import errors

DAY = {"run_period": "01-01..01-01", "task": "constant"}


def episode(env) -> str:
    return b2b.rollout(env, b2b.RandomController(env, seed=4), steps=100).hash()


def episode_in_another_process(queue, env=None):
    env = b2b.make_env("OfficeSmall", **DAY) if env is None else env
    queue.put(episode(env))


def test_the_in_process_environment_is_identical_bit_for_bit(make, office):
    env = make(in_process=True)
    assert episode(env) == episode(office)
    refused = []

    def use():
        try:
            env.reset()
        except errors.ProcessError as error:
            refused.append(str(error))

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert refused and "thread" in refused[0]
    with pytest.raises(errors.ProcessError, match="in_process"):
        env.snapshot()


def test_several_threads_step_several_environments(make, office):
    expected = episode(office)
    envs = [make() for _ in range(3)]
    hashes = [None] * 3

    def run(index):
        hashes[index] = episode(envs[index])

    threads = [threading.Thread(target=run, args=(index,)) for index in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert hashes == [expected] * 3


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_other_processes_can_make_environments(method, office):
    context = multiprocessing.get_context(method)
    queue = context.Queue()
    process = context.Process(target=episode_in_another_process, args=(queue,))
    process.start()
    assert queue.get(timeout=120) == episode(office)
    process.join(20)
    assert process.exitcode == 0


def test_a_fork_does_not_touch_the_environments_of_its_parent(make):
    env = make()
    env.reset()
    expected = episode(env)
    env.reset()
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    process = context.Process(target=episode_in_another_process, args=(queue, env))
    process.start()
    assert queue.get(timeout=120) == expected, "reset makes processes of its own"
    process.join(20)
    env.step(env.action_space.low)

    queue = context.Queue()

    def step():
        try:
            env.step(env.action_space.low)
        except errors.ProcessError as error:
            queue.put(str(error))

    process = context.Process(target=step)
    process.start()
    assert "fork" in queue.get(timeout=60)
    process.join(20)
    env.step(env.action_space.low)


def test_a_fork_does_not_end_an_environment_in_the_process_of_its_parent(make):
    env = make(in_process=True)
    env.reset()
    child = os.fork()
    if child == 0:
        env.close()
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    env.step(env.action_space.low)
    env.reset()


@pytest.mark.parametrize("options", [{}, {"resample": True, "split": "test_small"}])
def test_a_forked_vector_environment_works_after_its_next_reset(options):
    envs = b2b.make_vec("SingleFamilyHouse", 2, rescale_action=True, timesteps_per_hour=1, **DAY, **options)
    action = np.zeros(envs.action_space.shape)

    def episode():
        envs.reset(seed=5)
        return [envs.step(action)[1].tolist() for _ in range(3)]

    def in_the_fork(queue):
        try:
            envs.step(action)
        except errors.ProcessError as error:
            queue.put(str(error))
        queue.put(episode())
        envs.close()

    expected = episode()
    queue = multiprocessing.get_context("fork").Queue()
    process = multiprocessing.get_context("fork").Process(target=in_the_fork, args=(queue,))
    process.start()
    assert "fork" in queue.get(timeout=60)
    assert queue.get(timeout=120) == expected
    process.join(20)
    assert process.exitcode == 0
    envs.step(action)
    envs.close()


def workers_of(pid: int) -> list[int]:
    """The worker processes of a process, including forked ones: its id is among their arguments."""
    found = []
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            try:
                with open(f"/proc/{entry}/cmdline", "rb") as file:
                    arguments = file.read().split(b"\0")
            except OSError:
                continue
            if b"--b2b-worker" in arguments and arguments[arguments.index(b"--b2b-worker") + 1] == b"%d" % pid:
                found.append(int(entry))
    return found


def gone_within(seconds: float, pid: int) -> bool:
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if not workers_of(pid):
            return True
        time.sleep(0.05)
    return False


def script(text: str, tmp_path) -> subprocess.Popen:
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    return subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(text)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        # Shells make background processes ignore Ctrl-C.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def interrupted(text: str, tmp_path) -> subprocess.Popen:
    """A script that gets a Ctrl-C half a second after it says that it is ready."""
    process = script(text, tmp_path)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    return process


ENV = "import building2building as b2b; env = b2b.make_env('OfficeSmall', run_period='winter'); env.reset()\n"


def test_exiting_without_close_leaves_no_process(tmp_path):
    process = script(ENV + "env.step(env.action_space.low); keep = env.snapshot()", tmp_path)
    _, err = process.communicate(timeout=120)
    assert process.returncode == 0 and err == ""
    assert gone_within(5, process.pid) and os.listdir(tmp_path) == []


def test_a_killed_program_leaves_no_process(tmp_path):
    process = script(ENV + "print('ready', flush=True); import time; time.sleep(100)", tmp_path)
    assert process.stdout.readline() == "ready\n"
    assert workers_of(process.pid)
    process.kill()
    process.communicate()
    assert gone_within(5, process.pid)
    deadline = time.monotonic() + 5
    while os.listdir(tmp_path) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert os.listdir(tmp_path) == []


def test_ctrl_c_stops_a_rollout_and_the_environment_remains_usable(tmp_path):
    process = interrupted(
        ENV
        + """
controller = b2b.ReactiveController(env)
print('ready', flush=True)
try:
    while True:
        b2b.rollout(env, controller)
except KeyboardInterrupt:
    env.reset()
    env.step(env.action_space.low)
    print('resumed', flush=True)
""",
        tmp_path,
    )
    out, err = process.communicate(timeout=30)
    assert (out, err, process.returncode) == ("resumed\n", "", 0)


def test_ctrl_c_stops_the_preparation_of_a_building(tmp_path):
    process = interrupted(
        """
import time
import building2building as b2b
begun = time.monotonic()
b2b.make_env('OfficeMedium', place='Denver').close()
whole = time.monotonic() - begun
begun = time.monotonic()
print('ready', flush=True)
try:
    b2b.make_env('OfficeMedium', place='Miami')
except KeyboardInterrupt:
    at_once = time.monotonic() - begun < 0.5 + whole / 2
    print('stopped' if at_once else 'finished', flush=True)
""",
        tmp_path,
    )
    out, err = process.communicate(timeout=30)
    assert (out, err, process.returncode) == ("stopped\n", "", 0)
    assert gone_within(5, process.pid)


@pytest.mark.nightly
def test_ctrl_c_stops_a_reset_and_the_next_one_works(tmp_path):
    # Every episode has another building, so that a reset includes its sizing and warm-up.
    process = interrupted(
        """
import building2building as b2b
from building2building.wrappers import ResampleBuildingOnResetWrapper
env = b2b.make_env('OfficeMedium', run_period='01-01..01-01', rescale_action=True)
env = ResampleBuildingOnResetWrapper(env)
env.reset(seed=0)
print('ready', flush=True)
try:
    while True:
        env.reset()
except KeyboardInterrupt:
    print('stopped', flush=True)
env.reset()
env.step(env.action_space.low)
print('resumed', flush=True)
""",
        tmp_path,
    )
    assert process.stdout.readline() == "stopped\n"
    out, err = process.communicate(timeout=60)
    assert (out, err, process.returncode) == ("resumed\n", "", 0)
    assert gone_within(5, process.pid)


def test_a_dead_process_raises_and_the_next_episode_begins(make):
    env = make()
    env.reset()
    os.kill(env._core.process, signal.SIGKILL)
    with pytest.raises(errors.EpisodeError, match="killed"):
        env.step(env.action_space.low)
    env.reset()
    env.step(env.action_space.low)


def test_a_worker_has_one_thread_and_no_numpy(office):
    office.reset()
    process = office._core.process
    with open(f"/proc/{process}/status") as file:
        assert "Threads:\t1\n" in file.read()
    with open(f"/proc/{process}/maps") as file:
        assert "numpy" not in file.read()


def test_the_package_is_imported_quickly_and_without_torch():
    code = "import sys, building2building; print(any(m in sys.modules for m in ('torch', 'matplotlib', 'pandas')))"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout == "False\n"


def test_snapshots_branch_the_simulation(make):
    env = make()
    env.reset()
    rng = np.random.default_rng(0)
    low, high = env.layout.action_low, env.layout.action_high
    for _ in range(20):
        env.step(rng.uniform(low, high))
    actions = rng.uniform(low, high, (10, len(low)))
    kept = env.snapshot()
    futures = []
    for _ in range(3):
        env.restore(kept)
        assert env.steps == 20
        futures.append([env.step(action)[0] for action in actions])
    for future in futures[1:]:
        np.testing.assert_array_equal(future, futures[0])
    kept.release()
    with pytest.raises(errors.EpisodeError, match="released"):
        env.restore(kept)
    kept = env.snapshot()
    env.set_building("OfficeSmall-0042")
    with pytest.raises(errors.EpisodeError, match="the building of the environment is now OfficeSmall-0042"):
        env.restore(kept)


def test_an_interrupted_change_of_the_building_leaves_the_present_one(make, monkeypatch):
    env = make(timesteps_per_hour=1)

    def interrupt(_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(env.unwrapped, "_set_setting", interrupt)
        env.unwrapped.set_building("OfficeSmall-0042")
    assert env.unwrapped.building.name == "OfficeSmall"
    observation, info = env.reset()
    assert info["building"] == "OfficeSmall" and env.observation_space.contains(observation)


def test_a_temporary_folder_goes_with_an_error_and_with_the_next_process_after_a_killed_one():
    from building2building.process.temporary import temporary_folder

    with pytest.raises(ZeroDivisionError), temporary_folder("test") as folder:
        (folder / "file").write_text("content")
        raise ZeroDivisionError
    assert not folder.exists()

    code = """
        import os, signal
        from building2building.process.temporary import temporary_folder
        with temporary_folder("test") as folder:
            print(folder, flush=True)
            os.kill(os.getpid(), signal.SIGKILL)
    """
    killed = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True)
    left = killed.stdout.strip()
    assert killed.returncode == -signal.SIGKILL and os.path.isdir(left)
    two_hours_ago = time.time() - 7200
    os.utime(left, (two_hours_ago, two_hours_ago))
    with temporary_folder("test"):
        assert not os.path.exists(left)
