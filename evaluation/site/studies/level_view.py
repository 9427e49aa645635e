r"""Take the picture of the replay in three dimensions: two planners in a tall hall, at one step.

    indoor-explorers compare --policies frontier-nearest,frontier-latency --scenario tall-halls --team 2 \
        --episodes 1 --out results/tall
    python -P -m indoor_explorers.evaluation.site.studies.level_view results/tall levels.png

playwright is asked for a Chromium on the PATH, which draws without a graphics card.
"""

from __future__ import annotations

import sys
from pathlib import Path

from indoor_explorers.evaluation.site.studies.report_tour import opened, small

#: The step that is shown.
STEP = 70
#: Starts WebGL 2 without a graphics card.
OPTIONS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def main(results: Path, target: Path) -> None:
    """Write the picture of the report in a folder of results."""
    with opened(f"{(results / 'report.html').resolve().as_uri()}#replay=s1;step={STEP}", *OPTIONS) as page:
        replay = page.locator("#replay-s1")
        replay.get_by_role("button", name="3D").click()
        canvases = replay.locator("canvas.space")
        canvases.first.scroll_into_view_if_needed()
        page.wait_for_timeout(2000)  # the building is drawn after the page is ready
        boxes = [canvases.nth(k).bounding_box() for k in range(canvases.count())]
        left, top = (min(box[side] for box in boxes) for side in ("x", "y"))
        right, bottom = (max(box[a] + box[b] for box in boxes) for a, b in (("x", "width"), ("y", "height")))
        clip = {"x": left, "y": top - 40, "width": right - left, "height": bottom - top + 40}
        target.write_bytes(small(page.screenshot(clip=clip)))


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
