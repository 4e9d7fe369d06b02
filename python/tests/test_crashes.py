"""Models that crash EnergyPlus raise an exception, and the interpreter lives on."""

import os
import signal
import threading
import time

import building2building as b2b
import pytest
from building2building import errors

#: A header of a weather file without its last field, which EnergyPlus reads without a check and crashes.
DAMAGED = "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0"
#: An EMS program that calls itself endlessly on 10 January.
RECURSION = b"""
EnergyManagementSystem:Program,Recurse,IF DayOfYear == 10,RUN Recurse,ENDIF;
EnergyManagementSystem:ProgramCallingManager,Call,BeginTimestepBeforePredictor,Recurse;
"""
#: EnergyPlus takes seconds to convert so many zones.
ZONES = 300_000


@pytest.fixture
def warehouse():
    return b2b.list_engine_models()["RefBldgWarehouseNew2004_Chicago"]


@pytest.fixture
def weather(tmp_path):
    """A weather file that makes EnergyPlus crash."""
    lines = b2b.find_building("Warehouse").weather.read_text().splitlines()
    damaged = [DAMAGED if line.startswith("HOLIDAYS") else line for line in lines]
    path = tmp_path / "damaged.epw"
    path.write_text("\n".join(damaged) + "\n")
    return path


def workers() -> list[int]:
    """The worker processes that this process started."""
    found = []
    for entry in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{entry}/cmdline", "rb") as file:
                arguments = file.read().split(b"\0")
        except OSError:
            continue
        if b"--b2b-worker" in arguments and arguments[arguments.index(b"--b2b-worker") + 1] == b"%d" % os.getpid():
            found.append(int(entry))
    return found


def test_a_crash_while_sizing_is_an_exception(warehouse, weather):
    building = b2b.import_building(warehouse, weather)
    with pytest.raises(errors.Error, match="RefBldgWarehouse.*SIGSEGV"):
        b2b.make_env(building=building)
    with pytest.raises(errors.EngineError, match=r"crashed \(signal 11.* while sizing RefBldgWarehouse"):
        b2b.make_env(building=building, in_process=True)


def test_a_crash_in_warm_up_is_an_exception(warehouse, tmp_path):
    model = tmp_path / "recursive.idf"
    model.write_bytes(warehouse.read_bytes() + RECURSION)
    building = b2b.import_building(model, b2b.find_building("Warehouse").weather)
    with b2b.make_env(building=building, run_period="01-02..01-02") as env:
        env.reset()
    with pytest.raises(errors.EpisodeError, match="recursive was lost.*SIGSEGV"):
        b2b.make_env(building=building, run_period="01-10..01-10")


def test_a_crash_of_a_calibration_is_an_exception(warehouse, weather, tmp_path):
    metered = {"month": range(1, 13), "gas_kwh": [1000.0] * 12}
    with pytest.raises(errors.EngineError, match="crashed .* while simulating a year of RefBldgWarehouse"):
        b2b.calibrate(warehouse, metered, tmp_path / "out.epJSON", weather=weather)
    assert not (tmp_path / "out.epJSON").exists()


def test_a_crash_of_the_converter_is_an_exception(warehouse, tmp_path):
    model = tmp_path / "large.idf"
    model.write_bytes(warehouse.read_bytes() + b"".join(b"Zone,Zone %d;\n" % number for number in range(ZONES)))
    before = set(workers())

    def crash():
        while not (new := set(workers()) - before):
            time.sleep(0.01)
        os.kill(new.pop(), signal.SIGABRT)

    crashing = threading.Thread(target=crash)
    crashing.start()
    with pytest.raises(errors.EngineError, match=r"crashed \(signal 6, an abort\) while converting .*large.idf"):
        b2b.import_building(model, b2b.find_building("Warehouse").weather)
    crashing.join()
    assert b2b.import_building(warehouse, b2b.find_building("Warehouse").weather).name == warehouse.stem
