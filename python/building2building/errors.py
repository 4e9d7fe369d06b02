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

#: Packages of each extra, as ``pip install '.[plots]'`` installs them in a clone; this package is in no registry.
_EXTRAS = {"plots": "'matplotlib>=3.8'", "train": "'stable-baselines3>=2.6' 'onnxscript>=0.5'"}


class MissingExtra(Error, ImportError):
    """An optional dependency is not installed."""


def need(module: str, extra: str) -> Any:
    """Imports an optional dependency.

    Raises :class:`MissingExtra` with how to install it: an extra of this package, or the package ``extra``.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        target = _EXTRAS.get(extra, extra)
        raise MissingExtra(f"{module.split('.')[0]} is not installed; run: pip install {target}") from error
