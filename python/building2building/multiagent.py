"""A multi-agent environment: a PettingZoo parallel environment with one agent per zone."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from . import _core
from .env import unwrap
from .env.layers import is_plain
from .env.layout import Layout
from .errors import SettingError, need

_pettingzoo = need("pettingzoo", "pettingzoo")


class ZonesParallelEnv(_pettingzoo.ParallelEnv):  # type: ignore[name-defined]
    """Agents are the zones with actuators and the air handlers of central air loops.

    Every agent observes the whole observation and controls its own actuators. The reward of a zone is minus its own
    comfort penalty, of which the task has the mean over the zones, and an equal share of the energy term; with zones
    that its unit serves too, the mean of their penalties. The reward of an air handler is an equal share of the
    building's reward. Tasks whose comfort is a vote (``+pmv``) and rewards of
    one's own are errors.
    """

    metadata: dict[str, Any] = {"name": "b2b_zones_v0", "render_modes": ["rgb_array"]}

    def __init__(self, env: gymnasium.Env[Any, Any]):
        if not is_plain(env):
            raise SettingError(
                "zones observe and control the building itself; pass the environment without wrappers, with "
                "rescale_action=True for actions in [-1, 1]"
            )
        self.env = unwrap(env)
        if self.env._reward is not None:
            raise SettingError("the reward of an environment is one number, and zones have their own; omit reward")
        task = self.env.metadata["task"]
        _penalty(task, 0.0)
        if any(task.get("faults", {}).get(name, 0.0) for name in ("noise", "bias")):
            raise SettingError("zones as agents have the deviations that sensors show; omit +noise and +bias")
        self.render_mode = self.env.render_mode
        layout = self.env.layout
        self._actuators: dict[str, list[int]] = {}
        for index, actuator in enumerate(layout.action):
            self._actuators.setdefault(_agent(actuator.owner, layout), []).append(index)
        self.possible_agents = list(self._actuators)
        self._follows = _followed(layout)
        self.agents: list[str] = []
        box = layout.action_space(self.env.rescale_action)
        self.action_spaces = {
            agent: Box(box.low[indices], box.high[indices], dtype=np.float32)
            for agent, indices in self._actuators.items()
        }
        self.observation_spaces = {agent: self.env.observation_space for agent in self.possible_agents}

    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> gymnasium.Space[Any]:
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        # The environment has no options, and PettingZoo's own tests pass some.
        observation, info = self.env.reset(seed=seed)
        self.agents = list(self.possible_agents)
        return {agent: observation for agent in self.agents}, {agent: info for agent in self.agents}

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        action = np.zeros(len(self.env.layout.action), dtype=np.float64)
        for agent in self.agents:
            action[self._actuators[agent]] = actions[agent]
        observation, reward, terminated, truncated, info = self.env.step(action)
        penalties = self._penalties(dict(zip(self.env.layout.controlled_zones, info["zone_deviation"])))
        energy = info["reward_terms"]["energy"] / len(self.agents)
        rewards = {
            agent: energy - penalties[agent] if agent in penalties else reward / len(self.agents)
            for agent in self.agents
        }
        agents = self.agents
        if terminated or truncated:
            self.agents = []
        return (
            {agent: observation for agent in agents},
            rewards,
            dict.fromkeys(agents, terminated),
            dict.fromkeys(agents, truncated),
            {agent: info for agent in agents},
        )

    def _penalties(self, deviations: dict[str, float]) -> dict[str, float]:
        """Returns the comfort penalties of the zones' agents."""
        task = self.env.metadata["task"]
        for zone in self.env.layout.zones:
            if zone.controlled and not zone.cooling and task["heating_only_zones"] == "below_target":
                deviations[zone.name] = min(deviations[zone.name], 0.0)
        penalties: dict[str, list[float]] = {}
        for name, deviation in deviations.items():
            penalties.setdefault(self._follows.get(name, name), []).append(_penalty(task, float(deviation)))
        return {agent: sum(each) / len(each) for agent, each in penalties.items()}

    def render(self) -> Any:
        return self.env.render()

    def close(self) -> None:
        self.env.close()


def _penalty(task: dict[str, Any], deviation: float) -> float:
    """Returns a task's comfort penalty of a zone with a deviation, K."""
    match task["comfort"]:
        case "squared":
            return deviation**2
        case {"deadband": {"half_width": half_width}}:
            return max(abs(deviation) - half_width, 0.0) ** 2
        case {"band": {"weight": weight}}:
            return weight * abs(deviation)
        case other:
            raise SettingError(f"zones as agents need comfort by temperature, and the task's is {other}; omit +pmv")


def _followed(layout: Layout) -> dict[str, str]:
    """Returns the zones without actuators whose air comes from another zone's unit, with the name of that zone."""
    morphology = layout.spaces.morphology()
    nodes = morphology.nodes
    return {
        nodes[edge.target].name: nodes[edge.source].name
        for edge in morphology.edges
        if edge.kind == "controls" and nodes[edge.target].node_type == "following_zone"
    }


def _agent(owner: _core.Owner, layout: Layout) -> str:
    if owner.kind == "zone" and owner.index is not None:
        return layout.zones[owner.index].name
    return f"air loop {owner.index}"
