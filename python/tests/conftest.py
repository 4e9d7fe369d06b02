import os
from pathlib import Path

import building2building as b2b
import pytest

DAY = "01-01..01-01"


def pytest_addoption(parser):
    parser.addoption("--learners", action="store_true", help="also run the tests that train (needs torch)")


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--learners"):
        skip = pytest.mark.skip(reason="needs --learners")
        for item in items:
            if "learners" in item.keywords:
                item.add_marker(skip)


@pytest.fixture(scope="session")
def b2b_command():
    """The command ``b2b`` that the Rust tests built."""
    root = Path(__file__).parents[2]
    command = root / os.environ.get("CARGO_TARGET_DIR", "target") / "gate/b2b"
    if not command.exists():
        pytest.skip(f"{command} does not exist; run: cargo build --profile gate")
    return command


@pytest.fixture
def make():
    """``make_env`` for one day with constant targets; closes what it made."""
    made = []

    def make(building_type="OfficeSmall", **arguments):
        made.append(b2b.make_env(building_type, **{"run_period": DAY, "task": "constant", **arguments}))
        return made[-1]

    yield make
    for env in made:
        env.close()


@pytest.fixture(scope="module")
def office():
    """A small office that the tests of a module share."""
    env = b2b.make_env("OfficeSmall", run_period=DAY, task="constant")
    yield env
    env.close()
