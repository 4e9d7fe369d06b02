"""Calls of the package under a type checker."""

import subprocess
import sys

import pytest

RIGHT = """
import building2building as b2b
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

env = b2b.make_env("OfficeSmall", task={"setpoints": {"mode": "occupancy"}}, index=3, rescale_action=True)
observation, info = env.reset(seed=0)
row: NDArray[np.float32] = observation
space: Box = env.observation_space
observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
temperature: float = env.layout.temperatures[0] + reward
envs = b2b.make_vec("OfficeSmall", 4, task=["constant", "occupancy"], normalize=True)
b2b.ReactiveController(env, parameters={"unitary.deadband": 0.5})
lost = b2b.evaluate("reactive", "OfficeSmall", seeds=[0, 1], folder="results").column("lost")
"""

WRONG = {
    'b2b.make_env("OfficeSmall", tsk=1)': 'Unexpected keyword argument "tsk"',
    'b2b.make_env("OfficeSmall", index="three")': 'Argument "index" to "make_env" has incompatible type "str"',
    'b2b.make_env(["OfficeSmall"])': 'Argument 1 to "make_env" has incompatible type',
    'b2b.make_vec("OfficeSmall", num_env=2)': 'Unexpected keyword argument "num_env"',
    'b2b.make_vec("OfficeSmall", 2, task=3)': 'Argument "task" to "make_vec" has incompatible type "int"',
    'b2b.evaluate("reactive", "OfficeSmall", seed=1)': 'Unexpected keyword argument "seed"',
    'b2b.evaluate("reactive", "OfficeSmall", jobs="2")': 'Argument "jobs" to "evaluate" has incompatible type "str"',
}


@pytest.fixture(scope="module")
def mypy(tmp_path_factory):
    folder = tmp_path_factory.mktemp("typing")

    def check(text):
        (folder / "call.py").write_text(text)
        command = [
            sys.executable,
            "-m",
            "mypy",
            "--strict",
            "--config-file=",
            "--cache-dir",
            folder / "cache",
            "call.py",
        ]
        return subprocess.run(command, cwd=folder, capture_output=True, text=True).stdout

    return check


@pytest.mark.nightly
def test_right_calls_pass_and_wrong_ones_are_named(mypy):
    assert "Success" in mypy(RIGHT)
    errors = mypy("import building2building as b2b\n" + "\n".join(WRONG)).splitlines()
    for line, (call, expected) in enumerate(WRONG.items(), start=2):
        assert any(error.startswith(f"call.py:{line}:") and expected in error for error in errors), (call, errors)
