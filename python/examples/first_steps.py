"""Two days in a small office: observation, action, and three controllers."""

import building2building as b2b

env = b2b.make_env("OfficeSmall", run_period="01-09..01-10", task="occupancy+energy0.5")
observation, info = env.reset(seed=0)
for name, unit, value in zip(env.metadata["observation_names"], env.metadata["observation_units"], observation):
    print(f"{name:<40} {value:8.2f} {unit}")
print()
for name, unit, low, high in zip(
    env.metadata["action_names"], env.metadata["action_units"], env.action_space.low, env.action_space.high
):
    print(f"{name:<40} {low:6.2f} to {high:6.2f} {unit}")

# Any function from an observation to an action is a controller.
midpoint = (env.action_space.low + env.action_space.high) / 2
print()
for name, controller in {
    "reactive": b2b.ReactiveController(env),
    "random": b2b.RandomController(env, seed=0),
    "midpoint": b2b.callable_controller(lambda observation: midpoint),
}.items():
    trajectory = b2b.rollout(env, controller)
    deviation = trajectory.metrics["mean_abs_deviation_k"]
    print(f"{name:<9} return {trajectory.episode_return:10.1f}  mean absolute deviation {deviation:.2f} K")
env.close()
