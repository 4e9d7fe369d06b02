import itertools
import json

import building2building as b2b
import numpy as np
import pytest
from building2building import _core
from building2building.benchmarks import (
    ActionSpaceTransfer,
    CrossDomainGeneralization,
    DynamicsAdaptation,
    GoalAdaptation,
    Problem,
    Result,
    list_problems,
)

DAY = {"windows": ["01-10..01-10"]}


@pytest.fixture
def closing():
    """Closes the environments that a test made."""
    kept = []

    def keep(envs):
        kept.extend(envs if isinstance(envs, list) else [envs])
        return envs

    yield keep
    for env in kept:
        env.close()


def test_train_and_test_sides_of_every_problem_are_disjoint():
    for name in list_problems():
        problem = Problem(name)
        train, test = problem.definition["train"], problem.definition["test"]
        pairs = [
            set(itertools.product(ids, side["tasks"], [json.dumps(side.get("restriction"))]))
            for ids, side in ((problem.train_building_ids(), train), (problem.test_building_ids(), test))
        ]
        assert pairs[0] and pairs[1] and not pairs[0] & pairs[1], name
        assert problem.changes == []


def test_training_on_a_test_building_raises():
    problem = DynamicsAdaptation("house", **DAY)
    building = problem.test_building_ids()[0]
    for make in (problem.make_train_envs, problem.make_train_vec):
        with pytest.raises(b2b.Error, match=f"{building}.*test building"):
            make(1, building_ids=[building])


def test_built_in_controllers_are_not_rescaled(tmp_path):
    with pytest.raises(b2b.Error, match="ReactiveController.*physical units"):
        DynamicsAdaptation("house", **DAY).run(b2b.ReactiveController, tmp_path, rescale_action=True)
    assert not list(tmp_path.iterdir())


def test_unknown_names_raise():
    with pytest.raises(b2b.Error, match="office-small"):
        DynamicsAdaptation("hous")
    with pytest.raises(b2b.Error, match="leave-one-out"):
        GoalAdaptation("weight")
    with pytest.raises(b2b.Error, match="Warehouse alone"):
        CrossDomainGeneralization(train_types=["Warehouse"], test_types=["Warehouse"])
    with pytest.raises(b2b.Error, match="dynamics-house"):
        Problem("dynamics-hause")
    assert CrossDomainGeneralization(2).name == "retail-to-warehouse"
    assert ActionSpaceTransfer("central", "fewer").name == "central-36-33"
    assert GoalAdaptation("leave-one-out", left_out="occupancy").definition["test"]["tasks"] == ["occupancy"]


def test_both_sides_of_a_transfer_are_one_building_with_different_actuators(closing):
    problem = ActionSpaceTransfer("unitary", "more", **DAY)
    (few,), (all_,) = closing(problem.make_train_envs(1)), closing(problem.make_test_envs())
    assert (few.action_space.shape, all_.action_space.shape) == ((5,), (10,))
    assert few.observation_space == all_.observation_space
    cores = [env.unwrapped.building._core.to_epjson() for env in (few, all_)]
    assert cores[0] == cores[1]
    reactive = b2b.rollout(all_, b2b.ReactiveController(all_))
    # Flows of the reactive controllers, with the other actuators left to them, are the reactive controllers.
    controller = b2b.ReactiveController(few)
    kept = few.kept
    seen, _ = few.reset()
    rewards = []
    for _ in range(len(reactive)):
        action = controller.physical(few.unwrapped.observation)[kept]
        seen, reward, *_ = few.step(action)
        rewards.append(reward)
    assert np.array_equal(rewards, reactive.rewards)
    with pytest.raises(b2b.Error, match="shape"):
        few.step(np.zeros(10))
    fewer = ActionSpaceTransfer("unitary", "fewer", **DAY)
    with pytest.raises(b2b.Error, match="Guideline36Controller controls all actuators"):
        fewer.evaluate(b2b.Guideline36Controller)
    with pytest.raises(b2b.Error, match="its own training tasks"):
        fewer.make_train_vec(1, task="constant")


@pytest.mark.nightly
def test_the_reactive_controllers_score_one_and_others_do_not():
    houses = {"test": ["SingleFamilyHouse-0018", "SingleFamilyHouse-0387"], **DAY}
    problem = DynamicsAdaptation(1, **houses)
    reactive = problem.evaluate(b2b.ReactiveController)
    # Their baselines are shipped, and may be from a machine that rounds differently.
    values = [*reactive.scores.values(), *reactive.resolved_scores.values(), reactive.relative_energy]
    assert values == pytest.approx([1.0] * 5, rel=1e-3)
    random = problem.evaluate(b2b.RandomController)
    assert 1 < random.resolved_interquartile_mean < random.interquartile_mean
    assert random.rms_deviation > reactive.rms_deviation
    assert list(reactive.scores) == [(each, "constant") for each in houses["test"]]


