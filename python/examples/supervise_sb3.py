"""Train Stable-Baselines3's TD3 to supervise Guideline 36 in a medium office.

`python supervise_sb3.py` makes 9,600 decisions, each for an hour, in January, and prints the cost relative to the
guideline's, the discomfort of both (K·h per zone and day), and the same for February. Comfort is a constraint, as in
`b2b train`.
"""

import argparse
import copy
import time

import numpy as np
import torch
from building2building.learning.comfort import ComfortConstraint
from building2building.sb3 import make_sb3_vec
from stable_baselines3 import TD3
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.noise import NormalActionNoise, VectorizedActionNoise
from stable_baselines3.common.vec_env import VecNormalize

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--building", default="OfficeMedium-0626")
parser.add_argument("--decisions", type=int, default=9_600)
parser.add_argument("--every", type=int, default=960, help="decisions between evaluations")
parser.add_argument("--period", default="01-01..01-31")
parser.add_argument("--evaluated", default="01-10..01-23", help="days of the evaluations, among those of training")
parser.add_argument("--test", nargs="*", default=["02-01..02-28"])
parser.add_argument("--seed", type=int, default=0)
arguments = parser.parse_args()
every = min(arguments.every, arguments.decisions)

ACTING, ENVS = "supervisory:60", 8
# A decision lasts twelve steps, each of which discounts by 0.995.
GAMMA = 0.995**12
constraint = ComfortConstraint(arguments.building, arguments.evaluated, acting=ACTING)
envs = make_sb3_vec(
    arguments.building,
    ENVS,
    task="operate",
    acting=ACTING,
    run_period=arguments.period,
    window_days=14,
    window_starts=6,
    reward=constraint.reward,
)
shifts = envs.action_space.shape[0]
noise = NormalActionNoise(np.zeros(shifts), np.full(shifts, 0.3))
model = TD3(
    "MlpPolicy",
    VecNormalize(envs, norm_obs=False, gamma=GAMMA),
    buffer_size=arguments.decisions,
    learning_starts=480,
    train_freq=1,
    gradient_steps=ENVS,
    gamma=GAMMA,
    action_noise=VectorizedActionNoise(noise, ENVS),
    policy_kwargs={"net_arch": [64, 64]},
    seed=arguments.seed,
    device="cpu",
)


def act(seen):
    return model.predict(seen, deterministic=True)[0]


class Comfort(BaseCallback):
    """Changes the weight of discomfort after evaluations, and keeps the best policy.

    The replay buffer keeps rewards with the weights of their time.
    """

    def _on_training_start(self):
        self.weights, self.evaluated = copy.deepcopy(self.model.policy.state_dict()), 0
        # Until a policy is better: the guideline itself, since zeros shift nothing.
        for name in ("weight", "bias"):
            self.weights[f"actor.mu.4.{name}"].zero_()

    def _on_step(self):
        return True

    def _on_rollout_start(self):
        if self.num_timesteps // every > self.evaluated:
            self.evaluated = self.num_timesteps // every
            comparison, best = constraint.update(act)
            if best:
                self.weights = copy.deepcopy(self.model.policy.state_dict())
            print(f"{self.num_timesteps:7d} decisions: {comparison}, weight {constraint.weight:.2f}", flush=True)

    _on_training_end = _on_rollout_start


# Small networks are slower with several threads, and the engine needs the processors.
torch.set_num_threads(1)
comfort, start = Comfort(), time.perf_counter()
model.learn(arguments.decisions, callback=comfort)
print(f"{model.num_timesteps} decisions in {(time.perf_counter() - start) / 60:.1f} min")
model.policy.load_state_dict(comfort.weights)
for comparison in constraint.evaluate(act, arguments.period, *arguments.test):
    print(f"{comparison.run_period}: {comparison}")
envs.close()
