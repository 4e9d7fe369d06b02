"""Calibration of models to metered energy."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from .. import _core
from ..errors import SettingError
from ..process.temporary import temporary_folder
from . import PathLike


def calibrate(
    model: PathLike,
    energy: PathLike | Mapping[str, Iterable[float]],
    out: PathLike,
    *,
    place: str | None = None,
    weather: PathLike | None = None,
    parameters: Sequence[str] = (),
    iterations: int = 12,
    jobs: int | None = None,
    allow_external: bool = False,
    keep_design_days: bool = False,
) -> dict[str, Any]:
    """Fits a model to monthly metered energy, like ``b2b calibrate``, and writes the calibrated model as epJSON.

    ``model`` is a model file or a building of the dataset, with the weather of ``place`` (such as ``"Denver"``) or
    ``weather`` (an EPW file, preferably of the metered year). ``energy`` is a CSV file, a mapping or a data frame with
    the columns ``month`` (1 to 12), ``electricity_kwh`` and ``gas_kwh``, of which one fuel may be missing.
    ``parameters`` are ``"infiltration"``, ``"lights"``, ``"equipment"``, ``"people"``, ``"wall_u"``, ``"roof_u"`` or
    ``"window_u"``; the default is infiltration, lights, equipment and walls. ``jobs`` simulations run at a time, by
    default one per core. ``allow_external`` and ``keep_design_days`` are as for
    :func:`~building2building.import_building`.

    Returns what ``b2b calibrate --json`` prints: ``parameters``, each with its ``multiplier``; ``fuels``, each with
    metered and simulated energy and the agreement by ASHRAE Guideline 14 before and after; and ``warnings``. Raises
    :class:`~building2building.errors.BuildingError` for a wrong model or table, and
    :class:`~building2building.errors.EngineError` for a model that EnergyPlus rejects or crashes with.
    """
    if iterations < 1:
        raise SettingError(f"iterations={iterations}; expected at least 1")
    with temporary_folder("calibrate") as folder:
        table = energy if isinstance(energy, str | os.PathLike) else _write(energy, folder / "metered.csv")
        key = (os.fspath(model), place, weather, allow_external, keep_design_days)
        printed = _core.calibrate(key, table, out, parameters, iterations, jobs)
    report: dict[str, Any] = json.loads(printed)
    return report


def _write(energy: Mapping[str, Iterable[float]], path: Path) -> Path:
    """Writes columns as CSV."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(energy)
        writer.writerows(zip(*(energy[name] for name in energy), strict=True))
    return path
