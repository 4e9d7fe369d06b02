"""Makers of environments, and their registration with Gymnasium."""

from __future__ import annotations

from typing import Any, cast

import gymnasium

from .buildings import find_building, list_building_types
from .buildings.signatures import check_names, renamed, with_arguments_of
from .env import BuildingEnv
from .errors import SettingError
from .learning.acting import ActingEnv, ActingVectorEnv, PhysicalVectorEnv
from .vector import BuildingVectorEnv

#: The task of an id of each version, unless another one is given.
TASKS = {"v0": "constant", "v1": "operate"}


@renamed(
    eplus_output_dir="pass keep_engine_output",
    max_episode_steps="pass a run_period, such as 01-01..01-07",
    normalizer_path="the task's energy_scale sets the scale of energy",
    target_temperature_mode="name it in the task, such as occupancy",
    random_schedule_seed="name it in the task, such as random:7",
)
@with_arguments_of(BuildingEnv, acting=None, observation=None)
def make_env(building_type: str | None = None, **arguments: Any) -> BuildingEnv:
    """Makes an environment, for example ``make_env("OfficeSmall")`` or ``make_env("OfficeSmall-0042")``.

    The building is the type's prototype in its default place unless selected otherwise:

    - ``place`` (such as ``"Miami"``) or ``weather`` (an EPW file): the prototype at another place;
    - ``split`` and ``index``, or ``building_id`` (``"OfficeSmall-0042"``, or the same in place of the type): a
      building of the dataset;
    - ``building``: the result of :func:`generate` or :func:`import_building`.

    ``control="setpoints"`` controls every zone through the heating and the cooling setpoint of its thermostat, which
    the building's equipment follows, instead of the actuators of its systems.

    Further arguments:

    - ``task``: ``operate`` (comfort bands and costs) by default; the paper's ``constant``, ``occupancy+energy0.5``,
      ``random:7+cost2``...; a JSON file, or a dictionary;
    - ``run_period``: ``winter``, ``summer``, ``full_year``, days such as ``01-01..01-07``, or two weeks chosen by the
      weather: ``peak-heating``, ``typical-heating``, ``peak-cooling``, ``typical-cooling`` or ``mixed``;
    - ``timesteps_per_hour``: 12 by default;
    - ``rescale_action``: actions in [-1, 1] instead of physical units; the default of ``gymnasium.make``;
    - ``window_days`` and ``window_starts``: episodes of ``window_days`` days that begin on one of ``window_starts``
      days of the run period, drawn at random;
    - ``weather_years``: EPW files, such as measured years at the site; every episode draws one. Equipment stays sized
      for the building's own weather;
    - ``resample_targets``: draws new targets for every episode of a random task;
    - ``reward``: a function of the step's info that replaces the task's reward;
    - ``acting``: how actions, in [-1, 1], drive the building, as for ``b2b train``: ``residual:0.5`` corrects the
      reactive controllers, ``targets:60`` shifts their targets by at most 1 K, and ``supervisory:60`` shifts what
      ``guideline36`` chooses; both hold each decision for an hour, which is a step
      (:class:`~building2building.learning.acting.ActingEnv`). ``observation`` is then ``features``, ``roles`` or
      ``raw``;
    - ``render_mode``: ``rgb_array`` or ``human``;
    - ``in_process``: runs the simulation in this process, for debuggers; only one at a time, from one thread;
    - ``keep_engine_output``: a folder to which EnergyPlus writes its own output files of the last episode (errors,
      summary tables, SQLite, time series); runs as with ``in_process``, and slower.

    Random draws follow the seed of ``reset``.
    """
    takers = (single_env, BuildingEnv, gymnasium.make)
    check_names("make_env", arguments, takers, BuildingVectorEnv, "which make_vec has; make a vector environment")
    arguments = {"rescale_action": False, **arguments}
    if building_type is None:
        return cast(BuildingEnv, single_env(**arguments))
    env_id, arguments = _of_id(building_type, arguments)
    return cast(BuildingEnv, gymnasium.make(env_id, **arguments))


