"""Map files behind some weights: written into the record of a training, and told by its policy."""

import json
import shutil
from pathlib import Path

import pytest

from indoor_explorers.env import PRESETS, make_policy
from indoor_explorers.env.provenance import RECORD, recorded_maps
from indoor_explorers.env.scenarios.presets import on_files
from indoor_explorers.env.scenarios.scenario import Scenario
from indoor_explorers.env.scenarios.suites.catalogue import all_suites, digests_of
from indoor_explorers.env.scenarios.suites.suite import Part
from indoor_explorers.learners.dddqn.config import TrainingConfig
from indoor_explorers.learners.sessions.record import new_record, write_record
from indoor_explorers.planners.toolbox.networks.tensors import WEIGHTS
from tests.suites import tiny, tiny_clones

ROOT = Path(__file__).parents[3]
LEARNERS = ROOT / "learners"
#: Where weights ship.
FLOORS = ("env", "planners", "learners")

__all__ = ["tiny", "tiny_clones"]


def written(folder: Path, scenario: Scenario, **settings: object) -> dict[str, list[str]]:
    config = TrainingConfig.model_validate(settings)
    write_record(new_record("dddqn", config, scenario, 1), folder, {})
    return recorded_maps(folder / RECORD)


def test_a_training_on_files_records_their_digests(tiny: Path, tmp_path: Path) -> None:
    scenario = on_files((str(tiny / "floors/a1.npy"), str(tiny / "floors/b.npy")), 1.0)
    plans = [scenario.map.floorplan(index, 0) for index in range(2)]
    digests = [digest for plan in plans for digest in (plan.digest, plan.layout)]
    assert written(tmp_path, scenario) == {"training": digests, "validation": digests}
    office = PRESETS["office"].map.floorplan(0, 0)
    also = [*digests, office.digest, office.layout]
    assert written(tmp_path, scenario, also=("office", "thesis-open")) == {"training": also, "validation": also}


def test_a_training_on_generated_maps_records_none(tmp_path: Path) -> None:
    assert written(tmp_path, PRESETS["thesis-open"]) == {}


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"seen_maps": 3}', '{"seen_maps": {"fun": ["a"]}}'])
def test_without_a_record_of_maps_none_are_told(tmp_path: Path, text: str) -> None:
    (tmp_path / RECORD).write_text(text)
    assert recorded_maps(tmp_path / RECORD) == {}
    assert recorded_maps(tmp_path / "none.json") == {}


def test_policies_tell_the_maps_of_their_trainings(tmp_path: Path) -> None:
    (tmp_path / RECORD).write_text(json.dumps({"seen_maps": {"training": ["floors/train", "0123"]}}))
    for name, weights in (("dddqn", "dddqn/weights/thesis-open"), ("dddqn-thesis", "thesis/weights/rewards-1-stuck-2")):
        shutil.copy(LEARNERS / f"{weights}.safetensors", tmp_path / WEIGHTS)
        policy = make_policy(name, weights=str(tmp_path / WEIGHTS))
        assert policy.seen_maps() == {"training": ["floors/train", "0123"]}


def test_weights_that_ship_saw_no_map_of_a_test_part() -> None:
    seen = [recorded_maps(path) for floor in FLOORS for path in (ROOT / floor).glob("**/weights/*.json")]
    assert len(seen) >= 6
    digests = {digest for each in seen for names in each.values() for name in names for digest in digests_of(name)}
    test_maps = [each for suite in all_suites() for _, each in suite.maps(Part.TEST)]
    tested = {digest for each in test_maps for digest in (each.digest, each.layout)}
    assert tested
    assert not digests & tested
