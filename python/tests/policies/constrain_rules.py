"""Rules of ConStrain on trajectories of ``guideline36``. Prints a JSON list with one object per rule and subject.

Runs in an environment with the package ConStrain, which ``test_guideline_rules.py`` makes. The package's classes judge.
Rules that it lists without a class are implemented here from their descriptions (``schema/library.json``) and marked
``"written_out"``.

Flows are shares of the design flow at terminals, and m³/s of outdoor air. A command follows from the observation
before the step, which is the row before. Tracking is judged in kelvin: the package's 5 % of a setpoint would depend on
the unit.
"""

import json
import logging
import sys
import warnings
from dataclasses import dataclass
from importlib import import_module, resources
from pathlib import Path

warnings.simplefilter("ignore")
logging.disable(logging.CRITICAL)

import numpy as np  # noqa: E402
import pandas as pd  # noqa: E402

MODES = dict(enumerate(["occupied", "cooldown", "setup", "warmup", "setback", "freeze", "unoccupied"], start=1))
DECISION = "decision: "
DENSITY = 1.2
# Climate zone 5B (ASHRAE 90.1): the buildings are in Denver.
ECONOMIZER_LIMIT = 24.0
# Deviation from the band beyond which a step counts as unmet, K.
UNMET = 0.5
TOLERANCES = json.loads(resources.files("constrain").joinpath("tolerances.json").read_text())
MODULES = {
    "SupplyAirTempReset": "supply_air_temp_reset",
    "AutomaticOADamperControl": "automatic_oa_damper_controls",
    "VentilationFanControl": "ventilation_fan_controls",
    "ZoneTempControl": "zone_temp_control",
}


@dataclass
class System:
    """A system with its zones, as the columns of the decisions name them."""

    name: str
    zones: list[str]
    is_air_handler: bool


def read(folder):
    """Returns the steps of a run, and the rows before them."""
    steps = pd.read_parquet(Path(folder) / "trajectory.parquet")
    steps.index = pd.Timestamp("2017-01-01") + pd.to_timedelta(5 * np.arange(len(steps)), unit="min")
    return steps.iloc[1:], steps.shift(1).iloc[1:]


def systems(steps):
    """Returns the systems in the order of the columns: a system's mode precedes its zones."""
    found = []
    for column in (column[len(DECISION) :] for column in steps if column.startswith(DECISION)):
        if column.endswith(" mode"):
            found.append(System(column.removesuffix(" mode"), [], False))
        elif column.endswith(" t_max"):
            found[-1].is_air_handler = True
        elif column.endswith(" cooling loop"):
            found[-1].zones.append(column.removesuffix(" cooling loop"))
    return found


def judge(rule, **points):
    """Returns the verdict of a class of the package, with the numbers of failed and tested samples."""
    module = import_module(f"constrain.library.{MODULES.get(rule, rule)}")
    case = getattr(module, rule)(pd.DataFrame(points), tolerances=TOLERANCES)
    verdict, result = case.check_bool(), case.result
    tested = result[result != "Untested"]
    return {
        "rule": rule,
        "passed": None if isinstance(verdict, str) else bool(verdict),
        "failed": int((tested == False).sum()),  # noqa: E712
        "tested": len(tested),
    }


def written_out(rule, fails, tested):
    """Returns the verdict of a rule that is implemented here, from its failed and tested samples."""
    failed, tested = int(fails.sum()), int(tested.sum())
    return {
        "rule": rule,
        "written_out": True,
        "passed": failed == 0 if tested else None,
        "failed": failed,
        "tested": tested,
    }


