"""Comfort as a constraint on a policy that another library trains, as in ``b2b train``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..buildings import Building
from ..env.tasks import Task
from ..errors import EvaluationError, SettingError
from ..evaluation import evaluate
from .acting import acting_controller

Array = NDArray[Any]
Policy = Callable[[Array], ArrayLike]

#: Steps of an evaluation in a day.
_STEPS = 288


@dataclass(frozen=True)
class Comparison:
    """A policy, without exploration, beside ``guideline36`` in the same building and run period."""

    run_period: str
    #: Cost, or another resource of the task, relative to the guideline's.
    cost: float
    #: Discomfort, K·h per controlled zone and day.
    discomfort: float
    #: Discomfort of the guideline, K·h per controlled zone and day.
    allowed: float
    #: Score at comfort: the relative cost, and more with excess discomfort. Lower is better.
    score: float

    def __str__(self) -> str:
        comfort = f"discomfort {self.discomfort:.2f} instead of {self.allowed:.2f}"
        return f"cost {self.cost:.3f}, {comfort}, score {self.score:.3f}"


class ComfortConstraint:
    """A weight of discomfort that follows evaluations, until the policy leaves as much discomfort as ``guideline36``.

    >>> constraint = ComfortConstraint("OfficeSmall-0042", "01-10..01-23")  # doctest: +SKIP
    >>> envs = b2b.make_vec(..., acting="supervisory:60", reward=constraint.reward)  # doctest: +SKIP
    >>> comparison, best = constraint.update(policy)  # after some training, again and again  # doctest: +SKIP

    A policy is a function from an observation of the acting environment, f32 ``[slots]``, to an action in [-1, 1],
    ``[actions]``.
    """

    def __init__(
        self,
        building: str | Building,
        run_period: str,
        *,
        task: Task = "operate",
        acting: str = "supervisory:60",
        observation: str = "features",
    ):
        """``run_period`` is the run period of the evaluations that change the weight."""
        self.building, self.run_period, self.task = building, run_period, task
        self.acting, self.observation = acting, observation
        #: Weight of discomfort, relative to the task's own.
        self.weight = 1.0
        #: Lowest score of an update; at first 1, the guideline's.
        self.best = 1.0

    def reward(self, info: dict[str, Any]) -> Any:
        """Returns the task's reward with this weight of discomfort; pass it to the environments as ``reward``."""
        terms = info["reward_terms"]
        return self.weight * terms["temperature"] + terms["energy"]

    def evaluate(self, policy: Policy, *run_periods: str) -> list[Comparison]:
        """Compares a policy with the guideline in every run period.

        Raises :class:`~building2building.errors.SettingError` for a task that is not operation, and
        :class:`~building2building.errors.EvaluationError` for an episode that was lost.
        """
        controller = acting_controller(policy, self.acting, self.observation)
        result = evaluate(controller, self.building, self.task, run_periods=run_periods, name="policy", jobs=1)
        return [self._comparison(row) for row in result.rows]

    def update(self, policy: Policy) -> tuple[Comparison, bool]:
        """Evaluates a policy and changes the weight; also returns whether its score is below the guideline's and the
        lowest so far.

        The weight is multiplied by (D + 0.05)/(D₀ + 0.05), limited to [0.5, 2], with the discomfort of the policy and
        of the guideline in K·h per zone and day, and stays within [0.03, 30]. Raises as :meth:`evaluate`.
        """
        (comparison,) = self.evaluate(policy, self.run_period)
        self.weight = _core.next_comfort_weight(self.weight, comparison.discomfort, comparison.allowed)
        is_best = comparison.score < self.best
        self.best = min(comparison.score, self.best)
        return comparison, is_best

    def _comparison(self, row: dict[str, Any]) -> Comparison:
        if row["lost"] is not None:
            raise EvaluationError(f"the episode in {row['period']} was lost: {row['lost']}")
        if row["baseline_discomfort_k_h"] is None:
            raise SettingError(f"the task {self.task!r} has no discomfort; pass a task of operation, such as 'operate'")
        days = row["steps"] / _STEPS
        discomfort, allowed = row["tdis_tot"] / days, row["baseline_discomfort_k_h"] / days
        return Comparison(row["period"], row["relative_resource"], discomfort, allowed, row["score"])