@pytest.mark.nightly
def test_a_policy_and_its_baseline_run_in_the_same_drawn_days():
    problem = DynamicsAdaptation(1, test=["SingleFamilyHouse-0018", "SingleFamilyHouse-0387"], windows=["01-10..02-20"])
    first = problem.evaluate(b2b.ReactiveController, window_days=1)
    assert list(first.scores.values()) == pytest.approx([1.0] * 2, rel=1e-9)
    again = problem.evaluate(b2b.ReactiveController, window_days=1)
    assert [each["return"] for each in first.episodes] == [each["return"] for each in again.episodes]


def test_the_relative_energy_is_a_ratio_of_sums():
    def ratio(*pairs):
        return Result("p", [{"energy": own, "baseline_energy": other} for own, other in pairs], {}).relative_energy

    assert ratio((1.0, 0.1), (100.0, 100.0)) == pytest.approx(101.0 / 100.1)
    assert ratio((1.0, 0.0), (3.0, 2.0)) == 2.0 and np.isnan(ratio((1.0, 0.0)))


def test_scores_name_the_run_period_if_there_are_several():
    def result(*periods):
        rows = [
            {"building": "x", "task": "constant", "period": each, "score": number, "resolved_score": -number}
            for number, each in enumerate(periods)
        ]
        return Result("p", rows, {})

    assert result("winter").scores == {("x", "constant"): 0}
    several = result("winter", "summer")
    assert several.scores == {("x", "constant", "winter"): 0, ("x", "constant", "summer"): 1}
    assert several.resolved_scores == {("x", "constant", "winter"): 0, ("x", "constant", "summer"): -1}


@pytest.mark.nightly
def test_training_environments_have_one_shape(closing):
    problem = DynamicsAdaptation("house", **DAY)
    envs = closing(problem.make_train_vec(2))
    observation, _ = envs.reset(seed=0)
    assert observation.shape == (2, 17) and envs.single_action_space.shape == (2,)
    given = closing(DynamicsAdaptation("house", attributes="given", **DAY).make_train_envs(1))[0]
    assert given.observation_space.shape == (34,)


@pytest.mark.nightly
def test_the_documented_training_environments_step(closing):
    envs = closing(DynamicsAdaptation("house").make_train_vec(8))
    observations, infos = envs.reset(seed=0)
    for _ in range(3):
        observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
    assert observations.shape == (8, 17) and np.isfinite(rewards).all()
    assert len(set(infos["building"])) > 4, "houses are drawn from the whole split"


@pytest.mark.parametrize(
    "problem",
    [
        GoalAdaptation("setpoint-mode", **DAY),
        DynamicsAdaptation("house", attributes="given", **DAY),
        ActionSpaceTransfer("unitary", "more", **DAY),
        pytest.param(
            CrossDomainGeneralization(
                train_types=["SingleFamilyHouse", "Warehouse"], test_types=["RestaurantFastFood"], **DAY
            ),
            marks=pytest.mark.nightly,
        ),
    ],
    ids=lambda problem: problem.name,
)
def test_every_family_trains_in_the_native_vector_environment(problem, closing):
    envs = closing(problem.make_train_vec(2, building_ids=problem.train_building_ids(2)))
    assert isinstance(envs, b2b.BuildingVectorEnv)
    observations, _ = envs.reset(seed=1)
    single = closing(problem.make_train_envs(1))[0]
    if problem.definition["family"] != "cross_domain":
        assert observations.shape[1] >= single.observation_space.shape[0]
        assert envs.single_action_space.shape == single.action_space.shape
    for _ in range(290):
        observations, rewards, _, _, info = envs.step(envs.action_space.sample())
    assert np.isfinite(observations).all() and np.isfinite(rewards).all()
    assert envs.statistics["episodes"] == 4


def test_withheld_actuators_follow_their_fallback_in_the_vector_environment(closing):
    problem = ActionSpaceTransfer("unitary", "more", **DAY)
    envs = closing(problem.make_train_vec(1, resample=False))
    single = closing(problem.make_train_envs(1))[0]
    low, high = single.action_space.low, single.action_space.high
    np.testing.assert_array_equal(envs.reset(seed=0)[0][0], single.reset(seed=0)[0])
    random = np.random.default_rng(0)
    for _ in range(30):
        action = random.uniform(-1, 1, envs.action_space.shape)
        ours, reward, *_ = envs.step(action)
        theirs, expected, *_ = single.step(low + (action[0] + 1) / 2 * (high.astype(np.float64) - low))
        np.testing.assert_allclose(ours[0], theirs, rtol=1e-5)
        assert reward[0] == pytest.approx(expected, rel=1e-4)


