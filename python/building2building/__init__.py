"""Buildings as reinforcement-learning environments, simulated by EnergyPlus.

>>> import building2building as b2b
>>> env = b2b.make_env("OfficeSmall", run_period="01-01..01-02")
>>> trajectory = b2b.rollout(env, b2b.Guideline36Controller(env))
>>> len(trajectory)
576
"""

from typing import Any

from . import _core, benchmarks, wrappers
from .buildings import (
    Building,
    Generator,
    building_parameters,
    edit_model,
    find_building,
    generate,
    get_climate_zone,
    import_building,
    list_building_types,
    list_buildings,
    list_buildings_by_climate_zone,
    list_engine_models,
    list_places,
)
from .buildings.calibration import calibrate
from .env import BuildingEnv
from .env.morphology import Morphology, NodeType, SystemKind
from .env.snapshot import Snapshot
from .errors import Error
from .evaluation import EpisodeContext, Evaluation, compute_normalized_score, compute_resolved_score, evaluate
from .learning import Agent, train
from .registration import make_env, make_vec, register_envs
from .rollouts import (
    ConstantController,
    Controller,
    Guideline36Controller,
    RandomController,
    ReactiveController,
    Trajectory,
    callable_controller,
    rollout,
)
from .vector import BuildingVectorEnv
from .wrappers import wrap_env_for_rl

__version__ = _core.__version__

__all__ = [
    "Agent",
    "Building",
    "BuildingEnv",
    "BuildingVectorEnv",
    "ConstantController",
    "Controller",
    "EpisodeContext",
    "Error",
    "Evaluation",
    "Generator",
    "Guideline36Controller",
    "Morphology",
    "NodeType",
    "RandomController",
    "ReactiveController",
    "Snapshot",
    "SystemKind",
    "Trajectory",
    "benchmarks",
    "building_parameters",
    "calibrate",
    "callable_controller",
    "collect",
    "compute_normalized_score",
    "compute_resolved_score",
    "edit_model",
    "evaluate",
    "find_building",
    "generate",
    "get_climate_zone",
    "import_building",
    "list_building_types",
    "list_buildings",
    "list_buildings_by_climate_zone",
    "list_engine_models",
    "list_places",
    "make_env",
    "make_vec",
    "rollout",
    "train",
    "wrap_env_for_rl",
    "wrappers",
]


def collect(*arguments: Any, **options: Any) -> Any:
    """Writes a Minari dataset; see :func:`building2building.offline.collect`."""
    from .offline import collect

    return collect(*arguments, **options)


register_envs()
