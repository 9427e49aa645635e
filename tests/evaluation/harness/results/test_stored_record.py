"""Records whose steps stay in the store: the same facts, and little memory."""

import pickle
import sqlite3
from dataclasses import fields, replace

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.evaluation.harness.episodes.record import Record
from indoor_explorers.evaluation.harness.episodes.steps import Steps
from indoor_explorers.evaluation.harness.results import stored_record
from indoor_explorers.evaluation.harness.results.reading import StoreReader
from tests.evaluation.harness.results.test_store import filled

OF_STEPS = [each.name for each in fields(Steps)]


@pytest.fixture
def flown(tmp_path):
    return filled(tmp_path / "results.db")


@pytest.fixture
def stored(flown, tmp_path):
    with StoreReader(tmp_path / "results.db") as store:
        return store.records()


def test_steps_are_read_when_asked_for_and_few_are_kept(flown, stored, monkeypatch):
    monkeypatch.setattr(stored_record, "KEPT", 0)
    for _ in range(2):
        assert all(record.flew_like(before) for record, before in zip(stored, flown, strict=True))
    assert [record.distance.tolist() for record in stored] == [record.distance.tolist() for record in flown]
    assert [record.facts for record in stored] == [record.facts for record in flown]
    assert not any({*OF_STEPS, "metrics"} & vars(record).keys() for record in stored)


@pytest.mark.parametrize("copied", [lambda r: replace(r, policy="v"), lambda r: pickle.loads(pickle.dumps(r))])
def test_a_copy_is_in_memory(flown, stored, copied):
    copies = [copied(record) for record in stored]
    for copy, before in zip(copies, flown, strict=True):
        assert {*OF_STEPS} <= vars(copy).keys()
        assert isinstance(copy, Record)
        assert copy.flew_like(before)
        assert copy.metrics == before.metrics


@pytest.mark.parametrize("added", [{"count": 3, "none": None}, {"flag": True}, {"huge": 10**30}])
def test_metrics_keep_their_types_and_order(flown, stored, added):
    changed = stored[0].with_metrics(stored[0].metrics | added)
    assert list(changed.metrics.items()) == list((flown[0].metrics | added).items())
    assert [type(value) for value in changed.metrics.values()][-len(added) :] == list(map(type, added.values()))
    assert stored[0].metrics == flown[0].metrics
    assert changed.flew_like(flown[0])


def test_steps_that_changed_after_the_store_was_read_are_refused(stored, tmp_path):
    changes = sqlite3.connect(tmp_path / "results.db")
    with changes:
        changes.execute("UPDATE episode SET sent = (SELECT seconds FROM episode WHERE seed = 6) WHERE seed = 5")
    changes.close()
    with pytest.raises(InputError, match="seed 5: it does not match its checksum"):
        _ = stored[0].cells
    np.testing.assert_array_equal(stored[1].covered[-1], stored[1].covered[stored[1].steps])
