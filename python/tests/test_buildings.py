"""Buildings of the dataset, generated and imported; graphs; equality with the command."""

import json
import pickle
import subprocess
import sys
import types
from pathlib import Path

import building2building as b2b
import gymnasium
import numpy as np
import pytest
from building2building import errors
from building2building.process import engine
from building_types import every_type

DAY = "01-01..01-01"


def test_the_dataset_is_listed_by_type_split_and_climate_zone():
    assert len(b2b.list_building_types()) == 6
    train, test = b2b.list_buildings("OfficeSmall"), b2b.list_buildings("OfficeSmall", "test")
    assert (len(train), len(test), len(b2b.list_buildings("OfficeSmall", "test_small"))) == (900, 100, 8)
    assert not set(train) & set(test)
    cold = b2b.list_buildings_by_climate_zone("OfficeSmall", "8", "all")
    assert cold and all(b2b.get_climate_zone(each) == "8" for each in cold)
    fifth = b2b.list_buildings_by_climate_zone("OfficeSmall", 5)
    assert {b2b.get_climate_zone(each) for each in fifth} == {"5A", "5B", "5C"}
    for building_type, zone, words in [("OfficeSmall", 9, "1A, 2A"), ("SingleFamilyHouse", 6, "houses have none")]:
        with pytest.raises(errors.SettingError, match=words):
            b2b.list_buildings_by_climate_zone(building_type, zone)
    assert 0 < b2b.building_parameters(train[0])["window_to_wall"] < 1
    with pytest.raises(errors.SettingError, match="test_small"):
        b2b.list_buildings("OfficeSmall", "valid")
    with pytest.raises(errors.BuildingError):
        b2b.list_buildings("Castle")


