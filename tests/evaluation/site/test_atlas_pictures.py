"""The page on where learning pays says what its files hold, and its pictures show the tasks of the suite."""

import re

import pandas as pd
import pytest

from indoor_explorers.env.scenarios.suites.catalogue import suite_of
from indoor_explorers.evaluation.analysis.best_planner import BEST
from indoor_explorers.evaluation.harness.results.ratios import POOLED
from indoor_explorers.evaluation.site.pictures.atlas import HALL, atlas_pictures
from indoor_explorers.evaluation.site.studies.atlas import (
    LEARNED,
    LEARNER,
    PARTS,
    PLANNERS,
    finding_table,
    of_part,
    parts,
    planner_rows,
    pooled_table,
    ratio_of,
    specialist_table,
    take,
)
from tests.documents import SITE

PAGE = (SITE / "pages" / "where-learning-pays.md").read_text("utf-8")


def test_the_page_has_the_tables():
    for table in (finding_table(planner_rows()), specialist_table(planner_rows()), pooled_table()):
        assert "\n".join(table) in PAGE


def test_its_ratios_of_learned_parts_are_those_of_the_file():
    known = {ratio_of(row["scenario"], row["metric"], row["policy"], row["to"]) for row in parts().to_dict("records")}
    said = re.findall(r"\d\.\d{3} \[[\d., ]+\]", " ".join(PAGE.split()))
    assert len(said) > 20
    assert set(said) <= known


def test_every_task_of_the_suite_is_there_with_as_many_maps_as_the_page_says():
    rows = planner_rows()
    assert [row.title for row in rows] == [each.name for each in suite_of("atlas").scenarios()]
    tasks = {each.row.tasks for row in rows for each in row.policies.values()}
    assert f"--suite atlas --episodes {max(tasks)} " in PAGE
    assert len(tasks) == 1


def test_a_report_s_tables_are_cut_to_what_is_needed(tmp_path, monkeypatch):
    every = pd.concat([parts(), parts().assign(policy="another"), parts().assign(to="another", scenario="one")])
    every.to_csv(tmp_path / "ratios.csv", index=False)
    (tmp_path / "best_planner.csv").write_bytes(PLANNERS.read_bytes())
    for name in ("PLANNERS", "PARTS"):
        monkeypatch.setattr(f"indoor_explorers.evaluation.site.studies.atlas.{name}", tmp_path / name)
    take(tmp_path)
    assert len(pd.read_csv(tmp_path / "PARTS")) == len(parts())
    assert (tmp_path / "PLANNERS").read_bytes() == PLANNERS.read_bytes()


def test_the_files_are_small_and_hold_both_parts_and_the_best_planners():
    assert PLANNERS.stat().st_size + PARTS.stat().st_size < 100_000
    pairs = set(zip(parts()["policy"], parts()["to"], strict=True))
    assert {(part.policy, part.without) for part in LEARNED} <= pairs
    assert set(parts()[parts()["scenario"] == POOLED]["policy"]) == {part.policy for part in LEARNED}
    assert LEARNER in {part.policy for part in LEARNED}
    assert PLANNERS.read_text("utf-8").count(BEST) == len(planner_rows())


def test_a_part_has_one_ratio_for_each_time_and_task_and_over_all():
    tasks = {row.best.row.scenario for row in planner_rows()} | {POOLED}
    for part in LEARNED:
        table = of_part(part)
        found = list(zip(table["scenario"], table["metric"], strict=True))
        assert sorted(found) == sorted((task, time) for task in tasks for time in ("t90", "t99"))


@pytest.mark.slow
def test_the_pictures_show_the_tasks_and_are_the_same_each_time():
    drawn = atlas_pictures()
    assert set(re.findall(r"gallery/(atlas-[a-z.]+)", PAGE)) == set(drawn)
    assert drawn["atlas-parts.svg"] == atlas_pictures()["atlas-parts.svg"]
    assert f"--policy {','.join(HALL.policies)} --scenario {HALL.scenario} --team 1 --seed {HALL.seed}" in PAGE
    assert all(len(picture) > 10_000 for picture in drawn.values())
