"""The ``info`` of a step of a vector environment, whose buildings may differ."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..env.layout import Layout

Array = NDArray[Any]


class Row:
    """The positions of a building's quantities in a row of observations; read from its spaces on first use."""

    def __init__(self, spaces: _core.Spaces, by_role: bool):
        self.spaces, self.by_role = spaces, by_role

    @cached_property
    def layout(self) -> Layout:
        return Layout(self.spaces)

    @cached_property
    def _places(self) -> Array:
        """For every slot of the building's own observation, its place in the row."""
        places = np.arange(len(self.layout.observation))
        roles = self.spaces.roles if self.by_role else None
        for place, role in enumerate(roles or []):
            if role.slot is not None:
                places[role.slot] = place
        return places

    @cached_property
    def temperatures(self) -> Array:
        return self._places[self.layout.temperatures]

    @property
    def observation(self) -> Array:
        """Places of the building's own observation."""
        return self._places

    @cached_property
    def occupancies(self) -> Array | None:
        return None if self.layout.occupancies is None else self._places[self.layout.occupancies]

    @cached_property
    def energy(self) -> Array:
        """Places of electricity and gas."""
        return self._places[[self.layout.electricity, self.layout.gas]]


def hours(steps: Array, steps_per_hour: int) -> Array:
    """Returns the hour of the day at which each environment's step begins; 0 before its first step."""
    return np.maximum(steps - 1, 0) % (24 * steps_per_hour) / steps_per_hour


def reward_terms(numbers: Array) -> dict[str, Array]:
    """Returns the two terms of the task's reward in all environments."""
    return {"temperature": 0.0 - numbers[:, 0], "energy": 0.0 - numbers[:, 1]}


def step_info(
    rows: Sequence[Row], before: Array, after: Array, numbers: Array, steps: Array, steps_per_hour: int
) -> dict[str, Any]:
    """Returns the info of all environments: the keys of a single environment's info, with a row per environment.

    ``steps`` is 0 where an episode has just begun. Arrays with a column per controlled zone are as wide as the largest
    building; columns that a building does not have are NaN, and ``False`` in ``zone_occupied``.
    """
    before = np.where((steps == 0)[:, None], after, before).astype(np.float64)
    after = np.array(after, dtype=np.float64)
    count, zones = len(rows), max(len(row.temperatures) for row in rows)
    hour = hours(steps, steps_per_hour)
    energy = np.zeros((count, 2))
    temperatures, targets, deviations = (np.full((count, zones), np.nan) for _ in range(3))
    occupied = np.zeros((count, zones), dtype=bool)
    for i, row in enumerate(rows):
        own = slice(len(row.temperatures))
        energy[i] = after[i, row.energy]
        temperatures[i, own] = after[i, row.temperatures]
        targets[i, own] = row.layout.targets_in(before[i, row.observation])
        deviations[i, own] = row.layout.deviations_in(before[i, row.observation], temperatures[i, own])
        occupied[i, own] = row.occupancies is None or before[i, row.occupancies] > 0.5
    info = {
        "building": np.array([row.spaces.name for row in rows], dtype=object),
        "step": steps,
        "hour": hour,
        "reward_terms": reward_terms(numbers),
        "energy": {"electricity": energy[:, 0], "gas": energy[:, 1]},
        **dict(zip(_core.TERMS_IN_INFO, numbers.T[2:], strict=True)),
        "zone_temperature": temperatures,
        "zone_target": targets,
        "zone_deviation": deviations,
        "observation": after,
    }
    if any(row.occupancies is not None for row in rows):
        info["zone_occupied"] = occupied
    return info
