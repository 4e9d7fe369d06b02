"""Train Stable-Baselines3's PPO on the training houses of a benchmark problem and export it for `b2b benchmark run`.

`python benchmark_ppo.py ppo.onnx 200000`, then
`b2b benchmark run dynamics-house --policy ppo.onnx --trained-steps 200000 --out results/ppo`.
"""

import sys
from pathlib import Path

import numpy as np
import torch
from building2building.benchmarks import DynamicsAdaptation
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv

path = Path(sys.argv[1] if len(sys.argv) > 1 else "ppo.onnx")
steps = int(sys.argv[2]) if len(sys.argv) > 2 else 2_048
HOUSES = 8

problem = DynamicsAdaptation("house")
single = problem.make_train_envs(HOUSES, rescale_action=True, window_days=7)
# Bounds that scale temperatures to about 1 and leave padding at 0.
box = single[0].observation_space
low, high = np.clip(box.low, -40, 0), np.clip(box.high, 1, 400)


class Scaled(torch.nn.Module):
    """The policy with its scaling, so that the ONNX file takes unscaled observations."""

    def __init__(self, policy):
        super().__init__()
        self.policy = policy
        self.register_buffer("low", torch.as_tensor(low, dtype=torch.float32))
        self.register_buffer("span", torch.as_tensor(high - low, dtype=torch.float32))

    def forward(self, observation):
        scaled = 2 * (observation - self.low) / self.span - 1
        return self.policy._predict(scaled, deterministic=True).clamp(-1, 1)


def scaled(env):
    import gymnasium

    space = gymnasium.spaces.Box(-np.inf, np.inf, box.shape, dtype=np.float32)
    scale = lambda seen: (2 * (seen - low) / (high - low) - 1).astype(np.float32)  # noqa: E731
    return gymnasium.wrappers.TransformObservation(env, scale, space)


envs = DummyVecEnv([lambda env=env: scaled(env) for env in single])
model = PPO("MlpPolicy", envs, n_steps=256, batch_size=256, seed=0, device="cpu")
model.learn(steps)
path.parent.mkdir(parents=True, exist_ok=True)
observation = torch.zeros(1, box.shape[0])
torch.onnx.export(Scaled(model.policy), (observation,), str(path), opset_version=17, dynamo=False)
print(f"{path}: {model.num_timesteps} steps on {', '.join(problem.train_building_ids(HOUSES))}")
envs.close()
