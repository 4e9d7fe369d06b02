"""Keeps track of open environments and closes them when the interpreter exits."""

from __future__ import annotations

import atexit
import weakref
from typing import Protocol


class _Closable(Protocol):
    def close(self) -> None: ...


_open: weakref.WeakSet[_Closable] = weakref.WeakSet()


def close_at_exit(env: _Closable) -> None:
    """Registers an environment to be closed when the interpreter exits, if it still exists then."""
    _open.add(env)


@atexit.register
def _close_all() -> None:
    for each in list(_open):
        each.close()
