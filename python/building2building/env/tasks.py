"""Tasks as text."""

from __future__ import annotations

import json
from typing import Any

#: A task: its short form, the path of a JSON file, or its options.
Task = str | dict[str, Any]


def task_text(task: Task) -> str:
    """Returns a task as text: the short form or the path as it is, options as JSON."""
    return json.dumps(task) if isinstance(task, dict) else str(task)
