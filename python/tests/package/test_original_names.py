"""What users of the original Python implementation look for: docs/coming_from.md."""

import building2building as b2b
import numpy as np
import pytest
from building2building.errors import EpisodeError, ProcessError, SettingError
from building2building.wrappers import PadObservation, SubsetObservation


def test_the_engine_s_output_is_kept_after_close(make, tmp_path):
    folder = tmp_path / "engine"
    env = make("SingleFamilyHouse", keep_engine_output=folder)
    kept = b2b.rollout(env, b2b.ReactiveController(env))
    with pytest.raises(ProcessError, match="in_process"):
        env.unwrapped.snapshot()
    env.close()
    files = {path.name: path for path in folder.iterdir()}
    assert files.keys() >= {
        "model.epJSON",
        "eplusout.err",
        "eplusout.eso",
        "eplusout.sql",
        "eplustbl.htm",
        "eplusout.rdd",
    }
    assert "EnergyPlus Completed Successfully" in files["eplusout.err"].read_text()
    env = make("SingleFamilyHouse")
    assert b2b.rollout(env, b2b.ReactiveController(env)).hash() == kept.hash()


@pytest.mark.parametrize("old, new", [("easy", "house"), ("medium", "office-small"), ("hard", "office-medium")])
def test_the_error_for_an_original_difficulty_names_the_new_one(old, new):
    with pytest.raises(SettingError, match=f"`{old}`, which is called {new} here"):
        b2b.benchmarks.DynamicsAdaptation(difficulty=old)


@pytest.mark.parametrize("building_type", ["OfficeSmall", "OfficeMedium", "Warehouse"])
def test_node_types_and_kinds_of_equipment_have_names(make, building_type):
    core = make(building_type).unwrapped
    assert list(core.morphology.node_types) == [each.value for each in b2b.NodeType]
    assert {each["kind"] for each in core.description["systems"]} <= {each.value for each in b2b.SystemKind}
    zones = [node for node in core.morphology.nodes if node.node_type == b2b.NodeType.UNITARY_ZONE]
    assert bool(zones) == (building_type != "OfficeMedium")


@pytest.mark.nightly
def test_padding_by_zones_gives_every_zone_its_place(make):
    rows = {}
    for building_type in ("OfficeSmall", "RetailStandalone"):
        env = PadObservation(make(building_type, task="occupancy"), zones=8)
        observation, _ = env.reset(seed=0)
        assert env.observation_space.contains(observation)
        names = env.metadata["observation_names"]
        assert len(names) == len(observation) == 8 + 7 + 2 * 8
        for index, zone in enumerate(env.unwrapped.layout.zones):
            assert names[index] == f"{zone.name} air temperature"
            assert observation[index] == np.float32(env.unwrapped.observation[zone.temperature_slot])
            expected = [f"{zone.name} occupancy", f"{zone.name} target"] if zone.controlled else ["padding"] * 2
            assert names[15 + 2 * index : 17 + 2 * index] == expected
        padding = [slot for slot, name in enumerate(names) if name == "padding"]
        assert not observation[padding].any()
        rows[building_type] = names[8:15]
    assert rows["OfficeSmall"] == rows["RetailStandalone"]
    with pytest.raises(SettingError, match="zones is 3, but OfficeSmall has 6 zones"):
        PadObservation(make("OfficeSmall"), zones=3)
    with pytest.raises(SettingError, match="either width or zones"):
        PadObservation(make("OfficeSmall"))
    with pytest.raises(SettingError, match="first"):
        PadObservation(SubsetObservation(make("OfficeSmall"), ["time of day"]), zones=8)


def test_branches_continue_independently_and_bit_for_bit(make):
    env = make("SingleFamilyHouse")
    with pytest.raises(EpisodeError, match="call reset"):
        env.unwrapped.branch(1)
    env.reset(seed=0)
    low, high = env.action_space.low, env.action_space.high
    env.step(low)
    first, second = env.unwrapped.branch(2)
    other = second.step(high)[1]
    expected = [env.step((low + high) / 2)[1] for _ in range(3)]
    env.close()
    assert [first.step((low + high) / 2)[1] for _ in range(3)] == expected
    assert other != expected[0]
    assert first.steps == 4 and second.steps == 2
    with pytest.raises(SettingError, match="number of branches is 0"):
        first.branch(0)
    first.close()
    assert second.reset(seed=0)[0].shape == (len(second.observation),)
    second.close()


def test_models_that_come_with_the_engine_are_listed():
    models = b2b.list_engine_models()
    assert models["ASHRAE901_HotelSmall_STD2019_Denver"].is_file()