def of_air_handler(steps, before, system):
    """Rules of an air handler: supply air temperature, fan, economizer and outdoor air."""

    def decided(word):
        return steps[f"{DECISION}{system.name} {word}"]

    mode, setpoint, outdoor = (
        decided("mode").round().map(MODES),
        decided("supply air temperature setpoint"),
        before["outdoor air temperature"],
    )
    cools = (steps[[f"{DECISION}{zone} cooling loop" for zone in system.zones]] > 0).any(axis=1)
    flow = steps[[f"{zone} damper opening" for zone in system.zones]].sum(axis=1)
    people = before[[f"{zone} occupancy" for zone in system.zones]].sum(axis=1)
    outdoor_air, minimum = steps[f"{system.name} outdoor air flow"] / DENSITY, decided("minimum outdoor air") / DENSITY
    # Without a zone that cools, the setpoint stays at t_max; without one that needs heat, the coil warms no outdoor air
    # (docs/guideline36.md).
    heats = pd.concat([before[f"{z} air temperature"] < steps[f"{z} heating setpoint"] for z in system.zones], axis=1)
    reset = (cools & heats.any(axis=1)) | ~mode.isin(["occupied", "setup"])
    untempered = ~mode.isin(["warmup", "setback", "freeze"])
    highest = np.where(untempered, decided("t_max"), np.inf)
    yield written_out("SupplyAirTemperatureWithinReset", ~setpoint.between(12.0, highest), untempered)
    yield judge(
        "G36SupplyAirTemperatureSetpoint",
        mode_operation=mode[reset],
        temperature_air_supply_max=decided("t_max")[reset],
        temperature_air_supply_setpoint_cool_max=18.0,
        temperature_air_supply_setpoint_cool_min=12.0,
        temperature_air_outdoor=outdoor[reset],
        temperature_air_outdoor_supply_min=16.0,
        temperature_air_outdoor_supply_max=21.0,
        temperature_air_supply_setpoint=setpoint[reset],
    )
    # Without people, the fan runs while a loop has output, and a mode may last a step longer (docs/guideline36.md).
    outputs = steps[[f"{DECISION}{zone} {side} loop" for zone in system.zones for side in ("heating", "cooling")]]
    needed = (outputs > 0).any(axis=1) | mode.isin(["occupied", "unoccupied"])
    status = {"mode_operation": mode[needed], "status_fan_supply": flow[needed] > 0}
    yield judge("G36SupplyFanStatus", flag_reheat_perimeter=True, **status)
    yield judge(
        "G36MinOAwEconomizer",
        temperature_air_outdoor=outdoor,
        temperature_air_economizer_limit=ECONOMIZER_LIMIT,
        position_damper_air_outdoor=outdoor_air,
        position_damper_air_outdoor_min=minimum,
        flow_volumetric_air_outdoor=outdoor_air,
        flow_volumetric_air_outdoor_setpoint_min=minimum,
        mode_operation=mode,
    )
    yield judge(
        "AutomaticOADamperControl",
        number_occupants=people,
        status_economizer=decided("economizer enabled"),
        flow_volumetric_air_outdoor=outdoor_air,
        flow_volumetric_air_exhaust=0.0,
    )
    economizes = outdoor_air > minimum + TOLERANCES["airflow"]["types"]["outdoor_air"]
    hot = outdoor > ECONOMIZER_LIMIT
    yield written_out("EconomizerHighLimitA", economizes & hot, hot)


def of_terminal(steps, before, system, zone):
    """Rules of a terminal: its flow, and its coil off while the zone cools."""
    opening, temperature = steps[f"{zone} damper opening"], before[f"{zone} air temperature"]
    mode = steps[f"{DECISION}{system.name} mode"].round().map(MODES)
    heating, cooling = (steps[f"{DECISION}{zone} {side} loop"] for side in ("heating", "cooling"))
    supply = steps[f"{DECISION}{system.name} supply air temperature setpoint"]
    # The coil holds its setpoint by itself, ahead of the loop.
    coil = (opening > 0) & (steps[f"{zone} heating setpoint"] > temperature)
    points = {
        "mode_operation": mode,
        "state_zone": np.where(cooling > 0, "cooling", np.where(coil | (heating > 0), "heating", "deadband")),
        # The minimum for ventilation, less a margin for rounding.
        "flow_volumetric_air_setpoint_min": opening[mode == "occupied"].min() - 1e-9,
        "flow_volumetric_air_setpoint": opening,
        "temperature_air_discharge": supply,
        "temperature_air_discharge_setpoint_min": 10.0,
        "command_coil_heat": 100.0 * coil,
    }
    yield judge("G36ReheatTerminalBoxCoolingAirflowSetpoint", flow_volumetric_air_cool_max=1.0, **points)
    yield judge("G36ReheatTerminalBoxDeadbandAirflowSetpoint", **points)
    yield judge(
        "G36TerminalBoxCoolingMinimumAirflow",
        temperature_air_supply_setpoint=supply,
        temperature_air_room=temperature,
        **points,
    )


