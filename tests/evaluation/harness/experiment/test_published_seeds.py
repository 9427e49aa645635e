"""What is published was flown on test sets: the experiments that ship, and the commands in the documents."""

import re
from pathlib import Path

import pytest

from indoor_explorers.env.scenarios.seed_sets import SeedUse, use_of
from indoor_explorers.evaluation.harness.experiment.planning import SHIPPED, read_experiment
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest

ROOT = Path(__file__).parents[4]
DOCUMENTS = (
    "evaluation/site/pages/results.md",
    "evaluation/site/pages/results-planners.md",
    "learners/DDDQN.md",
    "learners/places/PLACES.md",
    "learners/BASELINES.md",
    "learners/THESIS.md",
    "evaluation/BOUNDS.md",
)
#: The experiments by which something was, or might have been, chosen: words of their commands.
CHOICES = {"lidar-ranges", "tours-delay"}
#: Lists of policies to fly on a suite, which has seeds of its own.
ON_SUITES = {"pocket-errors"}
EXPERIMENTS = {path.stem: path for path in SHIPPED.glob("*.toml")}


def flown(command: str) -> range:
    """The seeds of a command of a document."""
    named = re.search(r"--experiment (?:\S*/)?([\w-]+?)(?:\.toml)?(?: |$)", command)
    told = read_experiment(EXPERIMENTS[named[1]]) if named else ComparisonRequest()
    first, count = (re.search(rf"--{option} (\d+)", command) for option in ("seed", "episodes"))
    return seeds(int(first[1]) if first else told.seed, int(count[1]) if count else told.episodes)


def seeds(first: int | None, count: int | None) -> range:
    assert first is not None
    assert count is not None
    return range(first, first + count)


def commands() -> list[str]:
    texts = ((ROOT / name).read_text().replace("\\\n", " ").replace("\n", " ") for name in DOCUMENTS)
    found = [
        text for each in texts for text in re.findall(r"compare (--(?:policies|experiment)[^`]*?)(?=`|    \S)", each)
    ]
    return [re.sub(r"\s+", " ", text) for text in found if "--out" in text and re.search("--seed|--experiment", text)]


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_an_experiment_that_ships_flies_a_test_set(name):
    told = read_experiment(EXPERIMENTS[name])
    if name in ON_SUITES:
        assert (told.seed, told.episodes, told.scenario) == (None, None, None)
        return
    assert use_of(seeds(told.seed, told.episodes)) is (SeedUse.TUNING if name in CHOICES else SeedUse.TEST)


@pytest.mark.parametrize("command", commands())
def test_a_command_of_a_document_flies_a_test_set(command):
    assert use_of(flown(command)) is (SeedUse.TUNING if any(name in command for name in CHOICES) else SeedUse.TEST)


def test_the_documents_have_such_commands():
    assert len(commands()) >= 15
