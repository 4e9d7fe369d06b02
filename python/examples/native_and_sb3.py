"""Train the native PPO and Stable-Baselines3's PPO on the same house with the same hyperparameters, and compare them.

`python native_and_sb3.py FOLDER` trains both with five seeds for 400,000 steps each (preset `paper`, constant targets,
winter), which takes an hour on two cores. It prints the score of every final policy over the whole season and the
interquartile means, and draws the learning curves in FOLDER/curves.svg. Runs that are already there are not repeated.
"""

import argparse
import csv
import json
from pathlib import Path

import building2building as b2b
import matplotlib
import numpy as np
import torch
from building2building.sb3 import export_onnx, make_sb3_vec
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

matplotlib.use("svg")
from matplotlib import pyplot as plt  # noqa: E402

TASK = "constant"

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("folder", type=Path)
parser.add_argument("--steps", type=int, default=400_000)
parser.add_argument("--seeds", type=int, default=5)
parser.add_argument("--building", default="SingleFamilyHouse-0042")
parser.add_argument("--period", default="winter")
arguments = parser.parse_args()


class Curve(BaseCallback):
    """Collects the mean penalty per step of every rollout."""

    def __init__(self):
        super().__init__()
        self.points = []

    def _on_step(self):
        return True

    def _on_rollout_end(self):
        self.points.append([self.num_timesteps, -float(self.model.rollout_buffer.rewards.mean())])


def score(policy):
    """Returns the score of a policy, without exploration, over the whole period."""
    (row,) = b2b.evaluate(policy, arguments.building, TASK, run_periods=arguments.period).rows
    return row["score"]


def native(folder, seed):
    """Trains the native PPO, and returns its score and its curve."""
    agent = b2b.train(
        arguments.building,
        preset="paper",
        task=TASK,
        run_period=arguments.period,
        steps=arguments.steps,
        seed=seed,
        evaluation={"every": 0, "whole_period": False},
        out=folder,
    )
    with (folder / "progress.csv").open() as file:
        rows = list(csv.DictReader(file))
    return score(agent), [[int(row["steps"]), float(row["training_penalty"])] for row in rows]


def sb3(folder, seed, config):
    """Trains Stable-Baselines3's PPO with the configuration of a native run, and returns its score and its curve."""
    envs = make_sb3_vec(
        None,
        config["environments"],
        building_id=arguments.building,
        task=TASK,
        run_period=arguments.period,
        window_days=config["window_days"] or None,
        window_starts=config["window_starts"] if config["window_days"] else None,
    )
    ppo = config["ppo"]
    model = PPO(
        "MlpPolicy",
        envs,
        learning_rate=ppo["learning_rate"],
        n_steps=ppo["n_steps"],
        batch_size=ppo["batch_size"],
        n_epochs=ppo["epochs"],
        gamma=ppo["gamma"],
        gae_lambda=ppo["gae_lambda"],
        clip_range=ppo["clip_range"],
        ent_coef=ppo["entropy_coefficient"],
        vf_coef=ppo["value_coefficient"],
        max_grad_norm=ppo["max_grad_norm"],
        target_kl=ppo["target_kl"],
        policy_kwargs={
            "net_arch": {"pi": ppo["actor_hidden"], "vf": ppo["critic_hidden"]},
            "activation_fn": {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU}[ppo["activation"]],
            "log_std_init": ppo["initial_log_std"],
        },
        seed=seed,
        device="cpu",
    )
    curve = Curve()
    model.learn(arguments.steps, callback=curve)
    folder.mkdir(parents=True, exist_ok=True)
    export_onnx(model, folder / "policy.onnx")
    envs.close()
    return score(folder / "policy.onnx"), curve.points


def run(name, seed, train):
    """Returns the result of a run, from its file if it has been done before."""
    folder = arguments.folder / f"{name}-{seed}"
    file = folder / "result.json"
    if not file.exists():
        final, curve = train(folder, seed)
        partial = file.with_suffix(".tmp")
        partial.write_text(json.dumps({"score": final, "curve": curve}))
        partial.replace(file)
    result = json.loads(file.read_text())
    print(f"{name:18} seed {seed}: score {result['score']:.1f}", flush=True)
    return result


def interquartile_mean(values):
    """Returns the means of the middle halves of the values along the last axis, as rliable does."""
    values = np.sort(values)
    cut = int(0.25 * values.shape[-1])
    return values[..., cut : values.shape[-1] - cut].mean(axis=-1)


def draw(results):
    """Draws the curves of all seeds and their median."""
    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    for color, (name, runs) in zip(["tab:blue", "tab:orange"], results.items()):
        curves = [np.array(run["curve"]).T for run in runs]
        for steps, penalties in curves:
            axes.plot(steps, penalties, color=color, alpha=0.25, linewidth=0.8)
        median = np.median([penalties for _, penalties in curves], axis=0)
        axes.plot(curves[0][0], median, color=color, label=f"{name}, median of {len(runs)} seeds")
    axes.set(xlabel="environment steps", ylabel="penalty per step (K²), with exploration", yscale="log")
    axes.set_title(f"{arguments.building}, {TASK} targets, {arguments.period}")
    axes.grid(alpha=0.3)
    axes.legend()
    figure.savefig(arguments.folder / "curves.svg")


# Small networks are slower with several threads, and the engine needs the processors.
torch.set_num_threads(1)
results = {"native": [], "Stable-Baselines3": []}
for seed in range(arguments.seeds):
    results["native"].append(run("native", seed, native))
    config = tomllib.loads((arguments.folder / f"native-{seed}" / "config.toml").read_text())
    trained = run("sb3", seed, lambda folder, seed, config=config: sb3(folder, seed, config))
    results["Stable-Baselines3"].append(trained)

random = np.random.default_rng(0)
for name, runs in results.items():
    scores = np.array([run["score"] for run in runs])
    resampled = interquartile_mean(random.choice(scores, (5_000, len(scores))))
    low, high = np.percentile(resampled, [2.5, 97.5])
    print(f"{name}: interquartile mean {interquartile_mean(scores):.0f}, 95 % interval [{low:.0f}, {high:.0f}]")
draw(results)
print(f"curves: {arguments.folder / 'curves.svg'}")
