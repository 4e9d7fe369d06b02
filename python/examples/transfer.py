"""One policy for buildings of all types: it acts on nodes, not on buildings.

Here the policy is a rule for each type of node; a network in its place sees the same arrays.
"""

import building2building as b2b
import numpy as np


class NodePolicy:
    """A proportional rule at every zone, from its temperature and its target; air handlers hold their middle."""

    def __init__(self, env):
        self.graph = env.morphology
        self.low, self.high = (self.graph.split_action(b) for b in (env.layout.action_low, env.layout.action_high))

    def reset(self):
        pass

    def __call__(self, observation):
        nodes = self.graph.split_observation(observation)
        actions = {}
        for node_type, low in self.low.items():
            high, spaces = self.high[node_type], self.graph.node_types[node_type]
            share = np.full_like(low, 0.5)
            if node_type in nodes and node_type.endswith("zone"):
                seen = [slot["quantity"] for slot in spaces["observation"]]
                temperature, target = (nodes[node_type][:, seen.index(q)] for q in ("air_temperature", "target_temperature"))
                error = (target - temperature) / 4
                for column, slot in enumerate(spaces["action"]):
                    warm = slot["quantity"] in ("supply_air_temperature", "heating_setpoint")
                    share[:, column] = np.clip(0.5 + error if warm else np.abs(error) + 0.2, 0, 1)
            actions[node_type] = low + share * (high - low)
        return self.graph.join_actions(actions)


for building_type in b2b.list_building_types():
    env = b2b.make_env(building_type, run_period="01-09..01-10")
    for name, controller in {"nodes": NodePolicy(env), "reactive": b2b.ReactiveController(env)}.items():
        ran = b2b.rollout(env, controller)
        print(f"{building_type:<18} {name:<9} return {ran.episode_return:9.1f}", end="   ")
    print()
    env.close()
