"""What the documents claim as evidence: no figure in bold, a card for each set of weights, and a final test."""

import json
import re
from pathlib import Path

import pytest

from indoor_explorers.env.scenarios.seed_sets import fresh_test_set, seed_set
from indoor_explorers.env.scenarios.suites.suite import digest_of
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from tests.documents import ROOT

MARKDOWN = [
    path for folder in ("evaluation", "learners", "planners", "env") for path in sorted((ROOT / folder).rglob("*.md"))
]
WEIGHTS = [
    path for folder in ("learners", "env", "planners") for path in sorted((ROOT / folder).rglob("*.safetensors"))
]
CARDS = (ROOT / "learners" / "MODEL_CARDS.md").read_text("utf-8")
NEXT_TEST = (ROOT / "evaluation" / "NEXT_TEST.md").read_text("utf-8")


@pytest.mark.parametrize("path", [ROOT / "README.md", *MARKDOWN], ids=lambda path: path.stem)
def test_no_figure_is_bold(path):
    assert not re.findall(
        r"\*\*[-+]?[.\d][.,\d]*(?: %)?\*\*", path.read_text("utf-8")
    )  # bold means significant, in reports


@pytest.mark.parametrize("path", WEIGHTS, ids=lambda path: path.stem)
def test_shipped_weights_have_a_record_and_a_card(path):
    record = json.loads(path.with_suffix(".json").read_text("utf-8"))
    assert record["licence"].startswith("MIT")
    (row,) = re.findall(rf"^\| \[{path.stem}\]\(\S+\) \|.*$", CARDS, re.MULTILINE)
    assert row.endswith(f"| {record['seed']}, {record['commit'][:7]} |")
    assert record["command"]
    for moves in {record.get("steps"), record.get("examples")} - {None}:
        assert f"{moves:,}" in row


def test_weights_name_the_licences_of_the_maps_that_they_saw():
    for path in WEIGHTS:
        record = json.loads(path.with_suffix(".json").read_text("utf-8"))
        assert ("BSD" in record["licence"]) == ("seen_maps" in record)


@pytest.mark.parametrize("name", ["next-rooms", "next-floors"])
def test_the_final_test_was_flown_once_on_the_maps_that_are_named(name):
    told = plan(ComparisonRequest(experiment=Path(name)))
    seeds = range(told.seed, told.seed + told.episodes)
    flown_once = seed_set("test-8")
    assert {seeds[0], seeds[-1]} <= set(flown_once.seeds)
    assert flown_once.published == 1
    assert f"{seeds[0]:,} to {seeds[-1]:,}" in NEXT_TEST
    for flown in told.scenarios:
        assert f"`{digest_of(flown.map, seeds)}`" in NEXT_TEST


def test_the_test_after_it_has_seeds_that_nothing_was_published_on():
    after = NEXT_TEST.partition("\n## The test after this one\n")[2]
    fresh = fresh_test_set()
    assert f"{fresh.first:,} to {fresh.seeds[-1]:,} (`{fresh.name}`)" in after
    for name in ("next-rooms", "next-floors"):
        assert plan(ComparisonRequest(experiment=Path(name))).seed not in fresh.seeds
