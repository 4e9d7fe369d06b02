"""One policy for all building types, which acts on the nodes of their graphs.

Here the policy is one rule per quantity; a neural network would receive the same arrays.
"""

import building2building as b2b
import numpy as np


class NodePolicy:
    """One rule per actuated quantity, from the temperature and target of the node."""

    def __init__(self, env):
        self.graph = env.morphology
        self.low, self.high = (self.graph.split_action(b) for b in (env.layout.action_low, env.layout.action_high))

    def reset(self):
        pass

    def __call__(self, observation):
        nodes = self.graph.split_observation(observation)
        actions = {}
        for node_type, low in self.low.items():
            spaces, observed = self.graph.node_types[node_type], nodes.get(node_type)
            names = [slot.quantity for slot in spaces.observation]
            target = 21.0 if observed is None else observed[:, names.index("target_temperature")]
            error = 0.0 if observed is None else target - observed[:, names.index("air_temperature")]
            rules = {
                "supply_air_flow": low[:, 0] + np.abs(error) * (self.high[node_type] - low)[:, 0],
                "supply_air_temperature": np.where(error > 0, 40.0, 14.0),
                "outdoor_air_flow": 0.3,
                "damper_opening": 0.2 - error / 2,
                "heating_setpoint": target,
            }
            if node_type == "air_loop":
                rules["supply_air_temperature"] = 16.0
            rows = [np.broadcast_to(rules[slot.quantity], len(low)) for slot in spaces.action]
            actions[node_type] = np.clip(np.stack(rows, axis=1), low, self.high[node_type])
        return self.graph.join_actions(actions)


for building_type in b2b.list_building_types():
    env = b2b.make_env(building_type, run_period="01-09..01-10", task="constant")
    for name, controller in {"nodes": NodePolicy(env), "reactive": b2b.ReactiveController(env)}.items():
        trajectory = b2b.rollout(env, controller)
        print(f"{building_type:<18} {name:<9} return {trajectory.episode_return:9.1f}", end="   ")
    print()
    env.close()
