"""Temporary folders and files."""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .. import _core


@contextmanager
def temporary_folder(purpose: str) -> Iterator[Path]:
    """A folder that is removed at the end or, if the process is killed, by a later process of the package."""
    folder = Path(_core.temporary_folder(f"b2b-{purpose}-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[str]:
    """The path of a new file beside a file, which replaces the file at the end. After an exception it is removed."""
    aside = f"{os.fspath(path)}.{secrets.token_hex(4)}.partial"
    try:
        yield aside
        os.replace(aside, path)
    finally:
        if os.path.exists(aside):
            os.unlink(aside)
