"""A day in a small office: what is seen and driven, a controller, and what came of it."""

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

# A function from an observation to an action is a controller.
middle = (env.action_space.low + env.action_space.high) / 2
for name, controller in {
    "reactive": b2b.ReactiveController(env),
    "random": b2b.RandomController(env, seed=0),
    "middle": b2b.callable_controller(lambda observation: middle),
}.items():
    trajectory = b2b.rollout(env, controller)
    print(f"\n{name:<9} return {trajectory.episode_return:10.1f}", end="")
    print(f"  mean deviation {trajectory.metrics['mean_abs_deviation_k']:.2f} K", end="")
print()
env.close()
