"""Search training options with Optuna: `python study_optuna.py FOLDER [TRIALS [STEPS]]`. A study that is run again
continues."""

import math
import sys

import building2building as b2b
import optuna

folder = sys.argv[1]
trials = int(sys.argv[2]) if len(sys.argv) > 2 else 10
steps = int(sys.argv[3]) if len(sys.argv) > 3 else 20_000


def objective(trial: optuna.Trial) -> float:
    """Returns the resolved score of a short run, plus the actuator travel beyond its limit, relative to the limit."""
    ppo = {
        "learning_rate": trial.suggest_float("learning_rate", 1e-4, 3e-3, log=True),
        "gamma": 1 - trial.suggest_float("1 - gamma", 0.003, 0.1, log=True),
    }

    def report(numbers: dict[str, float]) -> bool:
        """Reports the scores of evaluations, and ends a run that cannot become the best."""
        if math.isfinite(numbers.get("score", math.nan)):
            trial.report(numbers["score"], step=int(numbers["steps"]))
        return not trial.should_prune()

    try:
        agent = b2b.train(
            "SingleFamilyHouse-0042",
            task="occupancy",
            run_period="01-09..01-22",
            window_days=2,
            steps=steps,
            environments=2,
            travel_cost=trial.suggest_float("travel_cost", 0.5, 5, log=True),
            ppo=ppo,
            evaluation={"every": steps // 4, "days": 2},
            out=f"{folder}/trial-{trial.number}",
            callback=report,
        )
    except KeyboardInterrupt as end:
        if trial.should_prune():
            raise optuna.TrialPruned() from end
        raise
    assert agent.summary is not None
    return float(agent.summary["resolved_score"] + max(0.0, agent.summary["relative_travel"] - 1))


study = optuna.create_study(
    study_name="house",
    storage=f"sqlite:///{folder}/study.db",
    load_if_exists=True,
    pruner=optuna.pruners.MedianPruner(),
)
study.optimize(objective, n_trials=trials)
print(f"best resolved score {study.best_value:.3f} with {study.best_params}")
