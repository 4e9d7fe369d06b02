"""RLlib's PPO (new API) on a house: `python rllib_ppo.py ITERATIONS`."""

import sys

import building2building as b2b
import ray
from ray.rllib.algorithms.ppo import PPOConfig
from ray.tune.registry import register_env

ITERATIONS = int(sys.argv[1]) if len(sys.argv) > 1 else 3


def house(config):
    """Makes an environment with observations and actions in [-1, 1]. Any runner can: it has its own process."""
    return b2b.wrap_env_for_rl(b2b.make_env("SingleFamilyHouse", rescale_action=True, **config))


if __name__ == "__main__":
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    register_env("house", house)
    config = (
        PPOConfig()
        .environment("house", env_config={"run_period": "01-01..01-28", "window_days": 1, "window_starts": 28})
        .env_runners(num_env_runners=1, num_envs_per_env_runner=2, rollout_fragment_length=288)
        .training(train_batch_size_per_learner=576, minibatch_size=144, num_epochs=5, lr=3e-4)
        .learners(num_learners=0)
        .debugging(seed=0)
    )
    algorithm = config.build_algo()
    for _ in range(ITERATIONS):
        results = algorithm.train()
        runners = results["env_runners"]
        print(
            f"{results['num_env_steps_sampled_lifetime']:7.0f} steps  mean episode return "
            f"{runners['episode_return_mean']:.1f}"
        )
    algorithm.stop()
    ray.shutdown()
