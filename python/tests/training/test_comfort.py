"""Comfort as a constraint on policies of other libraries."""

import building2building as b2b
import numpy as np
import pytest
from building2building.errors import SettingError
from building2building.learning.comfort import ComfortConstraint, Comparison

BUILDING, DAY = "OfficeSmall-0042", "01-10..01-10"
ENV = b2b.make_env(BUILDING, acting="supervisory:60", run_period=DAY)


def shifted(amount: float):
    """A policy that shifts the heating setpoint."""
    action = np.zeros(ENV.action_space.shape)
    action[ENV.metadata["action_names"].index("heating setpoint shift")] = amount
    return lambda observation: action


def test_the_guideline_itself_leaves_the_weight():
    constraint = ComfortConstraint(BUILDING, DAY)
    comparison, best = constraint.update(shifted(0.0))
    assert comparison.cost == pytest.approx(1) == comparison.score and comparison.run_period == DAY
    assert comparison.discomfort == pytest.approx(comparison.allowed) and comparison.allowed > 0
    assert not best and constraint.weight == pytest.approx(1)
    assert str(comparison).startswith("cost 1.000, discomfort ")


def test_discomfort_raises_the_weight():
    constraint = ComfortConstraint(BUILDING, DAY)
    comparison, _ = constraint.update(shifted(-1.0))
    assert comparison.discomfort > comparison.allowed and comparison.cost < 1
    ratio = (comparison.discomfort + 0.05) / (comparison.allowed + 0.05)
    assert constraint.weight == pytest.approx(min(ratio, 2)) and constraint.weight > 1


def test_the_weight_follows_within_limits_and_only_the_lowest_score_is_best():
    constraint = ComfortConstraint(BUILDING, DAY)
    steps = [
        (0.15, 1.05, 1.0, False),
        (0.35, 0.98, 2.0, True),
        (0.15, 0.98, 2.0, False),
        (0.0, 0.99, 1.0, False),
        (0.1, 0.97, 0.75, True),
    ]
    for discomfort, score, weight, is_best in steps:
        constraint.evaluate = lambda *_, d=discomfort, s=score: [Comparison(DAY, s, d, 0.15, s)]
        _, best = constraint.update(shifted(0.0))
        assert (best, constraint.weight) == (is_best, pytest.approx(weight))
    for discomfort, limit in [(9.0, 30.0), (0.0, 0.03)]:
        constraint.evaluate = lambda *_, d=discomfort: [Comparison(DAY, 1.0, d, 0.15, 1.0)]
        for _ in range(20):
            constraint.update(shifted(0.0))
        assert constraint.weight == pytest.approx(limit)


def test_environments_take_the_reward_with_the_weight_of_the_moment():
    constraint = ComfortConstraint(BUILDING, DAY)
    envs = b2b.make_vec(BUILDING, 2, acting="supervisory:60", run_period=DAY, reward=constraint.reward)
    usual = b2b.make_vec(BUILDING, 2, acting="supervisory:60", run_period=DAY)
    actions = np.full(envs.action_space.shape, -1.0)
    totals = []
    for weight in (1.0, 3.0):
        constraint.weight = weight
        for batch in (envs, usual):
            batch.reset(seed=0)
            totals.append(sum(batch.step(actions)[1] for _ in range(24)))
    np.testing.assert_allclose(totals[0], totals[1], rtol=1e-5)
    assert (totals[2] < totals[3]).all()
    envs.close(), usual.close()


def test_a_task_without_discomfort_is_an_error():
    env = b2b.make_env(BUILDING, task="occupancy", acting="residual:0.5", run_period=DAY)
    constraint = ComfortConstraint(BUILDING, DAY, task="occupancy", acting="residual:0.5")
    with pytest.raises(SettingError, match="task of operation"):
        constraint.update(lambda observation: np.zeros(env.action_space.shape))
