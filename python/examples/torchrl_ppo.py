"""TorchRL's PPO supervises Guideline 36 in a medium office, like the preset `supervisory`.

`python torchrl_ppo.py` makes 57,600 decisions, each for an hour, in January, and prints the cost relative to the
guideline's, the discomfort of both (K·h per zone and day), and the same for February. Comfort is a constraint, as in
`b2b train`.
"""

import argparse
import copy
import time

import building2building as b2b
import numpy as np
import torch
from building2building.learning.comfort import ComfortConstraint
from gymnasium.wrappers.vector import NormalizeReward
from tensordict import TensorDict
from tensordict.nn import AddStateIndependentNormalScale, TensorDictModule
from torch import nn
from torchrl.collectors import Collector
from torchrl.data import Bounded, Composite, Unbounded
from torchrl.envs import EnvBase
from torchrl.modules import MLP, IndependentNormal, ProbabilisticActor, ValueOperator
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--building", default="OfficeMedium-0626")
parser.add_argument("--decisions", type=int, default=57_600)
parser.add_argument("--every", type=int, default=5_760, help="decisions between evaluations")
parser.add_argument("--period", default="01-01..01-31")
parser.add_argument("--evaluated", default="01-10..01-23", help="days of the evaluations, among those of training")
parser.add_argument("--test", nargs="*", default=["02-01..02-28"])
parser.add_argument("--seed", type=int, default=0)
arguments = parser.parse_args()

ACTING, ENVS, BATCH, MINIBATCH, EPOCHS = "supervisory:60", 8, 192, 96, 4
# A decision lasts twelve steps, each of which discounts by 0.995.
GAMMA, LEARNING_RATE, TARGET_KL = 0.995**12, 1e-3, 0.02


class Decisions(EnvBase):
    """A Gymnasium vector environment, which begins the next episode in the last step of one, for TorchRL."""

    def __init__(self, envs, seed):
        super().__init__(batch_size=[envs.num_envs])
        self.envs = envs
        slots, shifts = envs.single_observation_space.shape, envs.single_action_space.shape
        self.observation_spec = Composite(observation=Unbounded((*self.batch_size, *slots)), shape=self.batch_size)
        self.action_spec = Bounded(-1.0, 1.0, (*self.batch_size, *shifts))
        self.reward_spec = Unbounded((*self.batch_size, 1))
        self.seen = envs.reset(seed=seed)[0]

    def _reset(self, tensordict=None, **_):
        return TensorDict({"observation": torch.as_tensor(self.seen)}, self.batch_size)

    def _step(self, tensordict):
        self.seen, rewards, _, truncated, infos = self.envs.step(tensordict["action"].clamp(-1.0, 1.0).numpy())
        last = self.seen.copy()
        for index in np.flatnonzero(truncated):
            last[index] = infos["final_obs"][index]
        ended = torch.as_tensor(truncated)[:, None]
        values = {
            "observation": torch.as_tensor(last),
            "reward": torch.as_tensor(rewards, dtype=torch.float32)[:, None],
            "done": ended,
            "truncated": ended.clone(),
            "terminated": torch.zeros_like(ended),
        }
        return TensorDict(values, self.batch_size)

    def _set_seed(self, seed):
        torch.manual_seed(seed)


def make_env(constraint):
    envs = b2b.make_vec(
        arguments.building,
        ENVS,
        task="operate",
        acting=ACTING,
        run_period=arguments.period,
        window_days=14,
        window_starts=6,
        reward=constraint.reward,
    )
    return Decisions(NormalizeReward(envs, gamma=GAMMA), arguments.seed)


def mlp(inputs, outputs, gain):
    net = MLP(inputs, outputs, num_cells=[64, 64], activation_class=nn.Tanh)
    layers = [layer for layer in net if isinstance(layer, nn.Linear)]
    for layer, scale in zip(layers, [2**0.5, 2**0.5, gain]):
        nn.init.orthogonal_(layer.weight, scale)
        nn.init.zeros_(layer.bias)
    return net


def make_models(env):
    """Returns actor and critic."""
    slots, shifts = env.observation_spec["observation"].shape[-1], env.action_spec.shape[-1]
    # Training begins with the guideline itself: zeros shift nothing.
    net = nn.Sequential(mlp(slots, shifts, 0.0), AddStateIndependentNormalScale(shifts, init_value=-1.0))
    actor = ProbabilisticActor(
        TensorDictModule(net, ["observation"], ["loc", "scale"]),
        in_keys=["loc", "scale"],
        distribution_class=IndependentNormal,
        return_log_prob=True,
    )
    return actor, ValueOperator(mlp(slots, 1, 1.0), ["observation"])


def update(loss, optimizer, batch):
    """Updates the networks until an epoch has changed the actor enough."""
    for _ in range(EPOCHS):
        for rows in torch.randperm(len(batch)).split(MINIBATCH):
            terms = loss(batch[rows])
            if terms["kl_approx"] > 1.5 * TARGET_KL:
                return
            optimizer.zero_grad()
            (terms["loss_objective"] + terms["loss_critic"]).backward()
            nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
            optimizer.step()


def main():
    torch.manual_seed(arguments.seed)
    # Small networks are slower with several threads, and the engine needs the processors.
    torch.set_num_threads(1)
    constraint = ComfortConstraint(arguments.building, arguments.evaluated, acting=ACTING)
    env = make_env(constraint)
    actor, critic = make_models(env)
    advantage = GAE(gamma=GAMMA, lmbda=0.9, value_network=critic)
    loss = ClipPPOLoss(
        actor,
        critic,
        clip_epsilon=0.2,
        entropy_bonus=False,
        critic_coeff=0.5,
        loss_critic_type="l2",
        normalize_advantage=True,
    )
    optimizer = torch.optim.Adam(loss.parameters(), lr=LEARNING_RATE, eps=1e-5)
    total = arguments.decisions // BATCH * BATCH
    schedule = torch.optim.lr_scheduler.LinearLR(optimizer, 1.0, 0.0, total // BATCH)
    collector = Collector(env, actor, frames_per_batch=BATCH, total_frames=total, auto_register_policy_transforms=False)

    @torch.no_grad()
    def act(observation):
        return actor(TensorDict({"observation": torch.as_tensor(observation)}))["loc"].clamp(-1.0, 1.0).numpy()

    weights, decisions, evaluated, start = copy.deepcopy(actor.state_dict()), 0, 0, time.perf_counter()
    for batch in collector:
        with torch.no_grad():
            advantage(batch)
        update(loss, optimizer, batch.reshape(-1))
        schedule.step()
        decisions += BATCH
        if decisions // arguments.every > evaluated:
            evaluated = decisions // arguments.every
            comparison, best = constraint.update(act)
            weights = copy.deepcopy(actor.state_dict()) if best else weights
            print(f"{decisions:7d} decisions: {comparison}, weight {constraint.weight:.2f}", flush=True)
    print(f"{decisions} decisions in {(time.perf_counter() - start) / 60:.1f} min")
    actor.load_state_dict(weights)
    for comparison in constraint.evaluate(act, arguments.period, *arguments.test):
        print(f"{comparison.run_period}: {comparison}")
    collector.shutdown()


if __name__ == "__main__":
    main()
