"""The reports of published comparisons, flown when the site is built; what an earlier build flew is kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.leaderboard.board import Origin
from indoor_explorers.evaluation.results.results import Results

EXPERIMENTS = Path(__file__).resolve().parents[1] / "experiments"
#: The experiments whose reports are on the site.
PUBLISHED = ("families",)


@dataclass(frozen=True)
class PublishedReport:
    """A report and where it comes from."""

    name: str
    about: str
    origin: Origin
    report: bytes
    """The HTML page."""

    @property
    def file(self) -> str:
        """Its file on the site."""
        return f"reports/{self.name}.html"


def published(folder: Path, episodes: int | None) -> Iterator[PublishedReport]:
    """Fly the published experiments into ``folder`` where they are not there yet, and yield their reports.

    Args:
        folder: holds a folder for each experiment between two builds.
        episodes: of each policy and scenario; None for as many as are published.

    """
    options: dict[str, Any] = {} if episodes is None else {"episodes": episodes}
    for name in PUBLISHED:
        file = EXPERIMENTS / f"{name}.toml"
        out = folder / name
        compare(out, experiment=file, **options)
        origin = Origin.of(Results.load(out))
        yield PublishedReport(name, _about(file), origin, (out / "report.html").read_bytes())


def _about(file: Path) -> str:
    """Return the comment at the head of an experiment file."""
    lines = file.read_text("utf-8").splitlines()
    head = lines[: next(k for k, line in enumerate(lines) if not line.startswith("#"))]
    return " ".join(line.removeprefix("#").strip() for line in head)


def reports_page(reports: list[PublishedReport]) -> str:
    """Return the page that lists the reports."""
    lines = [
        "# Reports",
        "",
        "Every comparison writes a page like these: a league table, curves, tests, and each episode ",
    ]
    lines += ["to replay. These were flown when the site was built.", ""]
    for each in reports:
        lines += [f"## The experiment {each.name}", "", f"[**Open the report**]({each.name}.html). {each.about}", ""]
        lines += [f"Flown on {', '.join(each.origin.machines)} at {each.origin.flown} with", ""]
        lines += [f"    indoor-explorers compare --experiment {each.name} --out results/{each.name}", ""]
    lines += [
        "## A small one",
        "",
        "[**Open the report**](../example-report.html). Four policies, two scenarios, eight ",
    ]
    lines += ["episodes each.", ""]
    return "\n".join(lines)
