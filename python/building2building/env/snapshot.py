"""Snapshots of an episode."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..buildings import Building
from .layout import Layout
from .render import PowerHistory


@dataclass(frozen=True)
class Position:
    """The part of an environment's state that is not in its process."""

    building: Building
    layout: Layout
    setting: _core.Setting
    observation: NDArray[np.float64]
    steps: int
    penalties: tuple[float, float]
    truncated: bool
    power: PowerHistory


class Snapshot:
    """A copy of an episode in its own process, until :meth:`release` or until its environment is closed."""

    def __init__(self, env: object, number: int, position: Position, release: Callable[[int], None]):
        self._env = weakref.ref(env)
        self._finalizer = weakref.finalize(self, release, number)
        #: Number of the snapshot in the core.
        self.number = number
        #: State of the environment when the snapshot was taken.
        self.position = position

    def belongs_to(self, env: object) -> bool:
        """Returns whether the snapshot was taken from this environment."""
        return self._env() is env

    def release(self) -> None:
        """Ends the snapshot's process."""
        self._finalizer()
