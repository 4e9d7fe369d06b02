"""TorchRL's PPO for four building types at once: `python torchrl_masked.py --steps 200000`.

Types have different observations and actuators, padded to one width. The policy observes the mask of its actuators, and
log probabilities exclude padding. It is tested in buildings that it has not seen.
"""

import argparse
import time

import building2building as b2b
import numpy as np
import torch
from tensordict import TensorDict
from tensordict.nn import TensorDictModule
from torch import nn
from torchrl.collectors import Collector
from torchrl.data import Bounded, Composite, Unbounded
from torchrl.envs import EnvBase, ExplorationType, TransformedEnv, set_exploration_type
from torchrl.envs.transforms import RewardClipping, RewardScaling
from torchrl.modules import ProbabilisticActor, ValueOperator
from torchrl.objectives import ClipPPOLoss
from torchrl.objectives.value import GAE

TYPES = ["OfficeSmall", "RetailStandalone", "RestaurantFastFood", "Warehouse"]
TASK, EPOCHS, BATCH = "occupancy", 4, 512

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--steps", type=int, default=200_000)
parser.add_argument("--envs", type=int, default=8)
parser.add_argument("--rollout", type=int, default=288, help="steps per environment between updates")
parser.add_argument("--tests", type=int, default=2, help="test buildings of each type")
arguments = parser.parse_args()


class Buildings(EnvBase):
    """A `BuildingVectorEnv` for TorchRL, with the mask of the actuators as a second observation."""

    def __init__(self, envs):
        super().__init__(batch_size=[envs.num_envs])
        self.envs = envs
        batch, actuators = self.batch_size, envs.single_action_space.shape[0]
        self.observation_spec = Composite(
            observation=Unbounded((*batch, envs.single_observation_space.shape[0])),
            action_mask=Unbounded((*batch, actuators)),
            shape=batch,
        )
        self.action_spec = Bounded(-1.0, 1.0, (*batch, actuators))
        self.reward_spec = Unbounded((*batch, 1))
        self.started = False

    def _seen(self, observations, **others):
        mask = torch.as_tensor(self.envs.action_mask(), dtype=torch.float32)
        seen = {"observation": torch.as_tensor(observations), "action_mask": mask}
        return TensorDict(seen | others, self.batch_size)

    def _reset(self, tensordict=None, **_):
        mask = np.ones(self.envs.num_envs, dtype=bool)
        if tensordict is not None and "_reset" in tensordict:
            mask = tensordict["_reset"].numpy().reshape(-1)
        # A reset with a mask continues the draws of buildings; one with a seed restarts them.
        observations, _ = self.envs.reset(options={"reset_mask": mask}) if self.started else self.envs.reset(seed=0)
        self.started = True
        return self._seen(observations)

    def _step(self, tensordict):
        observations, rewards, _, truncated, _ = self.envs.step(tensordict["action"].numpy())
        reward = torch.as_tensor(rewards, dtype=torch.float32)[:, None]
        ended = torch.as_tensor(truncated)[:, None]
        return self._seen(
            observations, reward=reward, done=ended, truncated=ended.clone(), terminated=torch.zeros_like(ended)
        )

    def _set_seed(self, seed):
        torch.manual_seed(seed)


class MaskedNormal(torch.distributions.Normal):
    """A normal distribution that leaves out padding, where the mask is 0."""

    def __init__(self, loc, scale, mask):
        super().__init__(loc, scale)
        self.mask = mask

    @property
    def deterministic_sample(self):
        return self.mean

    def log_prob(self, value):
        return (super().log_prob(value) * self.mask).sum(-1)

    def entropy(self):
        return (super().entropy() * self.mask).sum(-1)


def make(buildings, count, **options):
    """Makes a batch of buildings whose observations are normalized by fixed bounds."""
    return b2b.make_vec(None, count, buildings=buildings, task=TASK, rescale_action=True, normalize=True, **options)


def layers(inputs, outputs, gain):
    net = nn.Sequential(nn.Linear(inputs, 256), nn.Tanh(), nn.Linear(256, 256), nn.Tanh(), nn.Linear(256, outputs))
    nn.init.orthogonal_(net[-1].weight, gain)
    return net


