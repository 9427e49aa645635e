"""The gallery's page; its pictures are flown when the site is built."""

import re
from pathlib import Path

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from indoor_explorers.evaluation.site import gallery

PAGE = (Path(gallery.__file__).parent / "pages" / "harder-tasks.md").read_text("utf-8")


def test_harder_tasks_are_pictured_by_a_policy_of_their_own(monkeypatch):
    monkeypatch.setattr(gallery, "pictures", dict)
    page = gallery.gallery_page()
    for name, task in gallery.HARDER.items():
        assert f"gallery/harder-{name}.png" in page
        assert f"[![harder-{name}](gallery/harder-{name}.png)](gallery/harder-{name}.png)" in page
        assert re.search(rf"`{task.policy}` on `{task.scenario}`", page)
        request = ComparisonRequest(policies=[task.policy], scenario=[task.scenario], settings=task.settings)
        (scenario,) = plan(request).scenarios
        assert scenario.failures.any or scenario.base.exists or scenario.prior.kind == "outdated" or scenario.uncertain
    assert set(re.findall(r"gallery/harder-([\w-]+).png", PAGE)) <= set(gallery.HARDER)
    assert not any(PRESETS[name].base.exists or PRESETS[name].uncertain for name in gallery.scenarios())
