"""The picture of the choice of a planner names policies that there are, as its page does, and is the same each time."""

import re

from indoor_explorers.env import policy_names
from indoor_explorers.evaluation.site.pictures.which_planner import OTHERWISE, STEPS, which_planner_pictures
from tests.documents import SITE

PAGE = (SITE / "pages" / "guides" / "which-planner.md").read_text("utf-8")
NAMED = [*(name for step in STEPS for name in step.policies), OTHERWISE]


def test_the_picture_names_policies_that_there_are():
    assert set(NAMED) <= set(policy_names())


def test_the_page_tells_the_picture_in_words_and_gives_each_policy_a_row():
    ((told, file),) = re.findall(r"!\[(.*?)\]\(\.\./gallery/(.*?)\)", PAGE)
    assert sorted(re.findall("|".join(sorted(set(NAMED), key=len, reverse=True)), told)) == sorted(NAMED)
    assert file in which_planner_pictures()
    rows = re.findall(r"^\|[^|]+\|([^|]+)\|", PAGE, re.MULTILINE)
    assert all(any(f"`{name}`" in policies for policies in rows) for name in NAMED)


def test_every_policy_on_the_page_exists():
    columns = re.findall(r"^\|[^|]+\|([^|]+)\|", PAGE, re.MULTILINE)
    assert {name for column in columns for name in re.findall(r"`([^`]+)`", column)} <= set(policy_names())


def test_the_picture_is_transparent_and_the_same_each_time():
    (first,), (second,) = which_planner_pictures().values(), which_planner_pictures().values()
    assert first == second
    assert b"fill: #ffffff" not in first
    assert len(first) < 150_000
