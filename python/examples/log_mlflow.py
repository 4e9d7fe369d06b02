"""Log a training run to MLflow, in a file: `python log_mlflow.py FOLDER [STEPS]`; then
`mlflow ui --backend-store-uri sqlite:///FOLDER/mlflow.db`."""

import math
import sys

import building2building as b2b
import mlflow

folder = sys.argv[1]
steps = int(sys.argv[2]) if len(sys.argv) > 2 else 20_000
options = {"task": "occupancy", "run_period": "01-09..01-22", "window_days": 2, "steps": steps, "environments": 2}

mlflow.set_tracking_uri(f"sqlite:///{folder}/mlflow.db")
mlflow.set_experiment("building2building")


def log(numbers: dict[str, float]) -> None:
    """Logs the numbers of an update; evaluation numbers are NaN in updates without an evaluation."""
    finite = {name: value for name, value in numbers.items() if math.isfinite(value)}
    mlflow.log_metrics(finite, step=int(numbers["steps"]))


with mlflow.start_run() as run:
    mlflow.log_params(options)
    agent = b2b.train("SingleFamilyHouse-0042", out=f"{folder}/run", callback=log, **options)
    mlflow.log_metrics({f"final_{name}": agent.summary[name] for name in ("score", "resolved_score")})
    print("logged", run.info.run_id)
