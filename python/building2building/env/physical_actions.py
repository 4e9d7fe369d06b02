"""Warnings about actions in physical units that were probably meant otherwise."""

from __future__ import annotations

import sys
import warnings
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from .layout import Layout

#: The module of Stable-Baselines3's algorithms whose policies act around 0 with a standard deviation of 1: PPO, A2C...
_ON_POLICY = "stable_baselines3.common.on_policy_algorithm"


def warn_of_learner() -> None:
    """Warns if the caller is a Stable-Baselines3 learner that needs actions in [-1, 1] but has physical units."""
    if _ON_POLICY not in sys.modules:
        return
    frame: Any = sys._getframe(1)
    while frame is not None:
        if frame.f_globals.get("__name__") == _ON_POLICY:
            learner = frame.f_locals.get("self")
            space = getattr(learner, "action_space", None)
            if isinstance(space, Box) and not (np.all(space.low == -1) and np.all(space.high == 1)):
                warnings.warn(
                    f"{type(learner).__name__} needs actions in [-1, 1], but this environment's are in physical "
                    "units; make it with rescale_action=True",
                    stacklevel=3,
                )
            return
        frame = frame.f_back


def warn_of_zeros(layout: Layout, action: ArrayLike) -> None:
    """Warns of an action in physical units that is 0 for every actuator, although some cannot be 0."""
    if np.any(np.asarray(action)):
        return
    clamped = [each for each in layout.action if each.low > 0 or each.high < 0]
    if clamped:
        first = clamped[0]
        warnings.warn(
            f"the action is 0 for every actuator, but {len(clamped)} of {len(layout.action)} have bounds without 0 and "
            f"are clamped, such as {first.name} ({first.low:.3g} to {first.high:.3g} {first.unit}); actions are in "
            'physical units, and env.metadata["action_names"] names the actuators',
            stacklevel=3,
        )
