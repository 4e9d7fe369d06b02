"""Buildings: of the dataset, generated, or imported."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from . import _core
from .errors import BuildingError, SettingError

#: Splits of the dataset.
SPLITS = ("train", "test", "test_small", "all")

PathLike = str | os.PathLike[str]


def list_building_types() -> list[str]:
    """Returns the names of the six building types, in the order of the paper's table."""
    return [each.name for each in _core.building_types()]


def list_places() -> dict[str, str]:
    """Returns the places with a known weather file, each with its ASHRAE 169 climate zone."""
    return dict(_core.places())


@cache
def _table(building_type: str) -> tuple[dict[str, Any], ...]:
    return tuple(_core.dataset_rows(building_type))


def list_buildings(building_type: str, split: str = "train") -> list[str]:
    """Returns the ids of the dataset's buildings of a type, such as ``OfficeSmall-0042``.

    ``split`` is ``train`` (900 buildings), ``test`` (100), ``test_small`` (8 of ``test``) or ``all``.
    """
    if split not in SPLITS:
        raise SettingError(f"unknown split `{split}`; expected {', '.join(SPLITS)}")
    rows = _table(building_type)
    if split == "test_small":
        return [row["id"] for row in rows if row["test_small"]]
    return [row["id"] for row in rows if split in ("all", row["split"])]


def _row(building_id: str) -> dict[str, Any]:
    building_type, _, _ = building_id.partition("-")
    for row in _table(building_type):
        if row["id"].lower() == building_id.lower():
            return row
    raise BuildingError(f"unknown building id `{building_id}`; ids look like {building_type}-0042")


def get_climate_zone(building_id: str) -> str | None:
    """Returns the ASHRAE 169 climate zone of a building of the dataset, such as ``5A``.

    ``None`` for houses, whose construction does not depend on it.
    """
    return _row(building_id).get("climate_zone")


def list_buildings_by_climate_zone(building_type: str, climate_zone: str | int, split: str = "train") -> list[str]:
    """Returns the ids of the dataset's buildings of a type in an ASHRAE 169 climate zone.

    ``5A`` is one zone; ``5`` stands for all of that number.
    """
    wanted = str(climate_zone).upper()
    zones = {each: get_climate_zone(each) for each in list_buildings(building_type, split)}
    known = sorted({zone for zone in zones.values() if zone is not None})
    if not any(zone.startswith(wanted) for zone in known):
        expected = f"expected one of {', '.join(known)}" if known else "houses have none"
        raise SettingError(f"no building of {building_type} is in climate zone `{climate_zone}`; {expected}")
    return [each for each, zone in zones.items() if zone is not None and zone.startswith(wanted)]


def building_parameters(building_id: str) -> dict[str, Any]:
    """Returns the parameters of a building of the dataset: its row of the dataset's table."""
    return dict(_row(building_id))


class Found(NamedTuple):
    """A building that :func:`find_building` finds."""

    name: str
    place: str | None
    weather: str | None
    allow_external: bool = False

    def build(self) -> Building:
        return find_building(self.name, self.place, self.weather, allow_external=self.allow_external)


class Generated(NamedTuple):
    """One of the buildings that a call of :func:`generate` makes."""

    number: int
    building_type: str
    total: int
    options: dict[str, Any]

    def build(self) -> Building:
        return generate(self.building_type, self.total, **self.options)[self.number]


class Building:
    """A building with its weather file, as an argument of :func:`make_env`.

    Pickles as the arguments of the function that made it.
    """

    def __init__(self, core: _core.Building, origin: Found | Generated):
        self._core = core
        self.origin = origin

    @property
    def name(self) -> str:
        """Name, such as ``OfficeSmall-0042`` or ``OfficeSmall-seed7-0001``."""
        return self._core.name

    @property
    def building_type(self) -> str | None:
        """Building type; ``None`` for an imported model."""
        return self._core.building_type

    @property
    def place(self) -> str:
        """Name of the place, or of the weather file."""
        return self._core.place

    @property
    def weather(self) -> Path:
        """Path of the weather file (EPW)."""
        return self._core.weather

    @property
    def climate_zone(self) -> str | None:
        """ASHRAE 169 climate zone, if known."""
        return self._core.climate_zone

    @property
    def parameters(self) -> dict[str, Any]:
        """Parameters of a dataset or generated building; empty for others."""
        return self._core.parameters

    def to_epjson(self) -> str:
        """Returns the EnergyPlus model as epJSON text."""
        return self._core.to_epjson()

    def __repr__(self) -> str:
        return f"Building({self.name!r}, place={self.place!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (self.origin,)

    def __deepcopy__(self, memo: dict[int, Any]) -> Building:
        return self


