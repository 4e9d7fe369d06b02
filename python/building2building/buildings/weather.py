"""Hourly values of a weather file."""

from __future__ import annotations

import csv
import os
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..errors import SettingError

#: Column of an EPW record, and its unit (EnergyPlus Auxiliary Programs, "EnergyPlus Weather File Data Dictionary").
COLUMNS = {
    "temperature": (6, "°C"),
    "dew_point": (7, "°C"),
    "humidity": (8, "%"),
    "direct_radiation": (14, "Wh/m²"),
    "diffuse_radiation": (15, "Wh/m²"),
    "wind_speed": (21, "m/s"),
}
_HEADER_LINES = 8


def read(path: str | os.PathLike[str], quantities: Sequence[str] = ("temperature",)) -> NDArray[np.float64]:
    """Reads the hourly values of a year without 29 February, ``[8760, quantities]``."""
    for quantity in quantities:
        if quantity not in COLUMNS:
            raise SettingError(f"unknown weather quantity `{quantity}`; expected one of {', '.join(COLUMNS)}")
    with open(path, encoding="latin-1", newline="") as file:
        rows = [row for row in list(csv.reader(file))[_HEADER_LINES:] if len(row) > 21 and row[1:3] != ["2", "29"]]
    return np.array([[float(row[COLUMNS[quantity][0]]) for quantity in quantities] for row in rows])
