"""Plan on the true simulation: every hour, try ways to go on from a snapshot, and take the best."""

import building2building as b2b
import numpy as np

HOURS, TRIES, AHEAD = 6, 8, 12

env = b2b.make_env("SingleFamilyHouse", run_period="01-09..01-09", task="constant")
reactive = b2b.ReactiveController(env)
random = np.random.default_rng(0)


def go_on(offset, steps):
    """The reactive controller's action, moved by shares of the bounds."""
    total = 0.0
    span = env.layout.action_high - env.layout.action_low
    for _ in range(steps):
        action = reactive(env.observation) + offset * span
        _, reward, _, _, _ = env.step(np.clip(action, env.layout.action_low, env.layout.action_high))
        total += reward
    return total


print(f"reactive alone {b2b.rollout(env, reactive, steps=HOURS * 12).rewards.sum():.3f}")
env.reset()
planned = 0.0
for _ in range(HOURS):
    here = env.snapshot()
    offsets = [np.zeros(2), *random.normal(0, 0.1, (TRIES, 2))]
    returns = []
    for offset in offsets:
        env.restore(here)
        reactive.reset()
        returns.append(go_on(offset, AHEAD))
    env.restore(here)
    here.release()
    reactive.reset()
    planned += go_on(offsets[int(np.argmax(returns))], 12)
print(f"planned        {planned:.3f}")
env.close()
