"""The ``info`` dictionaries of ``reset`` and ``step``, which are computed when they are first read."""

from __future__ import annotations

from collections.abc import Callable, ItemsView, Iterator, KeysView, Mapping, Sequence, ValuesView
from copy import deepcopy
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from .layout import Layout


class Info(dict[str, Any]):
    """A dictionary that is computed when it is first read, so that a step whose info is not read pays nothing.

    An entry that was written before is read without computing the others. The encoder of ``json`` writes a dictionary
    without any as an empty one, so environments write one.
    """

    __slots__ = ("_compute",)

    def __init__(self, compute: Callable[[], dict[str, Any]] | None = None):
        super().__init__()
        self._compute = compute

    def _filled(self) -> Info:
        compute = self._compute
        if compute is not None:
            self._compute = None
            self._add(compute())
        return self

    def _add(self, computed: dict[str, Any]) -> Info:
        """Adds the computed entries; those written before take precedence."""
        for key, value in computed.items():
            dict.setdefault(self, key, value)
        return self

    def __getitem__(self, key: str) -> Any:
        return dict.__getitem__(self if dict.__contains__(self, key) else self._filled(), key)

    def get(self, key: str, default: Any = None) -> Any:
        return dict.get(self._filled(), key, default)

    def __contains__(self, key: object) -> bool:
        return dict.__contains__(self._filled(), key)

    def __iter__(self) -> Iterator[str]:
        return dict.__iter__(self._filled())

    def __len__(self) -> int:
        return dict.__len__(self._filled())

    def __eq__(self, other: object) -> bool:
        return dict.__eq__(self._filled(), other._filled() if isinstance(other, Info) else other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None

    def __repr__(self) -> str:
        return dict.__repr__(self._filled())

    def __or__(self, other: Mapping[str, Any]) -> dict[str, Any]:  # type: ignore[override]
        return {**self, **other}

    def __ror__(self, other: Mapping[str, Any]) -> dict[str, Any]:  # type: ignore[override]
        return {**other, **self}

    def keys(self) -> KeysView[str]:  # type: ignore[override]
        return dict.keys(self._filled())

    def values(self) -> ValuesView[Any]:  # type: ignore[override]
        return dict.values(self._filled())

    def __delitem__(self, key: str) -> None:
        dict.__delitem__(self._filled(), key)

    def items(self) -> ItemsView[str, Any]:  # type: ignore[override]
        return dict.items(self._filled())

    def pop(self, *args: Any) -> Any:
        return dict.pop(self._filled(), *args)

    def popitem(self) -> tuple[str, Any]:
        return dict.popitem(self._filled())

    def setdefault(self, key: str, default: Any = None) -> Any:
        return dict.setdefault(self._filled(), key, default)

    def copy(self) -> dict[str, Any]:
        return dict(self.items())

    def __copy__(self) -> dict[str, Any]:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> dict[str, Any]:
        return deepcopy(self.copy(), memo)

    def __reduce__(self) -> tuple[Any, ...]:
        return dict, (self.copy(),)


#: The data that the info of a step is computed from: layout, observation before and after the step,
#: temperature penalty, energy penalty and the terms of ``_core.TERMS_IN_INFO``, number of the step.
StepRecord = tuple[Layout, NDArray[np.float64], NDArray[np.float64], Sequence[float], int]


class StepInfo(Info):
    """The info of a step."""

    __slots__ = ("record",)

    record: StepRecord | None

    # One is created at every step; `dict.__init__` saves a call of a Python function.
    __init__ = dict.__init__

    def _filled(self) -> Info:
        record = self.record
        if record is None:
            return self
        self.record = None
        return self._add(_step_info(*record))


def _step_info(
    layout: Layout,
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    numbers: Sequence[float],
    step: int,
) -> dict[str, Any]:
    # The environment keeps the observation; what an info has is the reader's.
    after = after.copy()
    temperature_penalty, energy_penalty, *terms = numbers
    electricity, gas = float(after[layout.electricity]), float(after[layout.gas])
    hour = (step - 1) % (24 * layout.steps_per_hour) / layout.steps_per_hour
    temperatures, targets = after[layout.temperatures], layout.targets_in(before)
    info = {
        "step": step,
        "hour": hour,
        "reward_terms": {"temperature": 0.0 - temperature_penalty, "energy": 0.0 - energy_penalty},
        "energy": {"electricity": electricity, "gas": gas},
        **dict(zip(_core.TERMS_IN_INFO, terms, strict=True)),
        "zone_temperature": temperatures,
        "zone_target": targets,
        "zone_deviation": layout.deviations_in(before, temperatures),
        "observation": after,
    }
    if layout.occupancies is not None:
        info["zone_occupied"] = before[layout.occupancies] > 0.5
    return info