def _rebuild(origin: Found | Generated) -> Building:
    return origin.build()


def find_building(
    name: str, place: str | None = None, weather: PathLike | None = None, *, allow_external: bool = False
) -> Building:
    """Finds a building by its name: a building type, an id of the dataset, or the path of a model.

    A type stands at its home unless ``place`` or a ``weather`` file is given. ``allow_external`` is that of
    :func:`import_building`.
    """
    file = None if weather is None else os.fspath(weather)
    origin = Found(name, place, file, allow_external)
    return Building(_core.find_building(name, place, file, allow_external), origin)


def import_building(model: PathLike, weather: PathLike, *, allow_external: bool = False) -> Building:
    """Imports an EnergyPlus model (IDF or epJSON, version 25.2) with a weather file (EPW).

    Supported systems become controllable; the others keep the model's own controls. A model that runs code (FMU,
    Python) or names a file outside its folder raises :class:`BuildingError` unless ``allow_external``.
    """
    path = Path(model).resolve()
    if not path.is_file():
        raise BuildingError(f"{path}: no such model file")
    return find_building(os.fspath(path), None, Path(weather).resolve(), allow_external=allow_external)


def select_building(
    building_type: str | None,
    split: str = "train",
    index: int | None = None,
    building_id: str | None = None,
    place: str | None = None,
    weather: PathLike | None = None,
    building: Building | None = None,
) -> Building:
    """Returns the building that the arguments of :func:`make_env` select."""
    if building is not None:
        return building
    if building_id is not None:
        return find_building(building_id, place, weather)
    if building_type is None:
        raise SettingError("no building selected; pass a building_type, a building_id or a building")
    if index is not None:
        ids = list_buildings(building_type, split)
        if not 0 <= index < len(ids):
            raise SettingError(f"index {index} is out of range for split `{split}`; expected 0 to {len(ids) - 1}")
        return find_building(ids[index], place, weather)
    return find_building(building_type, place, weather)


def generate(
    building_type: str,
    count: int = 1,
    *,
    seed: int = 0,
    places: Sequence[str] | str | None = None,
    weather: Sequence[PathLike] | PathLike | None = None,
    parameters: dict[str, Any] | None = None,
) -> list[Building]:
    """Generates buildings of a type by Latin hypercube sampling, as for the dataset.

    ``parameters`` fixes parameters (``{"window_to_wall": 0.3}``) or narrows their ranges
    (``{"infiltration": (0.5, 1.0)}``). The same arguments give the same models, byte for byte.
    """
    made = _core.generate(building_type, count, seed, *_generator_arguments(places, weather, parameters))
    options = {"seed": seed, "places": places, "weather": weather, "parameters": parameters}
    return [Building(core, Generated(number, building_type, count, options)) for number, core in enumerate(made)]


class Generator:
    """New buildings of a type, no two of which are the same: one of the ``buildings`` of :func:`make_vec` with
    ``resample=True``. The arguments are those of :func:`generate`; the seed is that of ``reset``."""

    def __init__(
        self,
        building_type: str,
        *,
        places: Sequence[str] | str | None = None,
        weather: Sequence[PathLike] | PathLike | None = None,
        parameters: dict[str, Any] | None = None,
    ):
        self.building_type = building_type
        self._core = _core.Generator(building_type, *_generator_arguments(places, weather, parameters))

    @property
    def name(self) -> str:
        """Name, such as ``generated Warehouse``."""
        return f"generated {self.building_type}"

    def __repr__(self) -> str:
        return f"Generator({self.building_type!r})"


def _generator_arguments(
    places: Sequence[str] | str | None,
    weather: Sequence[PathLike] | PathLike | None,
    parameters: dict[str, Any] | None,
) -> tuple[list[str], list[PathLike], list[str]]:
    settings = [f"{name}={_setting_text(value)}" for name, value in (parameters or {}).items()]
    names = [places] if isinstance(places, str) else list(places or [])
    files = [weather] if isinstance(weather, (str, os.PathLike)) else list(weather or [])
    return names, files, settings


def is_dataset_id(name: str) -> bool:
    """Returns whether a name is an id of the dataset, such as ``OfficeSmall-0042``."""
    building_type, _, number = name.partition("-")
    return number.isdecimal() and building_type.lower() in (each.lower() for each in list_building_types())


def _setting_text(value: Any) -> str:
    if isinstance(value, tuple):
        return f"{value[0]}..{value[1]}"
    return str(value).lower() if isinstance(value, bool) else str(value)
