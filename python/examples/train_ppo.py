"""Train Stable-Baselines3's PPO on a house in winter, and compare it with the reactive controller.

Hyperparameters are Stable-Baselines3's own, but for shorter rollouts and larger batches. `python train_ppo.py 200000` takes a while; the default is a try.
"""

import sys
import time

import building2building as b2b
from building2building.sb3 import make_sb3_vec
from stable_baselines3 import PPO

STEPS = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000
HOUSE = {"task": "constant", "run_period": "01-01..01-28"}

envs = make_sb3_vec("SingleFamilyHouse", 4, window_days=7, window_starts=4, **HOUSE)
model = PPO("MlpPolicy", envs, n_steps=256, batch_size=256, seed=0, device="cpu")


class Policy:
    """The policy as a controller of a single environment."""

    def reset(self):
        pass

    def __call__(self, observation):
        return model.predict(observation, deterministic=True)[0]


env = b2b.wrap_env_for_rl(b2b.make_env("SingleFamilyHouse", **HOUSE))
reactive = b2b.rollout(env, b2b.ReactiveController(env)).episode_return
before = b2b.rollout(env, Policy()).episode_return
start = time.perf_counter()
model.learn(STEPS)
rate = model.num_timesteps / (time.perf_counter() - start)
after = b2b.rollout(env, Policy()).episode_return
print(f"{model.num_timesteps} steps, {rate:.0f} a second")
print(f"return: reactive {reactive:.0f}, before training {before:.0f}, after {after:.0f}")
env.close()
envs.close()
