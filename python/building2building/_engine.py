"""Where the package client put EnergyPlus."""

from pathlib import Path


def folder() -> Path | None:
    """The folder that the engine's wheel was installed to; ``None`` if it was not."""
    # Takes a while to import.
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        return Path(distribution("pyenergyplus-lbnl").locate_file("")).resolve()
    except PackageNotFoundError:
        return None
