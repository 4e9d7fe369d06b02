"""Own policies on the benchmark problems."""

import json
import subprocess

import building2building as b2b
import numpy as np
import pytest
from building2building.benchmarks import ActionSpaceTransfer, CrossDomainGeneralization

DAY = {"windows": ["01-10..01-10"]}


class WarmNodes:
    """A graph policy: every zone with an actuator gets warm air while it is below its target."""

    def __init__(self, context):
        self.graph = context.morphology
        layout = context.layout
        self.low, self.high = (self.graph.split_action(bound) for bound in (layout.action_low, layout.action_high))

    def __call__(self, observation):
        nodes = self.graph.split_observation(observation)
        actions = {}
        for node_type, low in self.low.items():
            slots = [slot.quantity for slot in self.graph.node_types[node_type].observation]
            values = nodes[node_type]
            below = values[:, slots.index("target_temperature")] - values[:, slots.index("air_temperature")]
            share = np.clip(0.5 + below, 0.0, 1.0)[:, None]
            actions[node_type] = low + share * (self.high[node_type] - low)
        return self.graph.join_actions(actions)


@pytest.mark.nightly
def test_a_user_s_graph_policy_enters_a_problem_over_types(tmp_path, b2b_command):
    problem = CrossDomainGeneralization(
        train_types=["OfficeSmall"],
        test_types=["OfficeSmall", "Warehouse"],
        train=["OfficeSmall-0001"],
        test=["OfficeSmall-0011", "Warehouse-0004"],
        **DAY,
    )
    entry = {"training_steps": 1000, "description": "one rule", "jobs": 2}
    result = problem.run(WarmNodes, tmp_path / "entry", **entry)
    assert result["name"] == "WarmNodes" and result["training_steps"] == 1000
    assert {each["building"] for each in result["measures"]["scores"]} == {"OfficeSmall-0011", "Warehouse-0004"}
    assert all(each["score"] > 0 for each in result["measures"]["scores"])
    assert problem.run(WarmNodes, tmp_path / "entry", **entry) == result

    verified = subprocess.run(
        [b2b_command, "benchmark", "verify", tmp_path / "entry", "--json"], capture_output=True, text=True
    )
    assert verified.returncode == 1, verified.stderr + verified.stdout
    checks = {each["check"]: each for each in json.loads(verified.stdout)["checks"]}
    again = checks["episodes run again"]
    assert all(each["passed"] for each in checks.values() if each is not again)
    assert again["unverified"] and not again["passed"]
    assert "not run again: the policy `WarmNodes` is the author's own program" in again["message"]


def test_a_user_s_function_gets_what_a_problem_leaves_to_the_agent(tmp_path):
    problem = ActionSpaceTransfer("unitary", "fewer", **DAY)
    widths = set()

    def middle(observation):
        widths.add(observation.shape)
        return np.zeros(5)

    result = problem.run(middle, tmp_path / "entry", train_policy=lambda _: np.zeros(10), rescale_action=True)
    assert len(widths) == 1 and result["measures"]["test"]["min"] > 0
    with pytest.raises(b2b.Error, match="5"):
        problem.run(lambda _: np.zeros(10), tmp_path / "other", rescale_action=True, name="wide")


def test_an_exception_of_the_policy_ends_the_run(tmp_path):
    def broken(observation):
        raise ZeroDivisionError("in the policy")

    with pytest.raises(ZeroDivisionError, match="in the policy"):
        ActionSpaceTransfer("unitary", "more", **DAY).run(broken, tmp_path / "entry")
    with pytest.raises(b2b.Error, match="expected a function or a controller class"):
        ActionSpaceTransfer("unitary", "more", **DAY).run("reactive", tmp_path / "entry")  # type: ignore[arg-type]


def test_a_controller_of_an_environment_is_refused(office, tmp_path):
    with pytest.raises(b2b.errors.SettingError, match="ReactiveController belongs to an environment; pass the class"):
        ActionSpaceTransfer("unitary", "more", **DAY).run(b2b.ReactiveController(office), tmp_path / "entry")
