"""AMAGO in houses by RL² (Duan et al. 2016): `python amago_rl2.py FOLDER --epochs 20`.

A policy with memory enters a house and stays for several days, which are one episode for the learner; then it enters
another. AMAGO (tested: 3.3.0) is not on PyPI. It pins Gymnasium to 0.29 for one thing, which the shim below restores:

    pip install --no-deps git+https://github.com/UT-Austin-RPL/amago
    pip install torch gin-config wandb einops tqdm gym accelerate termcolor
"""

import argparse
import os
import time

# Compilation takes minutes, more than it saves with such small networks.
os.environ.setdefault("TORCHDYNAMO_DISABLE", "1")

import gymnasium
import numpy as np
from building2building.benchmarks import Problem

# Before Gymnasium 1.0, a wrapper forwarded attributes of what it wraps.
if not hasattr(gymnasium.Wrapper, "__getattr__"):

    def forwarded(self, name):
        if name.startswith("_") or name == "env":
            raise AttributeError(name)
        return getattr(self.env, name)

    gymnasium.Wrapper.__getattr__ = forwarded

import amago  # noqa: E402
from amago import cli_utils  # noqa: E402
from amago.envs import AMAGOEnv  # noqa: E402
from amago.loading import DiskTrajDataset  # noqa: E402
from amago.nets.transformer import VanillaAttention  # noqa: E402

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("folder", help="for the buffer and the checkpoints")
parser.add_argument("--epochs", type=int, default=20)
parser.add_argument("--batches", type=int, default=50, help="updates per epoch")
parser.add_argument("--days", type=int, default=3, help="days in a house")
parser.add_argument("--envs", type=int, default=8)
arguments = parser.parse_args()

STEPS_PER_HOUR = 4
STEPS = arguments.days * 24 * STEPS_PER_HOUR


class Houses(gymnasium.Env):
    """A batch of houses in AMAGO's form: spaces of one environment, arrays of all, and episodes of several days.

    AMAGO gives the policy the previous action and reward; the last slot is 1 when a day begins.
    """

    def __init__(self):
        problem = Problem("adapt-house")
        self.envs = problem.make_train_vec(
            arguments.envs,
            resample=arguments.days,
            run_period="01-01..02-25",
            window_days=1,
            window_starts=56,
            timesteps_per_hour=STEPS_PER_HOUR,
            normalize=True,
            autoreset_mode="SameStep",
        )
        slots = self.envs.single_observation_space.shape[0] + 1
        self.observation_space = gymnasium.spaces.Box(-1.0, 1.0, (slots,), np.float32)
        self.action_space = self.envs.single_action_space

    def _seen(self, observations, begins):
        return np.concatenate([observations, np.asarray(begins, np.float32)[:, None]], axis=1)

    def reset(self, *, seed=None, options=None):
        self.days = np.zeros(arguments.envs, dtype=int)
        observations, _ = self.envs.reset(seed=seed)
        return self._seen(observations, np.ones(arguments.envs)), {}

    def step(self, actions):
        observations, rewards, _, ended, _ = self.envs.step(actions)
        self.days += ended
        left = ended & (self.days == arguments.days)
        self.days[left] = 0
        return self._seen(observations, ended), rewards.astype(np.float32), np.zeros_like(left), left, {}


def make():
    return AMAGOEnv(Houses(), env_name="houses", batched_envs=arguments.envs)


def experiment():
    """Returns AMAGO's experiment with a transformer over the days in a house."""
    config = {}
    sequence = cli_utils.switch_traj_encoder(
        config, "transformer", memory_size=64, layers=2, n_heads=4, attention_type=VanillaAttention
    )
    step = cli_utils.switch_tstep_encoder(config, "ff", n_layers=1, d_hidden=128, d_output=64)
    agent = cli_utils.switch_agent(config, "agent", num_critics=2, reward_multiplier=0.1)
    noise = cli_utils.switch_exploration(config, "egreedy", eps_start=0.5, eps_end=0.05, steps_anneal=STEPS * 10)
    cli_utils.use_config(config)
    return amago.Experiment(
        make_train_env=make,
        make_val_env=make,
        env_mode="already_vectorized",
        parallel_actors=arguments.envs,
        max_seq_len=STEPS,
        traj_save_len=STEPS,
        dataset=DiskTrajDataset(dset_root=arguments.folder, dset_name="houses", dset_max_size=2_000),
        ckpt_base_dir=arguments.folder,
        run_name="houses",
        tstep_encoder_type=step,
        traj_encoder_type=sequence,
        agent_type=agent,
        exploration_wrapper_type=noise,
        epochs=arguments.epochs,
        train_timesteps_per_epoch=STEPS,
        train_batches_per_epoch=arguments.batches,
        val_interval=max(arguments.epochs // 4, 1),
        val_timesteps_per_epoch=STEPS,
        ckpt_interval=None,
        batch_size=8,
        dloader_workers=0,
        learning_rate=3e-4,
        sample_actions_val=False,
    )


if __name__ == "__main__":
    start, run = time.perf_counter(), experiment()
    run.start()
    run.learn()
    run.evaluate_val()
    steps = arguments.epochs * STEPS * arguments.envs
    print(f"{steps} steps in {time.perf_counter() - start:.0f} s")