@pytest.mark.parametrize("building_type", every_type())
def test_an_episode_equals_the_command_s_episode(building_type, b2b_command, tmp_path):
    options = ["--period", DAY, "--task", "constant", "--controller", "random", "--seed", "5", "--json"]
    command = [b2b_command, "run", building_type, *options, "--out", tmp_path / "run"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    env = b2b.make_env(building_type, run_period=DAY, task="constant")
    trajectory = b2b.rollout(env, b2b.RandomController(env, seed=5))
    env.close()
    assert trajectory.hash() == json.loads(ran.stdout)["trajectory_hash"]


def test_a_building_is_selected_by_index(make):
    env = make("SingleFamilyHouse", split="test", index=0)
    assert env.building.name == b2b.list_buildings("SingleFamilyHouse", "test")[0]
    assert env.metadata["building"] == env.building.name


@pytest.mark.parametrize(
    "options, words",
    [
        ({"building_id": "Warehouse-0001"}, "Warehouse-0001 is of the type Warehouse, not OfficeSmall"),
        ({"building_id": "OfficeSmall-0001", "index": 3}, "index and building_id each select a building"),
        ({"building_id": "OfficeSmall-0001", "split": "test"}, "omit split"),
        ({"building": "OfficeSmall", "index": 3}, "index and building each select"),
        ({"building": "OfficeSmall", "place": "Miami"}, "already has a place; omit place"),
        ({"building": "OfficeSmall", "weather": "x.epw"}, "already has a place; omit place and weather"),
        ({"building": "Warehouse"}, "Warehouse is of the type Warehouse"),
    ],
)
def test_arguments_that_select_another_building_are_errors(options, words, make):
    if "building" in options:
        options = {**options, "building": b2b.find_building(options["building"])}
    with pytest.raises(errors.SettingError, match=words):
        make("OfficeSmall", **options)
    with pytest.raises(errors.SettingError, match="omit it or building_id"):
        make("OfficeSmall-0042", building_id="OfficeSmall-0001")


def parse_dataset_id(dataset_id):
    if "-v" not in dataset_id:
        raise ValueError("Malformed dataset ID")


class Minari:
    """The part of the package ``minari`` that ``collect`` uses."""

    dataset = types.SimpleNamespace(minari_dataset=types.SimpleNamespace(parse_dataset_id=parse_dataset_id))
    storage = types.SimpleNamespace(get_dataset_path=lambda name: Path(__file__ if name == "taken-v0" else "nowhere"))

    class StepDataCallback:
        def __call__(self, env, action=None, **_):
            return {"action": action}

    class DataCollector(gymnasium.Wrapper):
        def __init__(self, env, step_data_callback):
            super().__init__(env)
            self.begun, self.actions, self.recorded = [], [], []
            self._callback = step_data_callback()

        def reset(self, **options):
            observation, info = super().reset(**options)
            self.begun.append((info["building"], self.unwrapped.building.place))
            return observation, info

        def step(self, action):
            self.actions.append(action)
            stepped = super().step(action)
            self.recorded.append((self._callback(self.env, action=action)["action"], self.unwrapped.applied_action()))
            return stepped

        def create_dataset(self, **_):
            return self


def test_episodes_are_collected_where_the_stored_spec_says(monkeypatch):
    monkeypatch.setitem(sys.modules, "minari", Minari)
    day = {"run_period": DAY, "timesteps_per_hour": 1, "steps": 1}
    buildings = ["OfficeSmall", b2b.find_building("OfficeSmall", "Chicago", control="setpoints")]
    made = b2b.collect(b2b.RandomController, buildings[:1], "b2b/x-v0", place="Miami", control="setpoints", **day)
    assert made.begun == [("OfficeSmall+setpoints", "Miami")]
    stored = made.spec.kwargs
    assert (stored["building_id"], stored["place"], stored["control"]) == ("OfficeSmall", "Miami", "setpoints")
    with pytest.raises(errors.SettingError, match="already has a place"):
        b2b.collect(b2b.RandomController, buildings, "b2b/x-v0", place="Miami", **day)
    made = b2b.collect(b2b.RandomController, buildings, "b2b/x-v0", control="setpoints", **day)
    assert [place for _, place in made.begun] == ["Denver", "Chicago"]
    seeds = [
        b2b.collect(b2b.RandomController, ["OfficeSmall"], "b2b/x-v0", seed=seed, episodes=2, **day) for seed in (0, 1)
    ]
    drawn = [action.tolist() for made in seeds for action in made.actions]
    assert drawn[0] != drawn[1] and drawn[1] == drawn[2], "every episode has a seed of its own"
    for recorded, applied in (pair for made in seeds for pair in made.recorded):
        np.testing.assert_array_equal(recorded, applied.astype(np.float32))
    for name, words in (("b2b/x", "is not the name of a dataset"), ("taken-v0", "exists")):
        with pytest.raises(errors.SettingError, match=words):
            b2b.collect(b2b.RandomController, buildings[:1], name, **day)
    houses = ["SingleFamilyHouse-0064", "SingleFamilyHouse-0318"]
    with pytest.raises(errors.SettingError, match="SingleFamilyHouse-0318 has observations of the shape"):
        b2b.collect(b2b.ReactiveController, houses, "b2b/x-v0", **day)
    with pytest.raises(errors.SettingError, match="OfficeSmall-0001 has another action space.*omit rescale_action"):
        names = ["OfficeSmall", "OfficeSmall-0001"]
        b2b.collect(b2b.RandomController, names, "b2b/x-v0", rescale_action=False, **day)


def test_generated_buildings_have_the_given_parameters(make):
    one, other = b2b.generate("OfficeSmall", 2, seed=7, places="Miami", parameters={"window_to_wall": 0.3})
    assert one.name == "OfficeSmall-seed7-0001" and one.place == "Miami" and one.climate_zone == "1A"
    assert one.parameters["window_to_wall"] == 0.3 and one.parameters != other.parameters
    again = pickle.loads(pickle.dumps(other))
    assert again.to_epjson() == other.to_epjson() != one.to_epjson()
    env = make(None, building=other)
    env.reset()
    assert env.step(env.action_space.low)[1] < 0
    with pytest.raises(errors.BuildingError, match="window_to_wall"):
        b2b.generate("OfficeSmall", parameters={"window_to_wal": 0.3})


def test_an_imported_model_is_an_environment(make):
    package = engine.folder() / "pyenergyplus/data"
    building = b2b.import_building(
        package / "model/ASHRAE901_RestaurantFastFood_STD2019_Denver.idf", b2b.find_building("OfficeSmall").weather
    )
    env = make(None, building=building)
    observation, _ = env.reset()
    assert env.observation_space.contains(observation) and env.action_space.shape[0] >= 4
    with pytest.raises(errors.BuildingError, match="nowhere.idf"):
        b2b.import_building("nowhere.idf", building.weather)
    with pytest.raises(errors.SettingError, match="EPW file as weather, or place="):
        b2b.import_building(package / "model/ASHRAE901_RestaurantFastFood_STD2019_Denver.idf")


def test_an_edited_model_is_written_and_imported(tmp_path):
    shipped = b2b.list_engine_models()["ASHRAE901_Warehouse_STD2019_Denver"]
    out = tmp_path / "edited.epJSON"
    report = b2b.edit_model(shipped, out, infiltration=1.5, wall_u=0.3)
    effects = {each["change"]: each for each in report["changes"]}
    assert effects["wall_u"]["after"] == pytest.approx(0.3)
    assert effects["infiltration"]["after"] == pytest.approx(1.5 * effects["infiltration"]["before"])
    weather = b2b.find_building("Warehouse").weather
    assert b2b.import_building(out, weather).name == "edited"
    with pytest.raises(errors.BuildingError, match="edited.epJSON is the model itself"):
        b2b.edit_model(out, out, people=2.0)
    for arguments, words in [({}, "at least one of"), ({"wall_u": 50}, "`wall_u` is 50"), ({"people": 0}, "people")]:
        with pytest.raises(errors.Error, match=words):
            b2b.edit_model(shipped, out, **arguments)


@pytest.mark.nightly
def test_a_model_is_calibrated_to_columns_of_metered_energy(tmp_path):
    model = json.loads(b2b.find_building("Warehouse-0001").to_epjson())
    model["Timestep"] = {"Timestep": {"number_of_timesteps_per_hour": 1}}
    model["ConvergenceLimits"] = {"Limits": {"minimum_system_timestep": 60}}
    warehouse, out = tmp_path / "warehouse.epJSON", tmp_path / "calibrated.epJSON"
    warehouse.write_text(json.dumps(model))
    options = {"place": "Denver", "parameters": ["infiltration"], "iterations": 1}
    rough = b2b.calibrate(warehouse, {"month": range(1, 13), "gas_kwh": [1000.0] * 12}, out, **options)
    # A leakier warehouse burns more gas.
    metered = {"month": range(1, 13), "gas_kwh": [1.2 * kwh for kwh in rough["fuels"][0]["before_kwh"]]}
    report = b2b.calibrate(warehouse, metered, out, **options)
    (parameter,), (fuel,) = report["parameters"], report["fuels"]
    assert parameter["name"] == "infiltration" and 1.05 < parameter["multiplier"] < 3
    assert abs(fuel["after"]["nmbe_percent"]) < abs(fuel["before"]["nmbe_percent"])
    assert json.loads(out.read_text())["Zone"]
    with pytest.raises(errors.BuildingError, match="unknown column `kwh`; expected the columns month"):
        b2b.calibrate(warehouse, {"month": [1, 2], "kwh": [3, 4]}, tmp_path / "other.epJSON", place="Denver")
    assert not (tmp_path / "other.epJSON").exists()
    with pytest.raises(errors.BuildingError, match="warehouse.epJSON is the model itself"):
        b2b.calibrate(warehouse, metered, warehouse, keep_design_days=True, **options)


def test_a_weather_file_that_was_replaced_is_read_again(tmp_path):
    def sized(text):
        weather.write_text(text)
        with b2b.make_env("Warehouse", weather=weather, run_period="01-01..01-01") as env:
            return env.action_space.high.tolist()

    weather = tmp_path / "w.epw"
    first, second = (b2b.find_building("Warehouse", place=place).weather.read_text() for place in ("Denver", "Miami"))
    sizes = sized(first)
    assert sized(second) != sizes and sized(first) == sizes


def test_a_model_that_runs_code_is_refused_unless_it_is_allowed(tmp_path):
    weather = b2b.find_building("OfficeSmall").weather
    model = tmp_path / "hostile.epJSON"
    model.write_text('{"PythonPlugin:Instance": {"Plugin": {}}, "Zone": {"A": {}}}')
    with pytest.raises(errors.BuildingError, match="`Plugin` runs Python code.*allow_external"):
        b2b.import_building(model, weather)
    building = b2b.import_building(model, weather, allow_external=True)
    assert "PythonPlugin:Instance" in building.to_epjson()
    assert pickle.loads(pickle.dumps(building)).origin.allow_external


def test_every_zone_of_a_building_is_controlled_through_its_setpoints(make):
    env = make("OfficeSmall", control="setpoints", run_period=DAY).unwrapped
    assert env.building.name == "OfficeSmall+setpoints" and env.building.control == "setpoints"
    assert env.morphology.counts["setpoint_zone"] == 5 and env.action_space.shape == (10,)
    assert pickle.loads(pickle.dumps(env.building)).name == env.building.name
    env.reset(seed=0)
    env.step(np.tile(np.float32([25.0, 20.0]), 5))
    np.testing.assert_array_equal(env.applied_action(), np.tile([25.0, 25.5], 5))
    with pytest.raises(errors.SettingError, match="find_building"):
        b2b.make_env(building=b2b.find_building("OfficeSmall"), control="setpoints")
    with pytest.raises(errors.BuildingError, match="actuators or setpoints"):
        b2b.find_building("OfficeSmall", control="thermostats")


def test_a_morphology_splits_observations_and_joins_actions(office):
    graph = office.morphology
    observation, _ = office.reset()
    parts = graph.split_observation(observation)
    assert parts["unitary_zone"].shape == (5, 3)
    np.testing.assert_array_equal(parts["weather"][0], observation[6:8])
    action = office.action_space.sample()
    exact = np.clip(np.float64(action) + 1e-12, office.action_space.low, office.action_space.high)
    for each in (action, exact):
        np.testing.assert_array_equal(graph.join_actions(graph.split_action(each)), each)
    batch = graph.split_observation(np.stack([observation] * 3))
    assert batch["unitary_zone"].shape == (3, 5, 3)
    with pytest.raises(errors.ActionError, match="unitary_zone"):
        graph.join_actions({})


def test_a_morphology_converts_to_arrays_of_pytorch_geometric():
    env = b2b.make_env("OfficeMedium", run_period=DAY, task="constant")
    graph, arrays = env.morphology, env.morphology.to_pyg()
    env.close()
    assert arrays["x"]["vav_zone"].shape[0] == 15 and arrays["x"]["air_loop"].shape[0] == 3
    serves = arrays["edge_index"]["air_loop", "serves", "vav_zone"]
    assert serves.shape == (2, 15) and (arrays["edge_attr"]["air_loop", "serves", "vav_zone"] > 0).all()
    assert graph.counts["uncontrolled_zone"] == 3
    assert all(index.max() < 15 for index in arrays["edge_index"].values())


def test_a_morphology_converts_to_networkx(office):
    import networkx

    graph = office.unwrapped.morphology.to_networkx()
    assert graph.number_of_nodes() == len(office.unwrapped.morphology.nodes) and graph.name == "OfficeSmall"
    core = next(node for node, name in graph.nodes(data="name") if name == "Core_ZN")
    adjacent = [(a, b) for a, b, kind in graph.edges(data="kind") if kind == "adjacent"]
    assert {(b, a) for a, b in adjacent} == set(adjacent) and sum(a == core for a, _ in adjacent) >= 4
    assert networkx.is_weakly_connected(graph.subgraph({node for edge in adjacent for node in edge}))


def test_graph_observations_are_in_one_space_for_all_buildings():
    made = [b2b.make_env(name, run_period=DAY) for name in ("OfficeSmall", "OfficeMedium")]
    environments = [b2b.wrappers.GraphObservation(env) for env in made]
    small, medium = environments
    assert small.observation_space == medium.observation_space and small.node_columns == medium.node_columns
    for env in environments:
        graph = env.unwrapped.morphology
        observed, _ = env.reset()
        assert observed in env.observation_space and len(observed.nodes) == len(graph.nodes)
        moved, *_ = env.step(env.action_space.sample())
        np.testing.assert_array_equal(moved.edge_links, observed.edge_links)
        assert np.isfinite(moved.nodes).all() and (moved.nodes != observed.nodes).any()
        assert observed.edges[:, :-1].sum() == len(observed.edge_links) >= len(graph.edges)
        for node, row in zip(graph.nodes, observed.nodes):
            assert row[env.node_columns.index(node.node_type)] == 1
            foreign = [not column.startswith(node.node_type) for column in env.node_columns]
            assert not row[foreign].any(), node.name
        zone = next(node for node in graph.nodes if node.node_type in ("unitary_zone", "vav_zone"))
        column = env.node_columns.index(f"{zone.node_type} air_temperature")
        assert 10 < observed.nodes[graph.nodes.index(zone), column] < 35
        env.close()
    padded = b2b.wrappers.PadObservation(b2b.make_env("OfficeSmall", run_period=DAY), width=200)
    with pytest.raises(errors.SettingError, match="GraphObservation first"):
        b2b.wrappers.GraphObservation(padded)


def test_trajectories_are_read_by_name(office, tmp_path):
    trajectory = b2b.rollout(office, b2b.ReactiveController(office))
    assert len(trajectory) == 288 and trajectory.truncated
    assert trajectory.metrics["return"] == pytest.approx(trajectory.episode_return)
    assert trajectory.observed("outdoor air temperature").shape == (289,)
    assert trajectory.acted("Core_ZN supply air flow").max() > 0
    with pytest.raises(errors.SettingError, match="outdoor air temperature"):
        trajectory.observed("outdoor temperature")
    middle = b2b.callable_controller(lambda _: (office.layout.action_low + office.layout.action_high) / 2)
    constant = b2b.rollout(office, b2b.ConstantController(office), steps=10)
    assert b2b.rollout(office, middle, steps=10).hash() == constant.hash()


def test_a_trajectory_is_saved_and_loaded(office, tmp_path):
    trajectory = b2b.rollout(office, b2b.ReactiveController(office))
    trajectory.save(tmp_path / "day.npz")
    loaded = b2b.Trajectory.load(tmp_path / "day.npz")
    assert loaded.hash() == trajectory.hash() and loaded.metrics == trajectory.metrics and loaded.truncated
    np.testing.assert_array_equal(loaded.observed("outdoor air temperature"), trajectory.observations[:, 6])
    assert [each.name for each in tmp_path.iterdir()] == ["day.npz"]
    (tmp_path / "other.npz").write_text("no trajectory")
    with pytest.raises(b2b.Error, match="other.npz is not a trajectory"):
        b2b.Trajectory.load(tmp_path / "other.npz")


def test_reactive_controllers_are_tuned_and_can_be_changed(office):
    tuned = b2b.ReactiveController.tuned(office)
    assert len(tuned) == 30 and tuned["unitary.deadband"] < 0.5
    default, same, changed = (
        b2b.rollout(office, b2b.ReactiveController(office, parameters=parameters), steps=50).hash()
        for parameters in (None, tuned, {"unitary.gains.proportional": 2.0})
    )
    assert default == same != changed
    for parameters, words in [({"unitary.dedband": 1}, "unitary.deadband"), ({"unitary.deadband": 9}, "0 to 2")]:
        with pytest.raises(b2b.Error, match=words):
            b2b.ReactiveController(office, parameters=parameters)
