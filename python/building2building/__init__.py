"""Buildings as reinforcement-learning environments, on EnergyPlus.

>>> import building2building as b2b
>>> env = b2b.make_env("OfficeSmall", run_period="01-01..01-02")
>>> trajectory = b2b.rollout(env, b2b.ReactiveController(env))
>>> len(trajectory)
576
"""

import gymnasium as _gymnasium

from . import _core, benchmarks, wrappers
from .buildings import (
    Building,
    building_parameters,
    find_building,
    generate,
    get_climate_zone,
    import_building,
    list_building_types,
    list_buildings,
    list_buildings_by_climate_zone,
    list_places,
)
from .env import BuildingEnv, Snapshot, make_env
from .errors import Error
from .evaluation import Evaluation, compute_normalized_score, evaluate
from .morphology import Morphology
from .rollouts import (
    ConstantController,
    Controller,
    RandomController,
    ReactiveController,
    Trajectory,
    callable_controller,
    rollout,
)
from .vector import BuildingVectorEnv, make_vec
from .wrappers import wrap_env_for_rl

__version__ = _core.__version__

__all__ = [
    "Building",
    "BuildingEnv",
    "BuildingVectorEnv",
    "ConstantController",
    "Controller",
    "Error",
    "Evaluation",
    "Morphology",
    "RandomController",
    "ReactiveController",
    "Snapshot",
    "Trajectory",
    "benchmarks",
    "building_parameters",
    "callable_controller",
    "collect",
    "compute_normalized_score",
    "evaluate",
    "find_building",
    "generate",
    "get_climate_zone",
    "import_building",
    "list_building_types",
    "list_buildings",
    "list_buildings_by_climate_zone",
    "list_places",
    "make_env",
    "make_vec",
    "rollout",
    "wrap_env_for_rl",
    "wrappers",
]


def collect(*arguments, **options):
    """Writes a Minari dataset: see :func:`building2building.offline.collect`."""
    from .offline import collect

    return collect(*arguments, **options)


for _name in list_building_types():
    if f"b2b/{_name}-v0" not in _gymnasium.registry:
        _gymnasium.register(
            f"b2b/{_name}-v0",
            entry_point="building2building.env:BuildingEnv",
            vector_entry_point="building2building.vector:BuildingVectorEnv",
            # Learners want actions from -1 to 1, and Gymnasium's checker asks for them.
            kwargs={"building_type": _name, "rescale_action": True},
            disable_env_checker=True,
            order_enforce=False,
        )
