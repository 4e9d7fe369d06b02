"""Tasks as text."""

from __future__ import annotations

import json
from typing import Any

from ..errors import SettingError

#: A task: its short form, the path of a JSON file, or its options.
Task = str | dict[str, Any]


#: Days on which the windows of ``window_days`` begin, if ``window_starts`` is not given.
_WINDOW_STARTS = 8


def windows(days: int | None, starts: int | None) -> tuple[int, int] | None:
    """Returns the arguments ``window_days`` and ``window_starts``; ``None`` for whole run periods."""
    if days is None and starts is not None:
        raise SettingError("window_starts needs window_days, the length of an episode; pass both, or none")
    return None if days is None else (days, _WINDOW_STARTS if starts is None else starts)


def task_text(task: Task) -> str:
    """Returns a task as text: the short form or the path as it is, options as JSON."""
    return json.dumps(task) if isinstance(task, dict) else str(task)
