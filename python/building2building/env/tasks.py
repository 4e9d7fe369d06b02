"""Tasks as text."""

from __future__ import annotations

import json
import os
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
    for name, value in (("window_days", days), ("window_starts", starts)):
        check_count(name, value)
    return None if days is None else (days, _WINDOW_STARTS if starts is None else starts)


def check_count(name: str, value: int | None) -> None:
    """Raises unless a number of things is at least 1, or not given."""
    if value is not None and value < 1:
        raise SettingError(f"{name} is {value}; expected 1 or more")


def checked_jobs(jobs: int | None) -> int:
    """Returns how many episodes run at a time: by default, as many as there are cores."""
    check_count("jobs", jobs)
    return len(os.sched_getaffinity(0)) if jobs is None else jobs


def task_text(task: Task) -> str:
    """Returns a task as text: the short form or the path as it is, options as JSON."""
    return json.dumps(task) if isinstance(task, dict) else str(task)
