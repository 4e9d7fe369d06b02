"""Observations from -1 to 1, by bounds that never move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from gymnasium.spaces import Box

#: Where temperatures of zones and outdoors mostly are; a space's own bounds are those that no sane run crosses.
USUAL = {
    "outdoor air temperature": (-40.0, 50.0),
    "air temperature": (5.0, 40.0),
    "target": (10.0, 35.0),
    "HVAC electricity": (0.0, 10.0),
    "HVAC gas": (0.0, 20.0),
}


class Scale:
    """Makes each slot -1 at its lower and 1 at its upper bound, and clips what is beyond.

    ``names``, ``low`` and ``high`` are those of the slots. ``bounds`` are narrower ones by a slot's name or its last
    words, such as ``{"air temperature": (10, 35)}``; the usual ones by default.
    """

    def __init__(self, names: Sequence[str], low, high, bounds: dict[str, tuple[float, float]] | None = None):
        bounds = USUAL if bounds is None else bounds
        low, high = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)
        for index, name in enumerate(names):
            fits = [words for words in bounds if name.endswith(words)]
            if fits:
                low[index], high[index] = bounds[max(fits, key=len)]
        #: Lower bounds, f32.
        self.low = low.astype(np.float32)
        #: Upper bounds less the lower ones, f32.
        self.span = np.where(high > low, high - low, 1.0).astype(np.float32)

    @property
    def space(self) -> Box:
        """What it gives."""
        return Box(-1.0, 1.0, self.low.shape, dtype=np.float32)

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        shares = (np.asarray(observation, dtype=np.float32) - self.low) / self.span
        return np.clip(2 * shares - 1, -1.0, 1.0)
