"""Normalization of observations to [-1, 1] by fixed bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike, NDArray

from .errors import SettingError

#: Usual ranges of slots, by the last words of their names; of energies, Wh/m² in steps of 5 minutes. A space's own
#: bounds are much wider.
USUAL = {
    "outdoor air temperature": (-40.0, 50.0),
    "air temperature": (5.0, 40.0),
    "target": (10.0, 35.0),
    "HVAC electricity": (0.0, 10.0),
    "HVAC non-electric": (0.0, 20.0),
}
_OF_STEP = [(name, USUAL[name]) for name in ("HVAC electricity", "HVAC non-electric")]


class Scale:
    """Maps the lower bound of each slot to -1 and its upper bound to 1, and clips.

    ``names``, ``low`` and ``high`` describe the slots. ``bounds`` replaces bounds of slots by their name or its last
    words, for example ``{"air temperature": (10, 35)}``; :data:`USUAL` replaces others. The longest words that match
    count, so that the outdoor air temperature keeps its own. Last words narrow bounds: where they are narrower, as in
    slots that are scaled already, nothing is replaced. Slots without finite bounds are only clipped.
    ``steps_per_hour`` says how long the steps are over which energies are counted.
    """

    def __init__(
        self,
        names: Sequence[str],
        low: ArrayLike,
        high: ArrayLike,
        bounds: Mapping[str, tuple[float, float]] | None = None,
        steps_per_hour: int = 12,
    ):
        longer = {name: (least * 12 / steps_per_hour, most * 12 / steps_per_hour) for name, (least, most) in _OF_STEP}
        known = {**USUAL, **longer, **(bounds or {})}
        lower, upper = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)
        unused = set(bounds or {})
        for index, name in enumerate(names):
            words = max((each for each in known if f" {name}".endswith(f" {each}")), key=len, default=None)
            if words is None:
                continue
            least, most = known[words]
            if words == name or (lower[index] <= least and most <= upper[index]):
                lower[index], upper[index] = least, most
                unused.discard(words)
        if unused:
            without = ", ".join(sorted(unused))
            raise SettingError(f"bounds of {without} apply to no slot; expected last words of {', '.join(names)}")
        bounded = np.isfinite(lower) & np.isfinite(upper)
        lower, upper = np.where(bounded, lower, -1.0), np.where(bounded, upper, 1.0)
        #: Lower and upper bounds, f32.
        self.low, self.high = lower.astype(np.float32), upper.astype(np.float32)
        #: Differences between upper and lower bounds, f32.
        self.span = np.where(upper > lower, upper - lower, 1.0).astype(np.float32)

    @classmethod
    def of_all(cls, slots: Sequence[Sequence[tuple[str, float, float]]], steps_per_hour: int) -> Scale:
        """Returns the scale of rows whose slots may hold different quantities, with bounds that cover all of them.

        ``slots`` has the name and bounds of each slot, once per building. Padding of a row is -1 where another
        building uses the slot with a lower bound of 0.
        """
        width = len(slots[0])
        low, high = np.full(width, np.inf), np.full(width, -np.inf)
        for row in slots:
            names, lower, upper = zip(*row)
            each = cls(names, lower, upper, None, steps_per_hour)
            used = np.array([name != "padding" for name in names])
            low = np.where(used, np.minimum(low, each.low), low)
            high = np.where(used, np.maximum(high, each.high), high)
        return cls([], low, high, {})

    @property
    def space(self) -> Box[np.float32]:
        """The space of the result."""
        return Box(-1.0, 1.0, self.low.shape, dtype=np.float32)

    def __call__(self, observation: ArrayLike) -> NDArray[np.float32]:
        shares = (np.asarray(observation, dtype=np.float32) - self.low) / self.span
        return np.clip(2 * shares - 1, -1.0, 1.0)

    def denormalize(self, observation: ArrayLike) -> NDArray[np.float32]:
        """Maps -1 back to the lower bound of each slot and 1 to its upper bound."""
        shares = (np.asarray(observation, dtype=np.float32) + 1) / 2
        return (self.low + shares * self.span).astype(np.float32)
