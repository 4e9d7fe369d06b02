"""The folder where pip installed EnergyPlus."""

from __future__ import annotations

from pathlib import Path


def folder() -> Path | None:
    """Returns the folder that the engine's wheel was installed to; ``None`` if it is not installed."""
    # Imported here because it is slow.
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        return Path(str(distribution("pyenergyplus-lbnl").locate_file(""))).resolve()
    except PackageNotFoundError:
        return None
