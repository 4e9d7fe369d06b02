"""What a weather file says, hour by hour."""

from __future__ import annotations

import csv
import os

import numpy as np

from .errors import SettingError

#: Column of an EPW hour, and its unit (Auxiliary Programs, "EnergyPlus Weather File Data Dictionary").
COLUMNS = {
    "temperature": (6, "°C"),
    "dew_point": (7, "°C"),
    "humidity": (8, "%"),
    "direct_radiation": (14, "Wh/m²"),
    "diffuse_radiation": (15, "Wh/m²"),
    "wind_speed": (21, "m/s"),
}
_HEADER = 8


def read(path: str | os.PathLike, quantities: tuple[str, ...] = ("temperature",)) -> np.ndarray:
    """Hourly values of a year without a 29 February, ``[8760, quantities]``."""
    for quantity in quantities:
        if quantity not in COLUMNS:
            raise SettingError(f"weather has no `{quantity}`: it has {', '.join(COLUMNS)}")
    with open(path, encoding="latin-1", newline="") as file:
        rows = [row for row in list(csv.reader(file))[_HEADER:] if len(row) > 21 and row[1:3] != ["2", "29"]]
    return np.array([[float(row[COLUMNS[quantity][0]]) for quantity in quantities] for row in rows])