@with_arguments_of(BuildingVectorEnv, acting=None, observation=None)
def make_vec(building_type: str | None = None, num_envs: int = 1, **arguments: Any) -> BuildingVectorEnv:
    """Makes a vector environment. It takes the arguments of :func:`make_env`, except ``resample_targets``,
    ``in_process``, ``keep_engine_output`` and ``render_mode``, which are for single environments, and these:

    - ``buildings``: a list of :class:`Building`, :class:`Generator` or ids. Environment i repeats the i-th.
    - ``resample``: ``True`` draws a building for every episode, ``k`` for every ``k`` episodes, from ``buildings`` or
      from the type's ``split``. ``weights={type: weight}`` weights the building types.
    - ``task`` may be a list; with ``resample``, tasks are drawn with the buildings.
    - ``by_role``: observations of houses have a slot for every zone role, the same in every house; in tasks without
      bands.
    - ``normalize``: observations in [-1, 1] by fixed bounds.
    - ``autoreset_mode``: ``NextStep`` (Gymnasium's default), ``SameStep`` (the default with ``acting``) or
      ``Disabled``.
    """
    takers = (vector_env, BuildingVectorEnv, gymnasium.make_vec)
    remedy = "which make_env has; make single environments, such as in gymnasium.vector.SyncVectorEnv"
    check_names("make_vec", arguments, takers, BuildingEnv, remedy)
    arguments = {"rescale_action": False, **arguments}
    if building_type is None:
        return cast(BuildingVectorEnv, vector_env(num_envs=num_envs, **arguments))
    env_id, arguments = _of_id(building_type, arguments)
    return cast(BuildingVectorEnv, gymnasium.make_vec(env_id, num_envs=num_envs, **arguments))


def single_env(
    *, acting: str | None = None, observation: str | None = None, rescale_action: bool | None = None, **arguments: Any
) -> gymnasium.Env[Any, Any]:
    """Makes the environment of an id.

    Actions are in [-1, 1] unless ``rescale_action`` is ``False``: Gymnasium's checker and most learners require that.
    """
    plain = _is_plain(acting, observation)
    env = BuildingEnv(rescale_action=plain if rescale_action is None else rescale_action, **arguments)
    return ActingEnv(env, acting, observation or "features") if acting is not None else env


def vector_env(
    *, acting: str | None = None, observation: str | None = None, rescale_action: bool | None = None, **arguments: Any
) -> gymnasium.vector.VectorEnv[Any, Any, Any]:
    """Makes the vector environment of an id, as :func:`single_env`."""
    plain = _is_plain(acting, observation)
    if not plain:
        arguments.setdefault("autoreset_mode", "SameStep")
    batch = BuildingVectorEnv if plain else PhysicalVectorEnv
    envs = batch(rescale_action=plain if rescale_action is None else rescale_action, **arguments)
    return ActingVectorEnv(envs, acting, observation or "features") if acting is not None else envs


# Gymnasium reads the render modes from the maker.
single_env.metadata = BuildingEnv.metadata  # type: ignore[attr-defined]


def register_envs() -> None:
    """Registers two ids with Gymnasium for every building type: ``b2b/OfficeSmall-v1`` has the task ``operate`` unless
    another is given, and ``b2b/OfficeSmall-v0`` has the paper's task ``constant``."""
    for name in list_building_types():
        for version, task in TASKS.items():
            if f"b2b/{name}-{version}" not in gymnasium.registry:
                gymnasium.register(
                    f"b2b/{name}-{version}",
                    entry_point="building2building.registration:single_env",
                    vector_entry_point="building2building.registration:vector_env",
                    kwargs={"building_type": name, "task": task},
                    disable_env_checker=True,
                    order_enforce=False,
                )


def _is_plain(acting: str | None, observation: str | None) -> bool:
    """Returns whether actions set the actuators; raises for an observation that needs ``acting``."""
    if acting is None and observation is not None:
        raise SettingError(f"observation={observation!r} needs acting=, such as acting='supervisory:60'")
    return acting is None


def _of_id(building: str, arguments: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Returns the id of a building type or of a dataset building's type, and the arguments that make the building."""
    if not isinstance(building, str):
        remedy = "pass a name such as OfficeSmall-0042, a Building as building=, or several to make_vec as buildings="
        raise SettingError(f"the building is {building!r}; {remedy}")
    for name in list_building_types():
        if name.lower() == building.lower():
            return f"b2b/{name}-v1", arguments
        if building.lower().startswith(f"{name.lower()}-"):
            if arguments.get("building_id") is not None:
                raise SettingError(f"`{building}` already selects a building; omit it or building_id")
            return f"b2b/{name}-v1", {**arguments, "building_id": building}
    find_building(building)  # raises for an unknown type and suggests the nearest
    raise SettingError(f"`{building}` is a model; pass import_building(...) as building")
