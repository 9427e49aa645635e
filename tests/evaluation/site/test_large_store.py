"""A store that was enlarged for measuring is read as one that was flown."""

from indoor_explorers.evaluation import Results, compare
from indoor_explorers.evaluation.site.studies.large_store import enlarge


def test_each_episode_is_there_under_other_seeds(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    compare("few", policies=["random"], scenario="thesis-open", episodes=2, seed=5, workers=0)
    enlarge(tmp_path / "few", tmp_path / "many", 3)
    few, many = (Results.load(tmp_path / name) for name in ("few", "many"))
    assert [record.task.seed for record in many.records] == [5, 6, 7, 8, 9, 10]
    assert [record.metrics for record in many.records] == 3 * [record.metrics for record in few.records]
