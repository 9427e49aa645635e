"""The documentation's search in a real browser that has opened a page from disk."""

import subprocess
import sys

import pytest
import yaml

from tests.documents import SITE

from .conftest import opened

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("browser")]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Two pages with the theme, the search and the worker of the documentation; the address of the first."""
    folder = tmp_path_factory.mktemp("search")
    settings = yaml.load((SITE / "mkdocs.yml").read_text("utf-8"), yaml.BaseLoader)
    kept = {name: settings[name] for name in ("site_name", "use_directory_urls", "theme")}
    kept |= {"extra": {"polyfills": settings["extra"]["polyfills"]}, "plugins": ["search", "offline"]}
    kept["use_directory_urls"] = False
    kept["theme"]["font"] = False
    assert {"search", "offline"} <= {name for name in settings["plugins"] if isinstance(name, str)}
    pages = folder / "docs"
    pages.mkdir()
    (folder / "mkdocs.yml").write_text(yaml.safe_dump(kept), "utf-8")
    (pages / "index.md").write_text("# Start\n\nNothing here.\n", "utf-8")
    (pages / "lidar.md").write_text("# Sensors\n\n## The lidar\n\nA zebra is seen.\n", "utf-8")
    for name in settings["extra"]["polyfills"]:
        (pages / name).write_text((SITE / "pages" / name).read_text("utf-8"), "utf-8")
    words = [sys.executable, "-P", "-m", "mkdocs", "build", "--quiet", "--config-file", folder / "mkdocs.yml"]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return (folder / "site" / "index.html").as_uri()


def test_a_word_is_found_from_disk_and_nothing_is_fetched(browser, site):
    with opened(browser, site) as visit:
        page = visit.page
        page.locator(".md-search__input").click()
        page.keyboard.type("zebra")
        found = page.locator(".md-search-result__item a").first
        found.wait_for(state="attached")
        assert "lidar.html" in found.get_attribute("href")
        page.keyboard.type("giraffe")
        page.get_by_text("No matching documents").wait_for(state="attached")  # of "zebragiraffe"
    assert visit.complaints == []
    assert all(url.startswith(("file:", "data:", "blob:")) for url in visit.asked)
