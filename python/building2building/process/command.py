"""The command ``b2b`` as a process."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence

from .. import _core
from ..errors import Error


def run(words: Sequence[str], error: type[Error]) -> str:
    """Runs ``b2b`` with these arguments, and returns what it prints. Raises ``error`` with its message if it fails."""
    command = [sys.executable, *_core.command_arguments(_core.__file__), *words]
    ended = subprocess.run(command, capture_output=True, text=True)
    if ended.returncode:
        raise error(f"b2b {' '.join(words)} failed: {ended.stderr.strip()}")
    return ended.stdout
