"""Plan on the simulation itself: every half hour, try several actions from a snapshot and apply the best."""

import building2building as b2b
import numpy as np

HOURS, SAMPLES, HORIZON = 6, 12, 24

env = b2b.make_env("SingleFamilyHouse", run_period="01-09..01-09", task="constant")
random = np.random.default_rng(0)
low, high = env.layout.action_low, env.layout.action_high


def run(controller, offset, steps):
    """Returns the sum of rewards under the controller's actions, shifted by a fraction of their range."""
    total = 0.0
    for _ in range(steps):
        action = controller(env.observation) + offset * (high - low)
        _, reward, _, _, _ = env.step(np.clip(action, low, high))
        total += reward
    return total


reactive = b2b.ReactiveController(env)
print(f"reactive {b2b.rollout(env, reactive, steps=HOURS * 12).rewards.sum():.3f}")
env.reset()
reactive.reset()
planned = 0.0
for _ in range(HOURS * 2):
    here = env.snapshot()
    offsets = [np.zeros(len(low)), *random.normal(0, 0.1, (SAMPLES, len(low)))]
    returns = []
    for offset in offsets:
        env.restore(here)
        trial = reactive.copy()
        returns.append(run(trial, offset, 6) + run(trial, 0, HORIZON - 6))
    env.restore(here)
    here.release()
    planned += run(reactive, offsets[int(np.argmax(returns))], 6)
print(f"planned  {planned:.3f}")
env.close()
