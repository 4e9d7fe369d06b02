"""Writes the example building of OpenStudio with each of its template systems, to be imported as a user's model.

pip install openstudio==3.11.0
python docs/openstudio_models.py models
b2b import models --weather boston.epw --run 01-08..01-14
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import openstudio
from openstudio import model as osm

#: Systems that serve a zone each, and systems that serve all zones from one air loop.
ZONE_LOOPS = {"psz_ac": osm.addSystemType3, "psz_hp": osm.addSystemType4}
SHARED_LOOPS = {
    "pvav_reheat": osm.addSystemType5,
    "pvav_pfp": osm.addSystemType6,
    "vav_reheat": osm.addSystemType7,
    "vav_pfp": osm.addSystemType8,
}
#: Packaged terminal equipment, without an air loop.
TERMINALS = {"ptac": osm.addSystemType1, "pthp": osm.addSystemType2}


def example_without_hvac() -> Any:
    building = osm.exampleModel()
    for loop in [*building.getAirLoopHVACs()]:
        loop.remove()
    # Only now: removing the loops has removed some of the equipment, to which no reference may be left.
    for loop in [*building.getPlantLoops()]:
        loop.remove()
    for zone in building.getThermalZones():
        for item in [*zone.equipment()]:
            item.remove()
    return building


def add_loop(building: Any, add: Callable[[Any], Any], zones: list[Any]) -> None:
    loop = add(building).to_AirLoopHVAC().get()
    for zone in zones:
        loop.addBranchForZone(zone)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, add in {**ZONE_LOOPS, **SHARED_LOOPS, **TERMINALS}.items():
        building = example_without_hvac()
        zones = list(building.getThermalZones())
        if name in TERMINALS:
            add(building, zones)
        else:
            for served in [[zone] for zone in zones] if name in ZONE_LOOPS else [zones]:
                add_loop(building, add, served)
        workspace = openstudio.energyplus.ForwardTranslator().translateModel(building)
        (folder / f"{name}.idf").write_text(str(workspace))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
