"""Where the package client put EnergyPlus."""

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path


def folder() -> Path | None:
    """The folder that the engine's wheel was installed to; ``None`` if it was not."""
    try:
        return Path(distribution("pyenergyplus-lbnl").locate_file("")).resolve()
    except PackageNotFoundError:
        return None