def of_zone(steps, before, system, zone):
    """Rules of a zone: its setpoints, its loops, and its fan or damper without people and load."""

    def decided(word):
        return steps[f"{DECISION}{zone} {word}"]

    heating, cooling, temperature = decided("heating loop"), decided("cooling loop"), before[f"{zone} air temperature"]
    low, high = before[f"{zone} band heating setpoint"], before.get(f"{zone} band cooling setpoint", np.inf)
    yield judge("G36SimultaneousHeatingCooling", output_coil_heating=1000 * heating, output_coil_cooling=1000 * cooling)
    outside = np.maximum(low - temperature, 0) + np.maximum(temperature - high, 0)
    # The package's threshold is 5 % of the setpoint.
    yield judge("LocalLoopUnmetHours", value_sensor=1 + 0.05 * outside / UNMET, value_setpoint=1.0)
    saturation = {"value_sensor": temperature, "command_max": 1.0}
    yield judge(
        "LocalLoopSaturationDirectActingMax", value_setpoint=high + UNMET, command_control=cooling, **saturation
    )
    yield judge(
        "LocalLoopSaturationReverseActingMax", value_setpoint=low - UNMET, command_control=heating, **saturation
    )
    if f"{zone} band cooling setpoint" in steps:
        in_use = {
            f"temperature_air_zone_{side}_setpoint": decided(f"{side}ing setpoint in use") for side in ("heat", "cool")
        }
        yield judge("ZoneTempControl", **in_use)
    flow = steps.get(f"{zone} damper opening", steps.get(f"{zone} supply air flow"))
    if flow is None:
        return
    # Before or after the step, because people may arrive during it.
    people = sum(seen[[f"{each} occupancy" for each in system.zones]].sum(axis=1) for seen in (before, steps))
    # Any output is a load, and any flow takes power.
    load, power = 1e3 * (heating + cooling > 0), 1e3 * (flow > 0)
    yield judge("VentilationFanControl", heat_sensible=load, number_occupants=people, power_fan=power)
    empty = people == 0
    idle, needed = empty & (outside == 0) & (heating + cooling == 0), empty & (outside > UNMET)
    yield written_out("NightCycleOperation", (idle & (flow > 0)) | (needed & (flow == 0)), idle | needed)


def of_run(folder):
    """The rules of all systems and zones of a run."""
    steps, before = read(folder)
    for system in systems(steps):
        if system.is_air_handler:
            yield from ({"subject": system.name, **row} for row in of_air_handler(steps, before, system))
        for zone in system.zones:
            rows = list(of_zone(steps, before, system, zone))
            if system.is_air_handler:
                rows += of_terminal(steps, before, system, zone)
            yield from ({"subject": zone, **row} for row in rows)


def resets(folders):
    """Judges over all runs of a building whether supply air temperatures are reset, and economizers work with coils."""
    runs = [read(folder) for folder in folders]
    for system in (system for system in systems(runs[0][0]) if system.is_air_handler):
        column = f"{DECISION}{system.name} supply air temperature setpoint"
        cooling = [steps[column][steps[f"{DECISION}{system.name} mode"].round().isin([1, 2, 3])] for steps, _ in runs]
        setpoints = pd.concat(cooling, ignore_index=True)
        setpoints.index = pd.date_range("2017-01-01", periods=len(setpoints), freq="5min")
        row = judge(
            "SupplyAirTempReset",
            temperature_air_supply_setpoint=setpoints,
            temperature_air_zone_design_cool_setpoint=24.0,
        )
        yield {"subject": system.name, **row}
        integrated = sum(works_along(steps, before, system) for steps, before in runs)
        yield {
            "subject": system.name,
            "rule": "IntegratedEconomizerControl",
            "written_out": True,
            "passed": bool(integrated),
            "failed": 0,
            "tested": int(integrated),
        }


def works_along(steps, before, system):
    """Returns the number of steps with more than minimum outdoor air that is too warm to cool without the coil."""
    supply, minimum = (
        steps[f"{DECISION}{system.name} {word}"] for word in ("supply air temperature setpoint", "minimum outdoor air")
    )
    return int(
        (
            (steps[f"{system.name} outdoor air flow"] > minimum + 0.03) & (before["outdoor air temperature"] > supply)
        ).sum()
    )


def main(root):
    """Prints the verdicts of the runs in a folder, ``BUILDING/PERIOD`` each."""
    rows = []
    for building in sorted(path for path in Path(root).iterdir() if path.is_dir()):
        runs = sorted(building.iterdir())
        for run in runs:
            rows += ({"building": building.name, "period": run.name, **row} for row in of_run(run))
        rows += ({"building": building.name, "period": "all", **row} for row in resets(runs))
    json.dump(rows, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1])