def test_every_name_of_a_batch_has_its_unit(closing):
    problem = ActionSpaceTransfer("unitary", "more", observation="raw", **DAY)
    metadata = closing(problem.make_train_vec(1, resample=False)).metadata
    building = closing(problem.make_train_envs(1))[0].unwrapped.metadata
    for side in ("observation", "action"):
        whole = dict(zip(building[f"{side}_names"], building[f"{side}_units"], strict=True))
        own = dict(zip(metadata[f"{side}_names"], metadata[f"{side}_units"], strict=True))
        assert own and own.items() <= whole.items()


def interquartile_mean(scores):
    cut = len(scores) // 4
    return np.sort(scores)[cut : len(scores) - cut].mean()


def test_measures_equal_numpy_s():
    random = np.random.default_rng(7)
    # By type: buildings, run periods, seeds; a building's periods are alike, and so are a seed's buildings.
    seeds = random.lognormal(0, 0.2, size=3)
    types = [
        random.lognormal(shift, 0.4, size=(count, 1, 1)) * random.lognormal(0, 0.1, size=(count, 2, 1)) * seeds
        for count, shift in ((17, 0.1), (9, 0.4))
    ]
    episodes = [
        (f"{name}-{building}", "constant", f"period {period}", seed, score, score)
        for name, scores in zip("AB", types)
        for (building, period, seed), score in np.ndenumerate(scores)
    ]
    measured = json.loads(_core.measures(episodes))
    scores = np.concatenate([scores.mean(axis=2).ravel() for scores in types])
    expected = {
        "mean": np.mean(scores),
        "median": np.median(scores),
        "interquartile_mean": interquartile_mean(scores),
        "beats_baseline": np.mean(scores < 1),
    }
    for name, value in expected.items():
        assert abs(measured["test"][name]["value"] - value) < 1e-9, name
    test = measured["test"]
    assert (test["min"], test["max"]) == pytest.approx((scores.min(), scores.max()))
    assert test["beats_baseline_count"] == np.sum(scores < 1)
    assert test["resolved"] == {name: test[name] for name in test["resolved"]}
    for point in measured["profile"]:
        assert abs(point["share"]["value"] - np.mean(scores <= point["score"])) < 1e-9

    # The same bootstrap with other draws: whole buildings within their type, and seeds once for all buildings.
    def draw():
        drawn_seeds = random.integers(3, size=3)
        drawn = [scores[random.integers(len(scores), size=len(scores))][..., drawn_seeds] for scores in types]
        return interquartile_mean(np.concatenate([scores.mean(axis=2).ravel() for scores in drawn]))

    drawn = [draw() for _ in range(5000)]
    width = np.quantile(drawn, 0.975) - np.quantile(drawn, 0.025)
    for end, share in (("low", 0.025), ("high", 0.975)):
        assert abs(measured["test"]["interquartile_mean"][end] - np.quantile(drawn, share)) < 0.06 * width


@pytest.mark.nightly
def test_raw_observations_of_houses_have_their_own_width_or_the_paper_s():
    houses = ["SingleFamilyHouse-0064", "SingleFamilyHouse-0318"]
    day = {"run_period": "01-01..01-01", "timesteps_per_hour": 1}
    for changes, width in (({}, None), ({"observation_width": 20}, 20)):
        problem = DynamicsAdaptation("house", observation="raw", train=houses, **changes)
        envs = problem.make_train_envs(2, **day)
        widths = {env.observation_space.shape[0] for env in envs}
        assert widths == {20} if width else len(widths) == 2 and widths <= {9, 10, 11}
        vector = problem.make_train_vec(2, resample=False, **day)
        assert vector.single_observation_space.shape == (max(widths),)
        for each in (*envs, vector):
            each.close()


def test_a_problem_of_operation_is_scored_at_comfort_relative_to_guideline_36():
    problem = Problem("operate-warehouse", **DAY)
    result = problem.evaluate(b2b.Guideline36Controller, n=1)
    assert result.episodes[0]["score"] == pytest.approx(1.0, abs=1e-9)
    cold = problem.evaluate(lambda observation: np.zeros(5), n=1).episodes[0]
    own, usual = cold, result.episodes[0]
    excess = own["tdis_tot"] - usual["tdis_tot"] - 0.1
    assert excess > 1
    expected = own["cost_tot"] / usual["cost_tot"] + 0.5 * excess
    assert cold["score"] == cold["resolved_score"] == pytest.approx(expected, rel=1e-9)


def test_a_test_environment_of_operation_runs_the_two_weeks_of_its_weather(closing):
    (env,) = closing(Problem("operate-warehouse").make_test_envs(1))
    assert env.unwrapped.setting.episode_steps == 14 * 288
    assert not 90 < env.unwrapped.setting.first_day < 300, "the coldest two weeks"
