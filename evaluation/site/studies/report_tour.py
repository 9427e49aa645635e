"""Take the picture of the report's tour: the head of the example of a report, with numbers in the order of reading.

    python -P -m indoor_explorers.evaluation.site.studies.report_tour evaluation/site/pages/pictures/report-tour.png

flies the example, as ``make docs`` does, and asks playwright for a Chromium on the PATH. Run it in a clone without
uncommitted changes, of which the report would warn.
"""

from __future__ import annotations

import io
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from PIL import Image

from indoor_explorers.evaluation.site.gallery import example_report

#: What the numbers stand beside: those of the guide's list. The last one stands after a text, the others before theirs.
READ = (".headline", ".glance", ".league tbody", ".caveats", ".league thead a")
#: Pixels of the window.
WIDTH, HEIGHT = 1120, 1000
#: What a Chromium may be called; the Makefile looks for the same.
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
#: Draws a number beside the first element of each selector within the overview.
MARK = """(selectors) => selectors.forEach((selector, k) => {
  const box = document.querySelector(`#overview ${selector}`).getBoundingClientRect();
  const mark = document.createElement("div"), last = k === selectors.length - 1;
  mark.className = "tour-mark";
  mark.textContent = k + 1;
  mark.style = `position: absolute; left: ${last ? box.right + 8 : box.left - 27}px; top: ${box.top}px; width: 21px;
    height: 21px; border-radius: 50%; background: #b3261e; color: #fff; font: bold 13px/21px sans-serif;
    text-align: center; z-index: 9`;
  document.body.append(mark);
})"""


def marked(page: Any) -> bytes:
    """Number what is read first in an open report, and return the PNG file of its overview."""
    page.evaluate(MARK, list(READ))
    bottom = page.evaluate("document.querySelector('#overview').getBoundingClientRect().bottom")
    clip = {"x": 0, "y": 0, "width": WIDTH, "height": bottom}
    return small(page.screenshot(clip=clip))


def small(png: bytes) -> bytes:
    """Return a PNG file with 256 colours."""
    file = io.BytesIO()
    shot = Image.open(io.BytesIO(png)).convert("RGB")
    shot.quantize(256, dither=Image.Dither.NONE).save(file, format="PNG", optimize=True)
    return file.getvalue()


def chromium() -> str | None:
    """Return the path of the first Chromium on the PATH; None without one."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


@contextmanager
def opened(address: str, *options: str) -> Iterator[Any]:
    """Open an address in the first Chromium on the PATH, started with ``options``."""
    from playwright.sync_api import sync_playwright  # for developers alone

    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium(), chromium_sandbox=False, args=options)
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light")
        page.goto(address)
        yield page
        browser.close()


def main(target: Path) -> None:
    """Write the picture."""
    with TemporaryDirectory() as folder:
        report = Path(folder) / "report.html"
        report.write_bytes(example_report())
        with opened(report.as_uri()) as page:
            page.wait_for_selector(".league tfoot svg")
            target.write_bytes(marked(page))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
