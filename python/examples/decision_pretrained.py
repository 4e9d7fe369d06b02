"""A decision-pretrained transformer (Lee et al. 2023) for houses, learned from a corpus alone.

    b2b collect --corpus python/examples/houses.toml b2b/houses-v0 --out datasets
    python decision_pretrained.py datasets/b2b/houses-v0 entries

From the observations, actions and rewards of the last hours, it predicts what the expert does now, whoever acted.
Behavior cloning, the lower bound, predicts it from the observation alone. Both enter the problem `adapt-house`, in
unseen houses, where the transformer's context is its own past: it tends to repeat its last action, which in the corpus
is close to what the expert does next.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet
import torch
from building2building.benchmarks import Problem
from torch import nn

SLOTS, ACTUATORS = 90, 2
#: An observation, the previous action and reward, and whether the episode begins: what policies with memory observe.
TOKEN = SLOTS + ACTUATORS + 2

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("corpus", type=Path)
parser.add_argument("folder", type=Path, help="for the entries")
parser.add_argument("--context", type=int, default=48, help="steps that the transformer sees; 12 are an hour")
parser.add_argument("--updates", type=int, default=4_000)
parser.add_argument("--batch", type=int, default=32, help="sequences")
parser.add_argument("--test", nargs="+", help="houses to test in instead of the problem's")
parser.add_argument("--windows", nargs="+", help="weeks to test in instead of the problem's")
arguments = parser.parse_args()


class Policy(nn.Module):
    """A causal transformer from tokens to actions; with a context of 1, a memoryless network on the observation."""

    def __init__(self, context, mean, deviation, width=96, layers=3):
        super().__init__()
        self.context, self.seen = context, TOKEN if context > 1 else SLOTS
        self.register_buffer("mean", mean[: self.seen])
        self.register_buffer("deviation", deviation[: self.seen])
        self.embed = nn.Linear(self.seen, width)
        self.position = nn.Parameter(0.02 * torch.randn(context, width))
        layer = nn.TransformerEncoderLayer(width, 4, 4 * width, 0.0, "gelu", batch_first=True, norm_first=True)
        self.layers = nn.TransformerEncoder(layer, layers, nn.LayerNorm(width), enable_nested_tensor=False)
        self.head = nn.Linear(width, ACTUATORS)

    def forward(self, tokens):
        length = tokens.shape[1]
        scaled = ((tokens[..., : self.seen] - self.mean) / self.deviation).clamp(-5, 5)
        mask = nn.Transformer.generate_square_subsequent_mask(length)
        return self.head(self.layers(self.embed(scaled) + self.position[:length], mask, is_causal=True))


class InContext:
    """A trained policy in a building. Its memory is the last tokens."""

    def __init__(self, policy):
        self.policy, self.tokens = policy, []

    def next_episode(self):
        """Keeps the memory: the next week is in the same house."""

    def __call__(self, observation):
        # The context is as long as in training.
        self.tokens = (
            [*self.tokens[-(self.policy.context - 1) :], observation] if self.policy.context > 1 else [observation]
        )
        with torch.no_grad():
            tokens = torch.as_tensor(np.stack(self.tokens), dtype=torch.float32)
            return self.policy(tokens[None])[0, -1].clamp(-1, 1).numpy()


def read(corpus):
    """Returns the tokens, ``[episodes, steps, TOKEN]``, and the expert's actions."""
    tokens, labels = [], []
    for number in range(json.loads((corpus / "data/metadata.json").read_text())["total_episodes"]):
        rows = pyarrow.parquet.read_table(corpus / f"data/{number}/part-0.parquet").to_pydict()
        observations, actions, rewards = (
            np.array(rows[name][:-1], dtype=np.float32) for name in ("observations", "actions", "rewards")
        )
        previous = np.zeros((len(rewards), ACTUATORS + 2), dtype=np.float32)
        previous[1:, :ACTUATORS], previous[1:, -2], previous[0, -1] = actions[:-1], rewards[:-1], 1
        tokens.append(np.concatenate([observations, previous], axis=1))
        labels.append(np.array([step["expert_actions"] for step in rows["infos"][:-1]], dtype=np.float32))
    return torch.as_tensor(np.stack(tokens)), torch.as_tensor(np.stack(labels)).clamp(-1, 1)


def train(name, policy, tokens, labels):
    """Minimizes the mean squared error over random sequences; the last tenth of the episodes is held out."""
    start, random = time.perf_counter(), np.random.default_rng(0)
    # Without memory, a batch has the same number of steps.
    batch = arguments.batch * arguments.context // policy.context
    optimizer = torch.optim.AdamW(policy.parameters(), lr=1e-3)
    rate = torch.optim.lr_scheduler.OneCycleLR(optimizer, 1e-3, arguments.updates)
    held_out = len(tokens) - max(len(tokens) // 10, 1)

    def loss_of(low, high):
        episodes = random.integers(low, high, batch)
        starts = random.integers(0, tokens.shape[1] - policy.context + 1, batch)
        rows = starts[:, None] + np.arange(policy.context)
        return ((policy(tokens[episodes[:, None], rows]) - labels[episodes[:, None], rows]) ** 2).mean()

    for update in range(arguments.updates):
        loss = loss_of(0, held_out)
        optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        optimizer.step()
        rate.step()
        if (update + 1) % max(arguments.updates // 4, 1) == 0:
            with torch.no_grad():
                error = np.sqrt(np.mean([loss_of(held_out, len(tokens)).item() for _ in range(20)])) / 2
            spent = time.perf_counter() - start
            print(f"{name}: {update + 1} updates, {spent:.0f} s, held-out error {error:.1%} of the range", flush=True)
    return policy.eval()


def enter(name, policy):
    """Enters a policy on the problem and prints its scores."""
    start = time.perf_counter()
    problem = Problem("adapt-house", test=arguments.test, windows=arguments.windows)
    result = problem.run(InContext(policy), arguments.folder / name, name=name, rescale_action=True, jobs=1)
    scores = {}
    for episode in result["measures"]["scores"]:
        scores.setdefault(episode["task"], []).append(episode["resolved_score"])
    medians = ", ".join(f"{task} {np.median(values):.1f}" for task, values in scores.items())
    print(f"{name}: median resolved scores: {medians}; {time.perf_counter() - start:.0f} s")


torch.manual_seed(0)
torch.set_num_threads(1)
tokens, labels = read(arguments.corpus)
flat = tokens.reshape(-1, TOKEN)
statistics = flat.mean(0), flat.std(0).clamp(min=1e-3)
print(f"{len(flat)} steps of {len(tokens)} episodes")
for name, context in [("cloned", 1), ("transformer", arguments.context)]:
    enter(name, train(name, Policy(context, *statistics), tokens, labels))
