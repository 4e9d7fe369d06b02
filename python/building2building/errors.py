"""Exceptions of this package. The Rust core defines them; all derive from :class:`Error`."""

from __future__ import annotations

import importlib
from typing import Any

from ._core import (
    ActionError,
    BuildingError,
    EngineError,
    EpisodeError,
    Error,
    EvaluationError,
    InstallError,
    ProcessError,
    SettingError,
    TaskError,
)

__all__ = [
    "ActionError",
    "BuildingError",
    "EngineError",
    "EpisodeError",
    "Error",
    "EvaluationError",
    "InstallError",
    "MissingExtra",
    "ProcessError",
    "SettingError",
    "TaskError",
    "need",
]

#: Extras of this package, as in ``pip install 'building2building[plots]'``.
_EXTRAS = ("plots", "train")


class MissingExtra(Error, ImportError):
    """An optional dependency is not installed."""


def need(module: str, extra: str) -> Any:
    """Imports an optional dependency.

    Raises :class:`MissingExtra`, which says how to install it: as an extra of this package or as the package
    ``extra``.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        target = f"'building2building[{extra}]'" if extra in _EXTRAS else extra
        raise MissingExtra(f"{module.split('.')[0]} is not installed; run: pip install {target}") from error
