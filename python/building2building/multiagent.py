"""One agent a zone: a PettingZoo parallel environment."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box

from .env import BuildingEnv
from .errors import need

_pettingzoo = need("pettingzoo", "pettingzoo")


class ZonesParallelEnv(_pettingzoo.ParallelEnv):
    """Agents are the owners of actuators: zones, and the handlers of central air loops.

    All see the whole observation; each drives its own actuators. A zone's reward is minus its squared deviation (of
    one without cooling, below target only) and a share of the energy penalty; an air handler's is the mean of the
    building's.
    """

    metadata: dict[str, Any] = {"name": "b2b_zones_v0", "render_modes": ["rgb_array"]}

    def __init__(self, env: BuildingEnv):
        self.env = env.unwrapped
        self.render_mode = self.env.render_mode
        layout = self.env.layout
        self._actuators: dict[str, list[int]] = {}
        for index, actuator in enumerate(layout.data["action"]):
            self._actuators.setdefault(_name(actuator["owner"], layout), []).append(index)
        self.possible_agents = list(self._actuators)
        self.agents: list[str] = []
        box = self.env.action_space
        self.action_spaces = {
            agent: Box(box.low[indices], box.high[indices], dtype=box.dtype)
            for agent, indices in self._actuators.items()
        }
        self.observation_spaces = {agent: self.env.observation_space for agent in self.possible_agents}

    def observation_space(self, agent):
        return self.observation_spaces[agent]

    def action_space(self, agent):
        return self.action_spaces[agent]

    def reset(self, seed=None, options=None):
        observation, info = self.env.reset(seed=seed, options=options)
        self.agents = list(self.possible_agents)
        return {agent: observation for agent in self.agents}, {agent: info for agent in self.agents}

    def step(self, actions):
        action = np.zeros(self.env.action_space.shape, dtype=np.float64)
        for agent in self.agents:
            action[self._actuators[agent]] = actions[agent]
        observation, reward, terminated, truncated, info = self.env.step(action)
        zones = dict(zip(self.env.layout.zones, info["zone_deviation"]))
        for zone in self.env.layout.data["zones"]:
            if zone["controlled"] and not zone["cooling"]:
                zones[zone["name"]] = min(zones[zone["name"]], 0.0)
        energy = info["reward_terms"]["energy"] / len(self.agents)
        rewards = {
            agent: float(-(zones[agent] ** 2) + energy) if agent in zones else reward / len(self.agents)
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

    def render(self):
        return self.env.render()

    def close(self):
        self.env.close()


def _name(owner, layout) -> str:
    if isinstance(owner, dict) and "zone" in owner:
        return layout.data["zones"][owner["zone"]]["name"]
    return f"air loop {owner['air_loop']}"
