"""RLlib's PPO (new API) supervises Guideline 36 in a medium office, like the preset `supervisory`.

`python rllib_ppo.py` makes 57,600 decisions, each for an hour, in January, and prints the cost relative to the
guideline's, the discomfort of both (K·h per zone and day), and the same for February. Comfort is a constraint, as in
`b2b train`. With `--runners`, that many processes of Ray make the decisions, each with a native vector environment.
"""

import argparse
import copy
import time

import building2building as b2b
import numpy as np
import ray
import torch
from building2building.learning.comfort import ComfortConstraint
from gymnasium.vector import AutoresetMode, VectorWrapper
from gymnasium.wrappers.vector import NormalizeReward
from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.algorithms.ppo.torch.default_ppo_torch_rl_module import DefaultPPOTorchRLModule
from ray.rllib.core.rl_module.default_model_config import DefaultModelConfig
from ray.rllib.core.rl_module.rl_module import RLModuleSpec
from ray.tune.registry import register_env

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--building", default="OfficeMedium-0626")
parser.add_argument("--decisions", type=int, default=57_600)
parser.add_argument("--every", type=int, default=5_760, help="decisions between evaluations")
parser.add_argument("--period", default="01-01..01-31")
parser.add_argument("--evaluated", default="01-10..01-23", help="days of the evaluations, among those of training")
parser.add_argument("--test", nargs="*", default=["02-01..02-28"])
parser.add_argument("--runners", type=int, default=0, choices=[0, 1, 2, 4, 8], help="processes of Ray; 0: this process")
parser.add_argument("--seed", type=int, default=0)

ACTING, ENVS, BATCH, MINIBATCH, EPOCHS = "supervisory:60", 8, 192, 96, 4
# A decision lasts twelve steps, each of which discounts by 0.995.
GAMMA = 0.995**12


class NextStep(VectorWrapper):
    """Returns the last observation of an episode, and begins the next in another step, as RLlib expects."""

    def __init__(self, env):
        super().__init__(env)
        self.metadata = {**env.metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}
        self.ended = np.zeros(env.num_envs, bool)

    def reset(self, *, seed=None, options=None):
        self.ended[:] = False
        return self.env.reset(seed=seed, options=options)

    def step(self, actions):
        seen, rewards, terminated, truncated, infos = self.env.step(actions)
        seen, begun = seen.copy(), self.ended
        if begun.any():
            seen[begun] = self.env.reset(options={"reset_mask": begun})[0][begun]
        self.ended = truncated & ~begun
        for index in np.flatnonzero(self.ended):
            seen[index] = infos["final_obs"][index]
        return seen, np.where(begun, 0.0, rewards), terminated, self.ended, {}


class Supervisor(DefaultPPOTorchRLModule):
    """RLlib's policy, which at first shifts nothing: training begins with the guideline itself."""

    def setup(self):
        super().setup()
        torch.nn.init.zeros_(self.pi.net.mlp[-1].weight)
        torch.nn.init.zeros_(self.pi.net.mlp[-1].bias)
        torch.nn.init.constant_(self.pi.log_std, -1.0)


def make_envs(config):
    """Makes the vector environment of a runner; its weight of discomfort is `unwrapped.constraint.weight`."""
    building, period, count = config["building"], config["period"], config.get("num_envs", 1)
    constraint = ComfortConstraint(building, period, acting=ACTING)
    envs = b2b.make_vec(
        building,
        count,
        task="operate",
        acting=ACTING,
        run_period=period,
        window_days=14,
        window_starts=6,
        reward=constraint.reward,
    )
    envs.unwrapped.constraint = constraint
    return NormalizeReward(NextStep(envs), gamma=GAMMA)


def algorithm_of(arguments):
    """Builds RLlib's PPO."""
    runners = max(arguments.runners, 1)
    model = DefaultModelConfig(
        fcnet_hiddens=[64, 64],
        fcnet_kernel_initializer="orthogonal_",
        fcnet_kernel_initializer_kwargs={"gain": 2**0.5},
        free_log_std=True,
        vf_share_layers=False,
    )
    config = (
        PPOConfig()
        .environment("supervised", env_config={"building": arguments.building, "period": arguments.period})
        .env_runners(
            num_env_runners=arguments.runners,
            num_envs_per_env_runner=ENVS // runners,
            gym_env_vectorize_mode="vector_entry_point",
            rollout_fragment_length=BATCH // ENVS,
        )
        .rl_module(rl_module_spec=RLModuleSpec(module_class=Supervisor, model_config=model))
        .training(
            train_batch_size_per_learner=BATCH,
            minibatch_size=MINIBATCH,
            num_epochs=EPOCHS,
            lr=[[0, 1e-3], [arguments.decisions, 0.0]],
            gamma=GAMMA,
            lambda_=0.9,
            clip_param=0.2,
            vf_loss_coeff=0.5,
            grad_clip=0.5,
            grad_clip_by="global_norm",
        )
        .learners(num_learners=0)
        .debugging(seed=arguments.seed)
    )
    return config.build_algo()


def main():
    arguments = parser.parse_args()
    ray.init(num_cpus=1 + arguments.runners, include_dashboard=False, log_to_driver=False)
    register_env("supervised", make_envs)
    # Small networks are slower with several threads, and the engine needs the processors.
    torch.set_num_threads(1)
    constraint = ComfortConstraint(arguments.building, arguments.evaluated, acting=ACTING)
    algorithm = algorithm_of(arguments)
    module = algorithm.get_module()

    def act(observation):
        with torch.no_grad():
            outputs = module.forward_inference({"obs": torch.as_tensor(observation)[None]})
        mean, _ = outputs["action_dist_inputs"][0].chunk(2)
        return mean.clamp(-1.0, 1.0).numpy()

    def follow(runner):
        if runner.env is not None:
            runner.env.unwrapped.constraint.weight = weight

    weights, decisions, evaluated, start = copy.deepcopy(module.get_state()), 0, 0, time.perf_counter()
    while decisions < arguments.decisions:
        decisions = int(algorithm.train()["num_env_steps_sampled_lifetime"])
        if decisions // arguments.every > evaluated:
            evaluated = decisions // arguments.every
            comparison, best = constraint.update(act)
            weight = constraint.weight
            algorithm.env_runner_group.foreach_env_runner(follow)
            weights = copy.deepcopy(module.get_state()) if best else weights
            print(f"{decisions:7d} decisions: {comparison}, weight {weight:.2f}", flush=True)
    print(f"{decisions} decisions in {(time.perf_counter() - start) / 60:.1f} min")
    module.set_state(weights)
    for comparison in constraint.evaluate(act, arguments.period, *arguments.test):
        print(f"{comparison.run_period}: {comparison}")
    algorithm.stop()
    ray.shutdown()


if __name__ == "__main__":
    main()
