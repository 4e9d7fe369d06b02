"""Train Stable-Baselines3's PPO on the training houses of a benchmark problem and export it for `b2b benchmark run`.

`python benchmark_ppo.py ppo.onnx 200000`, then
`b2b benchmark run dynamics-house --policy ppo.onnx --trained-steps 200000 --out results/ppo`.
"""

import sys
from pathlib import Path

from building2building.benchmarks import DynamicsAdaptation
from building2building.sb3 import export_onnx, make_sb3_vec
from stable_baselines3 import PPO

path = Path(sys.argv[1] if len(sys.argv) > 1 else "ppo.onnx")
steps = int(sys.argv[2]) if len(sys.argv) > 2 else 2_048

problem = DynamicsAdaptation("house")
# Every episode is a week of one of the 900 training houses.
envs = make_sb3_vec(problem.make_train_vec(8, window_days=7, autoreset_mode="SameStep"))
model = PPO("MlpPolicy", envs, n_steps=256, batch_size=256, seed=0, device="cpu")
model.learn(steps)
path.parent.mkdir(parents=True, exist_ok=True)
export_onnx(model, path)
print(f"{path}: {model.num_timesteps} steps, {envs.envs.statistics['episodes']} episodes")
envs.close()
