"""What a step tells beside its observation: made when it is read."""

from __future__ import annotations

from collections.abc import Callable


class Info(dict):
    """A dictionary that is filled when it is first read, so that a step that nobody asks about costs nothing."""

    __slots__ = ("_fill",)

    def __init__(self, fill: Callable[[], dict] | None = None):
        super().__init__()
        self._fill = fill

    def _filled(self) -> Info:
        fill = self._fill
        if fill is not None:
            self._fill = None
            self._take(fill())
        return self

    def _take(self, made: dict) -> Info:
        """Takes over what was made, but for what was written here before."""
        for key, value in made.items():
            dict.setdefault(self, key, value)
        return self

    def __getitem__(self, key):
        return dict.__getitem__(self._filled(), key)

    def get(self, key, default=None):
        return dict.get(self._filled(), key, default)

    def __contains__(self, key):
        return dict.__contains__(self._filled(), key)

    def __iter__(self):
        return dict.__iter__(self._filled())

    def __len__(self):
        return dict.__len__(self._filled())

    def __eq__(self, other):
        return dict.__eq__(self._filled(), other._filled() if isinstance(other, Info) else other)

    def __ne__(self, other):
        return not self == other

    __hash__ = None

    def __repr__(self):
        return dict.__repr__(self._filled())

    def __or__(self, other):
        return dict(self) | other

    def __ror__(self, other):
        return other | dict(self)

    def keys(self):
        return dict.keys(self._filled())

    def values(self):
        return dict.values(self._filled())

    def items(self):
        return dict.items(self._filled())

    def pop(self, *args):
        return dict.pop(self._filled(), *args)

    def popitem(self):
        return dict.popitem(self._filled())

    def setdefault(self, key, default=None):
        return dict.setdefault(self._filled(), key, default)

    def copy(self):
        return dict(self.items())

    def __copy__(self):
        return self.copy()

    def __deepcopy__(self, memo):
        from copy import deepcopy

        return deepcopy(self.copy(), memo)

    def __reduce__(self):
        return dict, (self.copy(),)
