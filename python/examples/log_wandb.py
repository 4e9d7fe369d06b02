"""Log a training run to Weights & Biases, offline: `python log_wandb.py FOLDER [STEPS]`; later
`wandb sync FOLDER/wandb/offline-run-*`."""

import math
import sys

import building2building as b2b
import wandb

folder = sys.argv[1]
steps = int(sys.argv[2]) if len(sys.argv) > 2 else 20_000
options = {"task": "occupancy", "run_period": "01-09..01-22", "window_days": 2, "steps": steps, "environments": 2}

run = wandb.init(project="building2building", mode="offline", dir=folder, config=options)


def log(numbers: dict[str, float]) -> None:
    """Logs the numbers of an update; evaluation numbers are NaN in updates without an evaluation."""
    run.log({name: value for name, value in numbers.items() if math.isfinite(value)}, step=int(numbers["steps"]))


agent = b2b.train("SingleFamilyHouse-0042", out=f"{folder}/run", callback=log, **options)
run.summary.update(agent.summary or {})
artifact = wandb.Artifact("agent", type="model")
artifact.add_dir(f"{folder}/run")
run.log_artifact(artifact)
run.finish()
print("logged", run.dir)
