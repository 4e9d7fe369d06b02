"""Train Stable-Baselines3's PPO on one house, constant task, winter, with the hyperparameters of the paper's appendix.

`python train_ppo.py --steps 200000` prints the learning curve, the share of time spent in the environments, and the
score relative to the reactive controller before and after training. `--onnx FILE` exports the policy for
`b2b evaluate`.
"""

import argparse
import time

import building2building as b2b
import numpy as np
import torch
from building2building.sb3 import export_onnx, make_sb3_vec
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--steps", type=int, default=9_408)
parser.add_argument("--building", default="SingleFamilyHouse-0042")
parser.add_argument("--period", default="winter")
parser.add_argument("--envs", type=int, default=14)
parser.add_argument("--n-steps", type=int, default=672, help="steps per environment between updates")
parser.add_argument("--seed", type=int, default=0)
parser.add_argument("--onnx", metavar="FILE")
arguments = parser.parse_args()

# Episodes of a week that begin on one of eight days of the period.
envs = make_sb3_vec(
    None,
    arguments.envs,
    building_id=arguments.building,
    task="constant",
    run_period=arguments.period,
    window_days=7,
    window_starts=8,
)
model = PPO(
    "MlpPolicy",
    envs,
    learning_rate=5e-5,
    n_steps=arguments.n_steps,
    batch_size=336,
    n_epochs=5,
    gamma=0.98,
    gae_lambda=0.95,
    clip_range=0.2,
    ent_coef=0.01,
    vf_coef=0.5,
    max_grad_norm=0.5,
    target_kl=0.02,
    policy_kwargs={
        "net_arch": {"pi": [256, 256], "vf": [256, 256]},
        "activation_fn": torch.nn.Tanh,
        "ortho_init": True,
        "log_std_init": -1.0,
    },
    seed=arguments.seed,
    device="cpu",
)


class Curve(BaseCallback):
    """Prints a line per rollout, with the share of time spent in the environments."""

    def __init__(self):
        super().__init__()
        self.start, self.stepping = time.perf_counter(), 0.0
        wait = envs.step_wait

        def timed():
            before = time.perf_counter()
            stepped = wait()
            self.stepping += time.perf_counter() - before
            return stepped

        envs.step_wait = timed
        print("  steps  mean reward  explained variance  steps/s  time in environments")

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        buffer, spent = self.model.rollout_buffer, time.perf_counter() - self.start
        explained = 1 - np.var(buffer.returns - buffer.values) / np.var(buffer.returns)
        print(
            f"{self.num_timesteps:7d}  {buffer.rewards.mean():11.3f}  {explained:18.2f}  "
            f"{self.num_timesteps / spent:7.0f}  {self.stepping / spent:20.0%}",
            flush=True,
        )


def ppo(observation):
    return model.predict(observation, deterministic=True)[0]


def score(when):
    """Evaluates the deterministic policy on the whole period in one episode."""
    options = {"run_periods": arguments.period, "rescale_action": True, "normalize": True}
    (row,) = b2b.evaluate(ppo, arguments.building, "constant", **options).rows
    print(
        f"{when}: return {row['return']:.0f}, reactive controller {row['baseline_return']:.0f}, "
        f"score {row['score']:.2f}, RMS deviation {row['rms_deviation_k']:.2f} K"
    )


# Small networks are slower with several threads, and the engine needs the processors.
torch.set_num_threads(1)
score("before training")
curve = Curve()
model.learn(arguments.steps, callback=curve)
spent = time.perf_counter() - curve.start
print(
    f"{model.num_timesteps} steps in {spent:.0f} s: {model.num_timesteps / spent:.0f} steps/s, "
    f"{curve.stepping / spent:.0%} of the time in environments"
)
score("after training")
if arguments.onnx:
    export_onnx(model, arguments.onnx)
    print(f"wrote {arguments.onnx}: b2b evaluate {arguments.building} --policy {arguments.onnx} --out results")
envs.close()
