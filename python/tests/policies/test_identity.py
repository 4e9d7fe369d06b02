"""The identity of a policy: equal for equal code and values, and only for these."""

import functools
import os
import re
import subprocess
import sys
import textwrap
import threading
import types
from dataclasses import dataclass

import building2building as b2b
import numpy as np
import pytest
from building2building import errors
from building2building.evaluation.identity import identity_of
from texts import replaced

BASE = """
import math
import numpy as np

GAIN = 0.5
WEIGHTS = np.arange(4.0)

def clipped(value):
    return min(value, 1.0)

class Base:
    offset = 21.0

    def error(self, observation):
        return self.offset - observation[0]

class Policy(Base):
    def __init__(self, context=None):
        self.last = 0.0

    @property
    def slope(self):
        return 2.0

    def __call__(self, observation):
        return self.slope * self.error(observation)

def make(bias):
    def policy(observation, scale=3.0):
        return clipped(GAIN * observation[0] + bias) * scale * WEIGHTS[1] + math.sqrt(4.0)
    return policy
"""


def module(**changes) -> types.ModuleType:
    """The module above after replacements in its text."""
    text = replaced(BASE, dict(changes.values()))
    made = types.ModuleType("__main__")
    exec(compile(text, "policy.py", "exec"), made.__dict__)
    return made


def identities(version="", bias=1.0, **changes) -> tuple[str, str]:
    made = module(**changes)
    return identity_of(made.make(bias), version), identity_of(made.Policy, version)


def test_the_same_code_and_values_have_one_identity():
    assert identities() == identities()
    assert identities(comment=("GAIN = 0.5", "# The gain.\nGAIN = 0.5")) == identities()


@pytest.mark.parametrize(
    "function, class_, change",
    [
        (True, False, ("scale=3.0", "scale=3.5")),
        (True, False, ("GAIN = 0.5", "GAIN = 0.6")),
        (True, False, ("min(value, 1.0)", "min(value, 2.0)")),
        (True, False, ("min(value, 1.0)", "max(value, 1.0)")),
        (True, False, ("np.arange(4.0)", "np.arange(5.0)")),
        (True, False, ("math.sqrt(4.0)", "math.exp(4.0)")),
        (False, True, ("offset = 21.0", "offset = 22.0")),
        (False, True, ("self.offset - observation[0]", "self.offset + observation[0]")),
        (False, True, ("return 2.0", "return 3.0")),
    ],
)
def test_an_edit_changes_the_identity_of_what_it_concerns(function, class_, change):
    before, after = identities(), identities(edit=change)
    assert [before[0] != after[0], before[1] != after[1]] == [function, class_]


def test_the_value_of_a_closure_belongs_to_the_identity():
    assert identities(bias=1.0)[0] != identities(bias=2.0)[0]


def test_with_a_version_the_identity_covers_only_the_code():
    before = identities("1")
    assert identities("1", bias=2.0, edit=("GAIN = 0.5", "GAIN = 0.6")) == before
    assert identities("1", edit=("min(value, 1.0)", "max(value, 1.0)"))[0] != before[0]
    assert identities("1", edit=("self.offset - ", "self.offset + "))[1] != before[1]


def test_a_helper_in_another_module_of_the_user_belongs_to_the_identity(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)

    def identity(text: str) -> str:
        (tmp_path / "my_helpers.py").write_text(text)
        sys.modules.pop("my_helpers", None)
        import my_helpers

        def by_attribute(observation):
            return my_helpers.act(observation)

        scope = {"my_helpers": my_helpers, "__name__": "__main__"}
        return identity_of(
            types.FunctionType(by_attribute.__code__, scope, "policy", None, by_attribute.__closure__), ""
        )

    first = identity("def act(o):\n    return o + 1\ndef other(o):\n    return 0\n")
    assert first != identity("def act(o):\n    return o + 20\ndef other(o):\n    return 0\n")
    assert first == identity("def act(o):\n    return o + 1\ndef other(o):\n    return 100000\n")


@dataclass
class Settings:
    gain: float = 1.0


class Acting:
    def __init__(self, gain):
        self.settings, self.names = Settings(gain), {"a", "b", "c"}

    def __call__(self, observation):
        return observation * self.settings.gain


def test_an_object_is_identified_by_its_class_and_its_state():
    assert identity_of(Acting(1.0), "") == identity_of(Acting(1.0), "") != identity_of(Acting(2.0), "")
    assert identity_of(Acting(1.0), "1") == identity_of(Acting(2.0), "1")
    assert identity_of(Acting(1.0).__call__, "") != identity_of(Acting(2.0).__call__, "")


def test_partial_functions_and_decorated_ones_are_identified_by_their_parts():
    def act(observation, gain):
        return observation * gain

    assert identity_of(functools.partial(act, gain=1.0), "") != identity_of(functools.partial(act, gain=2.0), "")
    one, other = (functools.lru_cache(lambda observation: observation * 1), functools.lru_cache(lambda observation: 2))
    assert identity_of(one, "") != identity_of(other, "")


def test_an_environment_is_identified_by_its_arguments_and_not_by_its_state(make):
    env = make()

    def policy(observation):
        return env.action_space.low

    before = identity_of(policy, "")
    env.reset(seed=1)
    env.step(env.action_space.low)
    assert identity_of(policy, "") == before
    env = make(task="occupancy")
    assert identity_of(policy, "") != before


def test_the_identity_is_the_same_in_every_process(tmp_path):
    script = tmp_path / "policy.py"
    tail = """
    from building2building.evaluation.identity import identity_of
    NAMES = {"one", "two", "three", "four"}
    chosen = lambda observation: len(NAMES & {"one", "five"})
    print(identity_of(make(1.0), ""), identity_of(Policy, ""), identity_of(chosen, ""))
    """
    script.write_text(BASE + textwrap.dedent(tail))
    printed = set()
    for seed in "123":
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        ran = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True, env=environment)
        printed.add(ran.stdout)
    assert len(printed) == 1 and len(set(re.findall(r"code and values ([0-9a-f]{16})", printed.pop()))) == 3


def test_what_cannot_be_identified_is_refused_without_a_version():
    lock = threading.Lock()

    def policy(observation):
        with lock:
            return observation

    with pytest.raises(errors.SettingError, match=r"\(lock\) cannot be identified.*pass version="):
        identity_of(policy, "")
    assert identity_of(policy, "1").startswith("code ")


def test_controllers_of_this_package_are_identified_by_its_version():
    assert identity_of(b2b.ReactiveController, "") != identity_of(b2b.ConstantController, "")
    assert identity_of(np.tanh, "") == identity_of(np.tanh, "")