class Actor(nn.Module):
    """The mean and the standard deviation of every actuator."""

    def __init__(self, slots, actuators):
        super().__init__()
        self.net = layers(slots + actuators, actuators, 0.01)
        self.spread = nn.Parameter(torch.full((actuators,), -0.5))

    def forward(self, observation, mask):
        mean = self.net(torch.cat([observation, mask], -1))
        return mean, self.spread.exp().expand_as(mean)


class Critic(nn.Module):
    """The value of an observation."""

    def __init__(self, slots, actuators):
        super().__init__()
        self.net = layers(slots + actuators, 1, 1.0)

    def forward(self, observation, mask):
        return self.net(torch.cat([observation, mask], -1))


def test(actor, buildings, scale):
    """Prints the score of every type over two days, relative to the reactive controllers; lower is better."""
    period = "01-15..01-16"
    envs = make(buildings, len(buildings), run_period=period, autoreset_mode="Disabled")
    if not np.array_equal(envs.scale.low, scale.low) or not np.array_equal(envs.scale.span, scale.span):
        raise ValueError("the test buildings are normalized by other bounds")
    batch, returns = Buildings(envs), np.zeros(len(buildings))
    with set_exploration_type(ExplorationType.DETERMINISTIC), torch.no_grad():
        rolled = batch.rollout(2 * 288, actor)
    returns = rolled["next", "reward"].sum(1)[:, 0].tolist()
    envs.close()
    scores = [b2b.compute_normalized_score(*each, TASK, period) for each in zip(returns, buildings)]
    means = np.reshape(scores, (len(TYPES), -1)).mean(1)
    print("  ".join(f"{name} {mean:.1f}" for name, mean in zip(TYPES, means)))


def main():
    torch.manual_seed(0)
    # Small networks are slower with several threads, and the engine needs the processors.
    torch.set_num_threads(1)
    seen = [each for name in TYPES for each in b2b.list_buildings(name, "train")]
    unseen = [each for name in TYPES for each in b2b.list_buildings(name, "test_small")[: arguments.tests]]
    days = {"run_period": "01-01..02-25", "window_days": 1, "window_starts": 56}
    envs = make(seen, arguments.envs, resample=4, autoreset_mode="Disabled", **days)
    widths = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
    print(f"{len(seen)} buildings of {len(TYPES)} types; {widths[0]} slots and {widths[1]} actuators with padding")
    inputs = ["observation", "action_mask"]
    actor = ProbabilisticActor(
        TensorDictModule(Actor(*widths), inputs, ["loc", "scale"]),
        in_keys={"loc": "loc", "scale": "scale", "mask": "action_mask"},
        distribution_class=MaskedNormal,
        return_log_prob=True,
    )
    critic = ValueOperator(Critic(*widths), inputs)
    test(actor, unseen, envs.scale)
    env = TransformedEnv(Buildings(envs), RewardScaling(0.0, 0.1))
    env.append_transform(RewardClipping(-10.0, 10.0))
    size = arguments.envs * arguments.rollout
    collector = Collector(
        env,
        actor,
        frames_per_batch=size,
        auto_register_policy_transforms=False,
        total_frames=max(arguments.steps // size, 1) * size,
    )
    advantage = GAE(gamma=0.98, lmbda=0.95, value_network=critic)
    loss = ClipPPOLoss(actor, critic, entropy_coeff=0.0, normalize_advantage=True)
    optimizer = torch.optim.Adam(loss.parameters(), lr=3e-4, eps=1e-5)
    start = time.perf_counter()
    for number, batch in enumerate(collector):
        with torch.no_grad():
            advantage(batch)
        flat = batch.reshape(-1)
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(flat)).split(BATCH):
                terms = loss(flat[rows])
                total = terms["loss_objective"] + terms["loss_critic"]
                optimizer.zero_grad()
                total.backward()
                nn.utils.clip_grad_norm_(loss.parameters(), 0.5)
                optimizer.step()
        if number % 10 == 9 or (number + 2) * size > arguments.steps:
            done, spent = (number + 1) * size, time.perf_counter() - start
            reward = 10 * batch["next", "reward"].mean().item()
            print(f"{done:8d} steps  {done / spent:6.0f} steps/s  mean reward {reward:.2f}", flush=True)
    test(actor, unseen, envs.scale)
    collector.shutdown()
    envs.close()


if __name__ == "__main__":
    main()
