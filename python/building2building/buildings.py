"""Buildings: the dataset, generated ones, and your own."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

from . import _core
from .errors import BuildingError, SettingError

#: Parts of the dataset.
SPLITS = ("train", "test", "test_small", "all")


def list_building_types() -> list[str]:
    """The six types, in the order of the paper's table."""
    return [name for name, _, _ in _core.building_types()]


def list_places() -> dict[str, str]:
    """Places that a type can stand at, each with its climate zone of ASHRAE 169."""
    return dict(_core.places())


@cache
def _table(building_type: str) -> tuple[dict[str, str], ...]:
    columns, rows = _core.dataset_table(building_type)
    return tuple({name: cell for name, cell in zip(columns, row) if cell} for row in rows)


def list_buildings(building_type: str, split: str = "train") -> list[str]:
    """Ids of the dataset's buildings of a type, such as ``OfficeSmall-0042``.

    ``split`` is ``train`` (900), ``test`` (100), ``test_small`` (8 of the test) or ``all``.
    """
    if split not in SPLITS:
        raise SettingError(f"there is no split `{split}`: give {', '.join(SPLITS)}")

    def belongs(row):
        return split == "all" or row["split"] == split or (split == "test_small" and row["test_small"] == "true")

    return [row["id"] for row in _table(building_type) if belongs(row)]


def _row(building_id: str) -> dict[str, str]:
    building_type, _, _ = building_id.partition("-")
    for row in _table(building_type):
        if row["id"].lower() == building_id.lower():
            return row
    raise BuildingError(f"there is no building `{building_id}`: ids are like {building_type}-0042")


def get_climate_zone(building_id: str) -> str | None:
    """Climate zone of ASHRAE 169 of a building of the dataset, such as ``5A``; ``None`` for houses, which are not
    built by it."""
    return _row(building_id).get("climate_zone")


def list_buildings_by_climate_zone(building_type: str, climate_zone: str, split: str = "train") -> list[str]:
    """Ids of a type in one climate zone, such as ``5A``."""
    return [each for each in list_buildings(building_type, split) if get_climate_zone(each) == climate_zone]


def building_parameters(building_id: str) -> dict[str, Any]:
    """What a building of the dataset is made of: its row in the table, numbers as numbers."""
    return {name: _value(cell) for name, cell in _row(building_id).items()}


def _value(cell: str):
    if cell in ("true", "false"):
        return cell == "true"
    try:
        return float(cell)
    except ValueError:
        return cell


class Building:
    """A building with its weather, to give to :func:`make_env`. Pickles as how it was found or made."""

    def __init__(self, core: _core.Building, recipe: tuple):
        self._core = core
        self._recipe = recipe

    @property
    def name(self) -> str:
        """Name, such as ``OfficeSmall-seed7-0001``."""
        return self._core.name

    @property
    def building_type(self) -> str | None:
        """Type; ``None`` for a model of your own."""
        return self._core.building_type

    @property
    def place(self) -> str:
        """Name of the place, or of the weather file."""
        return self._core.place

    @property
    def weather(self) -> Path:
        """The weather file (EPW)."""
        return self._core.weather

    @property
    def climate_zone(self) -> str | None:
        """Climate zone of ASHRAE 169, where it is known."""
        return self._core.climate_zone

    @property
    def parameters(self) -> dict[str, Any]:
        """What it was made of; empty for a base model and for a model of your own."""
        return {name: _value(cell) for name, cell in self._core.parameters.items()}

    def to_epjson(self) -> str:
        """The model as EnergyPlus reads it."""
        return self._core.to_epjson()

    def __repr__(self) -> str:
        return f"Building({self.name!r}, place={self.place!r})"

    def __reduce__(self):
        return _rebuild, self._recipe

    def __deepcopy__(self, memo):
        return self


def _rebuild(kind: str, *arguments) -> Building:
    if kind == "found":
        return find_building(*arguments)
    *rest, number = arguments
    return generate(*rest[:2], **rest[2])[number]


def find_building(name: str, place: str | None = None, weather: str | os.PathLike | None = None) -> Building:
    """A building by its name: a type (at its home, at ``place``, or under a ``weather`` file), an id of the dataset, or
    the path of a model."""
    weather = None if weather is None else os.fspath(weather)
    return Building(_core.find_building(name, place, weather), ("found", name, place, weather))


def import_building(model: str | os.PathLike, weather: str | os.PathLike) -> Building:
    """A building of your own: an EnergyPlus model (IDF or epJSON, version 25.2) under a weather file (EPW).

    As much of it is driven as can be; what is left keeps its own controls.
    """
    path = Path(model).resolve()
    if not path.is_file():
        raise BuildingError(f"{path}: there is no such model file")
    return find_building(os.fspath(path), None, Path(weather).resolve())


def generate(
    building_type: str,
    count: int = 1,
    *,
    seed: int = 0,
    places: list[str] | str | None = None,
    weather: list[str] | str | None = None,
    parameters: dict[str, Any] | None = None,
) -> list[Building]:
    """Buildings of a type, drawn by a Latin hypercube as those of the dataset.

    ``parameters`` fixes some (``{"window_to_wall": 0.3}``) or narrows them (``{"infiltration": (0.5, 1.0)}``). The
    same arguments give the same bytes.
    """

    def listed(given):
        return [given] if isinstance(given, (str, os.PathLike)) else list(given or [])

    def text(value):
        if isinstance(value, tuple):
            return f"{value[0]}..{value[1]}"
        return str(value).lower() if isinstance(value, bool) else str(value)

    settings = [f"{name}={text(value)}" for name, value in (parameters or {}).items()]
    files = [os.fspath(file) for file in listed(weather)]
    made = _core.generate(building_type, count, seed, listed(places), files, settings)
    options = {"seed": seed, "places": places, "weather": weather, "parameters": parameters}
    return [Building(core, ("generated", building_type, count, options, number)) for number, core in enumerate(made)]
