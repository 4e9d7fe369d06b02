"""Training from Python, and agents as controllers and policies."""

import re
import sys

import building2building as b2b
import numpy as np
import pytest
from building2building.errors import EvaluationError, SettingError

HOUSE = "SingleFamilyHouse-0014"
DAYS = "01-10..01-11"
SMALL = {
    "task": "occupancy",
    "run_period": DAYS,
    "environments": 2,
    "window_days": 1,
    "window_starts": 2,
    "checkpoint_every": 192,
    "evaluation": {"every": 384, "days": 1},
    "ppo": {"n_steps": 96, "batch_size": 64, "epochs": 2},
}


@pytest.fixture(scope="module")
def agent(tmp_path_factory):
    out = tmp_path_factory.mktemp("runs") / "run"
    return b2b.train(HOUSE, out=out, steps=np.int64(384), keep="last", **SMALL)


def test_an_agent_acts_as_in_its_evaluation(agent):
    env = b2b.make_env(building_id=HOUSE, task="occupancy", run_period=DAYS)
    trajectory = b2b.rollout(env, agent.controller(env))
    evaluation = b2b.evaluate(agent, HOUSE, "occupancy", run_periods=DAYS)
    assert evaluation.rows[0]["return"] == pytest.approx(sum(trajectory.rewards), rel=1e-12)
    assert evaluation.rows[0]["score"] == agent.summary["score"]
    assert agent.info["training"]["steps"] == 384 and agent.info["training"]["buildings"] == HOUSE


def test_an_agent_acts_alike_in_a_rescaled_environment(agent):
    actions = []
    for rescale in (False, True):
        env = b2b.make_env(building_id=HOUSE, task="occupancy", run_period=DAYS, rescale_action=rescale)
        controller, (observation, _) = agent.controller(env), env.reset()
        for _ in range(20):
            observation, *_ = env.step(controller(observation).astype(env.action_space.dtype))
        actions.append(env.unwrapped.applied_action())
    np.testing.assert_allclose(actions[0], actions[1], rtol=1e-4)


@pytest.mark.nightly
def test_an_agent_with_a_forecast_needs_the_weather_of_its_environment(tmp_path):
    options = {**SMALL, "observation": {"form": "features", "forecast": 2}}
    agent = b2b.train(HOUSE, out=tmp_path / "run", steps=192, **options)
    env = b2b.make_env(building_id=HOUSE, task="occupancy", run_period=DAYS)
    assert len(b2b.rollout(env, agent.controller(env), steps=5)) == 5
    weather = env.unwrapped.building.weather
    drawn = b2b.make_env(building_id=HOUSE, task="occupancy", run_period=DAYS, weather_years=[weather])
    with pytest.raises(SettingError, match="observes a forecast"):
        agent.controller(drawn)


def test_a_building_that_the_agent_was_not_made_for_is_an_error(agent):
    env = b2b.make_env("OfficeSmall", run_period="01-10..01-10")
    with pytest.raises(EvaluationError, match=f"trained on {HOUSE}"):
        agent.controller(env)
    with pytest.raises(EvaluationError, match="not the folder of an agent"):
        b2b.Agent.load("nowhere")


def test_a_callback_sees_every_update_and_can_end_the_run(tmp_path):
    seen = []

    def callback(update):
        seen.append(update)
        return len(seen) < 2

    with pytest.raises(KeyboardInterrupt):
        b2b.train(HOUSE, out=tmp_path / "run", steps=100_000, callback=callback, **SMALL)
    assert [update["steps"] for update in seen[:2]] == [192, 384]
    assert seen[0]["policy_loss"] != 0 and "score" in seen[1]
    done = seen[-1]["steps"]
    with pytest.raises(SettingError, match=f"it has {done} steps, more than `steps`, 192"):
        b2b.train(out=tmp_path / "run", resume=True, steps=192)
    agent = b2b.train(out=tmp_path / "run", resume=True, steps=done + 192)
    assert agent.summary["steps"] == done + 192


def test_the_exception_of_a_callback_ends_the_run(tmp_path):
    def callback(_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        b2b.train(HOUSE, out=tmp_path / "run", steps=100_000, callback=callback, **SMALL)


def test_the_exception_of_a_callback_at_the_last_update_is_raised(tmp_path):
    def callback(_):
        raise RuntimeError("at the end")

    with pytest.raises(RuntimeError, match="at the end"):
        b2b.train(HOUSE, out=tmp_path / "run", steps=192, callback=callback, **SMALL)


def test_invalid_options_are_errors(tmp_path):
    for options, message in [
        ({"enviroments": 3}, "did you mean `environments`"),
        ({"preset": "papper"}, "unknown preset"),
        ({"acting": {"kind": "residual", "authority": 2}}, "authority"),
        ({"task": {"comfort_bend": 1.0}}, "comfort_bend"),
        ({"steps": object()}, "not a valid configuration value"),
        ({"resume": True, "seed": 3}, "remove seed"),
        ({"jobs": -1}, "jobs is -1; expected 1 or more"),
    ]:
        with pytest.raises(SettingError, match=message):
            b2b.train(None if options.get("resume") else HOUSE, out=tmp_path / "run", **options)
    with pytest.raises(SettingError, match="is prepared already; pass its name"):
        b2b.train(b2b.find_building("OfficeSmall"), out=tmp_path / "run")


@pytest.mark.nightly
def test_the_configuration_of_a_run_can_be_given_back(tmp_path, capsys):
    first = b2b.train(HOUSE, out=tmp_path / "first", steps=1.92e2, progress=True, **SMALL)
    shown = capsys.readouterr().err
    assert "computing baselines" in shown and "192 steps" in shown and "score" in shown
    assert first.summary["steps"] == 192
    config = tmp_path / "first" / "config.toml"
    again = b2b.train(config=config, out=tmp_path / "again")
    assert capsys.readouterr().err == ""
    weights = "weights.safetensors"
    assert (again.path / weights).read_bytes() == (first.path / weights).read_bytes()
    assert (again.path / "config.toml").read_bytes() == config.read_bytes()
    text = config.read_text()
    other = b2b.train(config=config, out=tmp_path / "other", seed=7)
    assert (other.path / "config.toml").read_text() == re.sub("^seed = 0$", "seed = 7", text, count=1, flags=re.M)
    if sys.version_info >= (3, 11):
        import tomllib

        options = tomllib.loads(config.read_text())
        b2b.train(**options, out=tmp_path / "options")
        assert (tmp_path / "options" / "config.toml").read_bytes() == config.read_bytes()


@pytest.mark.nightly
def test_a_callback_is_called_with_progress_too(tmp_path):
    seen = []
    b2b.train(HOUSE, out=tmp_path / "run", steps=192, progress=True, callback=seen.append, **SMALL)
    assert [update["steps"] for update in seen] == [192]
