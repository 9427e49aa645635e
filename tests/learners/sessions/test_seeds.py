"""Seeds of trainings: apart from everything that is compared, and known from the records."""

import json

import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.scenarios.seed_sets import SEED_SETS, SeedUse, use_of
from indoor_explorers.learners.dddqn.presets import PRESETS
from indoor_explorers.learners.sessions.seeds import (
    MOST_SEEDS,
    evaluation_seeds,
    prior_seeds,
    recorded_seeds,
    training_seeds,
)

#: More episodes than any training flies.
MANY = 2**36


@pytest.mark.parametrize("seed", [*range(4), *{preset.seed for preset in PRESETS.values()}, MOST_SEEDS - 1])
def test_no_training_or_validation_flies_a_seed_of_a_set(seed):
    training, prior = (range(first, first + MANY) for first in (training_seeds(seed), prior_seeds(seed)))
    validation = range(evaluation_seeds(seed), evaluation_seeds(seed) + MANY)
    assert [use_of(seeds) for seeds in (training, prior, validation)] == [
        SeedUse.TRAINING,
        SeedUse.TRAINING,
        SeedUse.VALIDATION,
    ]
    for flown in (training, prior, validation):
        assert not any(flown.start < each.seeds.stop and each.first < flown.stop for each in SEED_SETS)


@pytest.mark.parametrize("seed", [-1, MOST_SEEDS])
def test_a_seed_without_a_block_is_refused(seed):
    with pytest.raises(InputError, match=f"expected a seed from 0 to 1048575, got {seed}"):
        training_seeds(seed)


def test_a_record_tells_the_seeds_of_training_validation_and_choice(tmp_path):
    record = {"seed": 3, "config": {"evaluation_episodes": 20}, "compared_on": [[5, 9]]}
    (tmp_path / "training.json").write_text(json.dumps(record))
    found = recorded_seeds(tmp_path / "training.json")
    assert use_of(found[SeedUse.TRAINING][0]) is SeedUse.TRAINING
    assert training_seeds(3) in found[SeedUse.TRAINING][0]
    assert prior_seeds(3) in found[SeedUse.TRAINING][0]
    assert found[SeedUse.VALIDATION] == [range(evaluation_seeds(3), evaluation_seeds(3) + 20)]
    assert found[SeedUse.TUNING] == [range(5, 10)]


@pytest.mark.parametrize("text", ["", "[]", '{"seed": 3}', '{"seed": "x", "config": {}}'])
def test_weights_without_a_record_tell_none(tmp_path, text):
    (tmp_path / "training.json").write_text(text)
    assert recorded_seeds(tmp_path / "training.json") == {}
    assert recorded_seeds(tmp_path / "none.json") == {}
