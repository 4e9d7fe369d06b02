"""A policy that finds out what building it is in: python memory.py FOLDER [HOUSE ...]."""

import sys

import numpy as np
from building2building.benchmarks import Problem


class Climber:
    """Tries actions around the one with the best reward so far, in [-1, 1]. Its memory is what it has tried."""

    def __init__(self):
        self.best, self.action, self.steps = -np.inf, np.zeros(2), 0

    def next_episode(self):
        """Keeps everything: the next episode is in the same building."""

    def __call__(self, observation):
        action, reward, is_first = observation[-4:-2], observation[-2], observation[-1]
        if not is_first and reward > self.best:
            self.best, self.action = reward, action
        self.steps += 1
        return np.clip(self.action + 0.2 * np.sin([self.steps, 2 * self.steps]), -1, 1)


if __name__ == "__main__":
    folder, *houses = sys.argv[1:]
    problem = Problem("adapt-house", test=houses or None)
    result = problem.run(Climber(), folder, rescale_action=True)
    for point in result["measures"]["by_episode"]["points"]:
        score = point["performance"]["resolved"]["interquartile_mean"]["value"]
        print(f"after {point['days_before']} days in the building: score {score:.3f}")
