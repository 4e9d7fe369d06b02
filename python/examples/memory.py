"""A policy that learns how much heat a house loses: `python memory.py FOLDER [HOUSE ...]`."""

import sys

import numpy as np
from building2building.benchmarks import Problem


class HeatLoss:
    """Heats in proportion to the outdoor cold and the deviation. Its memory is the first factor, which it learns."""

    def __init__(self, context):
        self.layout, self.loss = context.layout, 0.0

    def next_episode(self):
        """Keeps the loss: the next episode is in the same building."""

    def __call__(self, observation):
        layout = self.layout
        below = -layout.deviations_in(observation, observation[layout.temperatures]).mean()
        cold = (layout.targets_in(observation).mean() - observation[layout.outdoor_temperature]) / 50
        self.loss = np.clip(self.loss + 0.005 * below * cold, 0, 4)
        share = np.clip(self.loss * cold + 0.2 * below, 0, 1)
        return layout.action_low + share * (layout.action_high - layout.action_low)


if __name__ == "__main__":
    folder, *houses = sys.argv[1:]
    problem = Problem("adapt-house", test=houses or None)
    result = problem.run(HeatLoss, folder)
    for point in result["measures"]["by_episode"]["points"]:
        score = point["performance"]["resolved"]["interquartile_mean"]["value"]
        print(f"after {point['days_before']} days in the building: score {score:.3f}")
