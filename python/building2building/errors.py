"""What can go wrong, with the words of the Rust crates."""


class Error(Exception):
    """Any error of this package."""


class InstallError(Error):
    """EnergyPlus or weather cannot be had."""


class BuildingError(Error, ValueError):
    """There is no such building, or it cannot be made an environment."""


class TaskError(Error, ValueError):
    """Text or data that is no task."""


class SettingError(Error, ValueError):
    """An argument that cannot be: steps an hour, windows, a mode, a name."""


class ActionError(Error, ValueError):
    """An action of the wrong length, or with a value that is not a number."""


class EpisodeError(Error, RuntimeError):
    """No episode is in progress, or its process is gone."""


class EngineError(Error, RuntimeError):
    """EnergyPlus failed."""


class EvaluationError(Error, RuntimeError):
    """The folder of an evaluation is another's, or damaged; or there is no such policy."""


class ProcessError(Error, RuntimeError):
    """The system refused what worker processes need, or the wrong process asks."""


class MissingExtra(Error, ImportError):
    """A part of the package needs a dependency that is not installed."""


def need(module: str, extra: str):
    """Imports a module of an extra, or says which extra to install."""
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        how = f"pip install 'building2building[{extra}]'" if extra in ("train", "plots") else f"pip install {extra}"
        raise MissingExtra(f"this needs {module.split('.')[0]}: {how}") from error
