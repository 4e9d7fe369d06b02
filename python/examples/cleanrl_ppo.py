"""PPO in one file, after CleanRL, on a vector environment: `python cleanrl_ppo.py STEPS`."""

import sys
import time

import building2building as b2b
import numpy as np
import torch
from building2building.scaling import Scale
from torch import nn
from torch.distributions import Normal

STEPS = int(sys.argv[1]) if len(sys.argv) > 1 else 4_096
ENVS, ROLLOUT, EPOCHS, BATCHES = 4, 128, 4, 4
GAMMA, LAMBDA, CLIP, RATE, VALUE, GRADIENT = 0.99, 0.95, 0.2, 3e-4, 0.5, 0.5

torch.manual_seed(0)
torch.set_num_threads(1)
envs = b2b.make_vec(
    "SingleFamilyHouse",
    ENVS,
    task="constant",
    run_period="01-01..01-28",
    window_days=7,
    window_starts=4,
    rescale_action=True,
    autoreset_mode="SameStep",
)
slots, actuators = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
box = envs.single_observation_space
scale = Scale(envs.metadata["observation_names"], box.low, box.high)


def layers(out, gain):
    net = nn.Sequential(nn.Linear(slots, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, out))
    nn.init.orthogonal_(net[-1].weight, gain)
    return net


actor, critic, spread = layers(actuators, 0.01), layers(1, 1.0), nn.Parameter(torch.full((actuators,), -0.5))
parameters = [*actor.parameters(), *critic.parameters(), spread]
optimizer = torch.optim.Adam(parameters, lr=RATE, eps=1e-5)


def see(observations):
    return torch.as_tensor(scale(observations))


observation = see(envs.reset(seed=0)[0])
start = time.perf_counter()
for update in range(max(STEPS // (ENVS * ROLLOUT), 1)):
    seen, acted, logs, rewards, values, nexts, dones = [], [], [], [], [], [], []
    for _ in range(ROLLOUT):
        with torch.no_grad():
            policy = Normal(actor(observation), spread.exp())
            action = policy.sample()
            values.append(critic(observation)[:, 0])
        later, reward, _, truncated, info = envs.step(action.numpy())
        seen.append(observation), acted.append(action), logs.append(policy.log_prob(action).sum(1))
        observation = see(later)
        # Episodes are truncated, not terminated: the value of their last state is bootstrapped.
        after = observation.clone()
        for index in np.flatnonzero(truncated):
            after[index] = see(info["final_obs"][index])
        rewards.append(torch.as_tensor(reward, dtype=torch.float32)), dones.append(torch.as_tensor(truncated))
        with torch.no_grad():
            nexts.append(critic(after)[:, 0])
    advantage, advantages = torch.zeros(ENVS), []
    for step in reversed(range(ROLLOUT)):
        delta = rewards[step] + GAMMA * nexts[step] - values[step]
        advantage = delta + GAMMA * LAMBDA * ~dones[step] * advantage
        advantages.append(advantage)
    advantages = torch.cat(advantages[::-1])
    batch = torch.cat(seen), torch.cat(acted), torch.cat(logs), advantages, advantages + torch.cat(values)
    for _ in range(EPOCHS):
        for rows in torch.randperm(ENVS * ROLLOUT).chunk(BATCHES):
            states, actions, old, gain, returns = (each[rows] for each in batch)
            policy = Normal(actor(states), spread.exp())
            ratio = (policy.log_prob(actions).sum(1) - old).exp()
            gain = (gain - gain.mean()) / (gain.std() + 1e-8)
            loss = -torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain).mean()
            loss = loss + VALUE * ((critic(states)[:, 0] - returns) ** 2).mean()
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(parameters, GRADIENT)
            optimizer.step()
    done = (update + 1) * ENVS * ROLLOUT
    mean = torch.stack(rewards).mean().item()
    print(f"{done:7d} steps  {done / (time.perf_counter() - start):6.0f} steps/s  mean reward {mean:.3f}")
envs.close()
