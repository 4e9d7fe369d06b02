"""PPO in one file, after CleanRL, supervises Guideline 36 in a medium office, like the preset `supervisory`.

`python cleanrl_ppo.py` makes 57,600 decisions, each for an hour, in January, and prints the cost relative to the
guideline's, the discomfort of both (K·h per zone and day), and the same for February. Comfort is a constraint, as in
`b2b train`.
"""

import argparse
import copy
import time

import building2building as b2b
import gymnasium as gym
import numpy as np
import torch
from building2building.learning.comfort import ComfortConstraint
from torch import nn
from torch.distributions import Normal

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--building", default="OfficeMedium-0626")
parser.add_argument("--decisions", type=int, default=57_600)
parser.add_argument("--every", type=int, default=5_760, help="decisions between evaluations")
parser.add_argument("--period", default="01-01..01-31")
parser.add_argument("--evaluated", default="01-10..01-23", help="days of the evaluations, among those of training")
parser.add_argument("--test", nargs="*", default=["02-01..02-28"])
parser.add_argument("--seed", type=int, default=0)
args = parser.parse_args()

ACTING, NUM_ENVS, NUM_STEPS, MINIBATCH, EPOCHS = "supervisory:60", 8, 24, 96, 4
# A decision lasts twelve steps, each of which discounts by 0.995.
LEARNING_RATE, GAMMA, GAE_LAMBDA, CLIP, TARGET_KL = 1e-3, 0.995**12, 0.9, 0.2, 0.02
BATCH = NUM_ENVS * NUM_STEPS


def layer_init(layer, std=2**0.5):
    nn.init.orthogonal_(layer.weight, std)
    nn.init.zeros_(layer.bias)
    return layer


def mlp(inputs, outputs, std):
    return nn.Sequential(
        layer_init(nn.Linear(inputs, 64)),
        nn.Tanh(),
        layer_init(nn.Linear(64, 64)),
        nn.Tanh(),
        layer_init(nn.Linear(64, outputs), std),
    )


class Agent(nn.Module):
    def __init__(self, envs):
        super().__init__()
        slots, shifts = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
        self.critic = mlp(slots, 1, 1.0)
        # Training begins with the guideline itself: zeros shift nothing.
        self.actor_mean = mlp(slots, shifts, 0.0)
        self.actor_logstd = nn.Parameter(torch.full((shifts,), -1.0))

    def get_value(self, obs):
        return self.critic(obs).squeeze(-1)

    def get_action_and_value(self, obs, action=None):
        probs = Normal(self.actor_mean(obs), self.actor_logstd.exp())
        if action is None:
            action = probs.sample()
        return action, probs.log_prob(action).sum(-1), self.get_value(obs)

    def act(self, obs):
        """Returns the action without noise."""
        with torch.no_grad():
            return self.actor_mean(torch.as_tensor(obs)).clamp(-1.0, 1.0).numpy()


def make_envs(constraint):
    envs = b2b.make_vec(
        args.building,
        NUM_ENVS,
        task="operate",
        acting=ACTING,
        run_period=args.period,
        window_days=14,
        window_starts=6,
        reward=constraint.reward,
    )
    return gym.wrappers.vector.NormalizeReward(envs, gamma=GAMMA)


def rollout(agent, envs, obs):
    """Makes decisions; returns the last observation and a batch of [steps, environments, ...]."""
    steps = []
    for _ in range(NUM_STEPS):
        with torch.no_grad():
            action, logprob, value = agent.get_action_and_value(obs)
        following, reward, _, truncated, infos = envs.step(action.clamp(-1.0, 1.0).numpy())
        # Episodes are truncated, not terminated: the value of their last observation is bootstrapped.
        last = following.copy()
        for index in np.flatnonzero(truncated):
            last[index] = infos["final_obs"][index]
        with torch.no_grad():
            next_value = agent.get_value(torch.as_tensor(last))
        reward, done = torch.as_tensor(reward, dtype=torch.float32), torch.as_tensor(truncated)
        steps.append((obs, action, logprob, value, next_value, reward, done))
        obs = torch.as_tensor(following)
    return obs, [torch.stack(each) for each in zip(*steps)]


def advantages_of(values, next_values, rewards, dones):
    advantages, lastgaelam = torch.zeros_like(rewards), 0.0
    for t in reversed(range(NUM_STEPS)):
        delta = rewards[t] + GAMMA * next_values[t] - values[t]
        advantages[t] = lastgaelam = delta + GAMMA * GAE_LAMBDA * ~dones[t] * lastgaelam
    return advantages


def update(agent, optimizer, batch):
    """Updates the agent until an epoch has changed it enough."""
    obs, actions, logprobs, values, *others = batch
    advantages = advantages_of(values, *others)
    returns = advantages + values
    flat = [each.flatten(0, 1) for each in (obs, actions, logprobs, advantages, returns)]
    for _ in range(EPOCHS):
        for rows in torch.randperm(BATCH).split(MINIBATCH):
            mb_obs, mb_actions, mb_logprobs, mb_advantages, mb_returns = (each[rows] for each in flat)
            _, newlogprob, newvalue = agent.get_action_and_value(mb_obs, mb_actions)
            logratio = newlogprob - mb_logprobs
            ratio = logratio.exp()
            if (ratio - 1 - logratio).mean() > 1.5 * TARGET_KL:
                return
            mb_advantages = (mb_advantages - mb_advantages.mean()) / (mb_advantages.std() + 1e-8)
            pg_loss = torch.max(-mb_advantages * ratio, -mb_advantages * ratio.clamp(1 - CLIP, 1 + CLIP)).mean()
            v_loss = ((newvalue - mb_returns) ** 2).mean()
            loss = pg_loss + 0.5 * v_loss
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(agent.parameters(), 0.5)
            optimizer.step()


def main():
    torch.manual_seed(args.seed)
    # Small networks are slower with several threads, and the engine needs the processors.
    torch.set_num_threads(1)
    constraint = ComfortConstraint(args.building, args.evaluated, acting=ACTING)
    envs = make_envs(constraint)
    agent = Agent(envs)
    optimizer = torch.optim.Adam(agent.parameters(), lr=LEARNING_RATE, eps=1e-5)
    obs, start = torch.as_tensor(envs.reset(seed=args.seed)[0]), time.perf_counter()
    weights, evaluated, updates = copy.deepcopy(agent.state_dict()), 0, args.decisions // BATCH
    for number in range(updates):
        optimizer.param_groups[0]["lr"] = LEARNING_RATE * (1 - number / updates)
        obs, batch = rollout(agent, envs, obs)
        update(agent, optimizer, batch)
        decisions = (number + 1) * BATCH
        if decisions // args.every > evaluated:
            evaluated = decisions // args.every
            comparison, best = constraint.update(agent.act)
            weights = copy.deepcopy(agent.state_dict()) if best else weights
            print(f"{decisions:7d} decisions: {comparison}, weight {constraint.weight:.2f}", flush=True)
    print(f"{updates * BATCH} decisions in {(time.perf_counter() - start) / 60:.1f} min")
    agent.load_state_dict(weights)
    for comparison in constraint.evaluate(agent.act, args.period, *args.test):
        print(f"{comparison.run_period}: {comparison}")
    envs.close()


if __name__ == "__main__":
    main()
