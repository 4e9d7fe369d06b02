"""RLlib's PPO (new API) on a house, with native vector environments: `python rllib_ppo.py ITERATIONS RUNNERS`."""

import sys
import time

import building2building as b2b
import ray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.tune.registry import register_env

ITERATIONS = int(sys.argv[1]) if len(sys.argv) > 1 else 3
RUNNERS = int(sys.argv[2]) if len(sys.argv) > 2 else 1
ENVS = 2


def house(config):
    """Makes an environment with observations and actions in [-1, 1]; a vector environment for a runner."""
    if "num_envs" in config:
        return b2b.make_vec("SingleFamilyHouse", task="constant", rescale_action=True, normalize=True, **config)
    return b2b.wrap_env_for_rl(b2b.make_env("SingleFamilyHouse", task="constant", rescale_action=True, **config))


if __name__ == "__main__":
    ray.init(num_cpus=1 + RUNNERS, include_dashboard=False, log_to_driver=False)
    register_env("house", house)
    config = (
        PPOConfig()
        .environment("house", env_config={"run_period": "01-01..01-28", "window_days": 1, "window_starts": 28})
        .env_runners(
            num_env_runners=RUNNERS,
            num_envs_per_env_runner=ENVS,
            gym_env_vectorize_mode="vector_entry_point",
            rollout_fragment_length=288,
        )
        .training(train_batch_size_per_learner=288 * ENVS * RUNNERS, minibatch_size=144, num_epochs=5, lr=3e-4)
        .learners(num_learners=0)
        .debugging(seed=0)
    )
    algorithm = config.build_algo()
    for _ in range(ITERATIONS):
        start = time.perf_counter()
        results = algorithm.train()
        runners = results["env_runners"]
        print(
            f"{results['num_env_steps_sampled_lifetime']:7.0f} steps  mean episode return "
            f"{runners['episode_return_mean']:.1f}  "
            f"{runners['num_env_steps_sampled'] / (time.perf_counter() - start):.0f} steps/s"
        )
    algorithm.stop()
    ray.shutdown()
