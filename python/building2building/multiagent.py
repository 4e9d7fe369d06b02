"""A multi-agent environment: a PettingZoo parallel environment with one agent per zone."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from . import _core
from .env import unwrap
from .env.layout import Layout
from .errors import need

_pettingzoo = need("pettingzoo", "pettingzoo")


class ZonesParallelEnv(_pettingzoo.ParallelEnv):  # type: ignore[name-defined]
    """Agents are the zones with actuators and the air handlers of central air loops.

    Every agent observes the whole observation and controls its own actuators. The reward of a zone is minus its squared
    deviation from target (only below target for a zone without cooling) and an equal share of the energy term; the
    reward of an air handler is an equal share of the building's reward.
    """

    metadata: dict[str, Any] = {"name": "b2b_zones_v0", "render_modes": ["rgb_array"]}

    def __init__(self, env: gymnasium.Env[Any, Any]):
        self.env = unwrap(env)
        self.render_mode = self.env.render_mode
        layout = self.env.layout
        self._actuators: dict[str, list[int]] = {}
        for index, actuator in enumerate(layout.action):
            self._actuators.setdefault(_agent(actuator.owner, layout), []).append(index)
        self.possible_agents = list(self._actuators)
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
        observation, info = self.env.reset(seed=seed, options=options)
        self.agents = list(self.possible_agents)
        return {agent: observation for agent in self.agents}, {agent: info for agent in self.agents}

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        action = np.zeros(len(self.env.layout.action), dtype=np.float64)
        for agent in self.agents:
            action[self._actuators[agent]] = actions[agent]
        observation, reward, terminated, truncated, info = self.env.step(action)
        deviations = dict(zip(self.env.layout.controlled_zones, info["zone_deviation"]))
        for zone in self.env.layout.zones:
            if zone.controlled and not zone.cooling:
                deviations[zone.name] = min(deviations[zone.name], 0.0)
        energy = info["reward_terms"]["energy"] / len(self.agents)
        rewards = {
            agent: float(-(deviations[agent] ** 2) + energy) if agent in deviations else reward / len(self.agents)
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

    def render(self) -> Any:
        return self.env.render()

    def close(self) -> None:
        self.env.close()


def _agent(owner: _core.Owner, layout: Layout) -> str:
    if owner.kind == "zone" and owner.index is not None:
        return layout.zones[owner.index].name
    return f"air loop {owner.index}"
