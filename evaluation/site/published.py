"""The reports of published comparisons, flown when the site is built; what an earlier build flew is kept."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from indoor_explorers.env.scenarios.suites.catalogue import suite_of
from indoor_explorers.evaluation import compare
from indoor_explorers.evaluation.cli.command import print_line
from indoor_explorers.evaluation.cli.console import PlainConsole
from indoor_explorers.evaluation.cli.progress import ProgressBar
from indoor_explorers.evaluation.harness.results.results import Results
from indoor_explorers.evaluation.report import write_report
from indoor_explorers.evaluation.studies.leaderboard.board import Origin

EXPERIMENTS = Path(__file__).resolve().parents[1] / "experiments"
#: The experiments whose reports are on the site.
PUBLISHED = ("families",)
#: The tasks of suites whose reports are on the site where their maps are at hand: suite, team and radio.
SUITES = (
    ("floors", 1, None),
    ("floors", 4, "disc"),
    ("floors", 4, "unlimited"),
    ("dungeons", 1, None),
    ("dungeons", 4, "disc"),
)
SUITE_POLICIES = (
    "frontier-nearest",
    "frontier",
    "frontier-latency",
    "frontier-predictive",
    "rrt",
    "pso",
    "dddqn",
    "reference",
)


@dataclass(frozen=True)
class PublishedComparison:
    """A comparison whose report is on the site."""

    name: str
    heading: str
    about: str
    options: Mapping[str, Any]
    """The options of ``compare``."""
    replays: int | None = None
    """Episodes of each scenario to replay; None for as many as the report chooses."""

    @property
    def command(self) -> str:
        """The command that flies it; folders are named DIR."""
        words = ["indoor-explorers compare"]
        for name, value in (dict(self.options) | {"out": Path()}).items():
            written = "DIR" if isinstance(value, Path) else ",".join(value) if isinstance(value, tuple) else value
            words.append(f"--{name.replace('_', '-')} {written}")
        return " ".join(words)


@dataclass(frozen=True)
class PublishedReport:
    """The report of a comparison and where its episodes come from."""

    comparison: PublishedComparison
    origin: Origin
    report: bytes
    """The HTML page."""

    @property
    def file(self) -> str:
        """Its file on the site."""
        return f"reports/{self.comparison.name}.html"


def experiments(episodes: int | None = None) -> Iterator[PublishedComparison]:
    """Yield the published experiments, with as many episodes as are published unless ``episodes`` is given."""
    fewer = {} if episodes is None else {"episodes": episodes}
    for name in PUBLISHED:
        about = _about(EXPERIMENTS / f"{name}.toml")
        yield PublishedComparison(name, f"The experiment {name}", about, {"experiment": name} | fewer)


def suites(data: Path) -> Iterator[PublishedComparison]:
    """Yield the published comparisons on test parts of suites, whose maps are in the folder ``data``."""
    for suite, team, radio in SUITES:
        name = f"{suite}-{team}" if radio is None else f"{suite}-{team}-{radio}"
        heading = f"The suite {suite}, " + ("one UAV" if radio is None else f"{team} UAVs, radio {radio}")
        about = suite_of(suite).about
        about = f"{about[0].upper()}{about[1:]}. There are no replays, since the maps belong to others."
        options = {"suite": suite, "part": "test", "team": team} | ({} if radio is None else {"radio": radio})
        options |= {"policies": SUITE_POLICIES, "data": data, "ratio_to": ("frontier-nearest", "frontier-predictive")}
        yield PublishedComparison(name, heading, about, options, replays=0)


def published(
    folder: Path, comparisons: Iterable[PublishedComparison], console: PlainConsole | None = None
) -> Iterator[PublishedReport]:
    """Fly comparisons into ``folder`` where they are not there yet, and yield their reports.

    Args:
        folder: holds a folder for each comparison between two builds.
        comparisons: what to fly.
        console: shows the progress; None for none.

    """
    for each in comparisons:
        out = folder / each.name
        if console is None:
            compare(out, command=each.command, **each.options)
        else:
            print_line(console, each.command)
            with ProgressBar(console, {}) as bar:
                compare(out, watcher=bar, command=each.command, **each.options)
        results, page = Results.load(out), out / "report.html"
        if each.replays is not None or page.with_name("report_files").is_dir():
            write_report(results, page, replays=each.replays, ratio_to=each.options.get("ratio_to"), whole=True)
        yield PublishedReport(each, Origin.of(results), page.read_bytes())


def _about(file: Path) -> str:
    """Return the comment at the head of an experiment file."""
    lines = file.read_text("utf-8").splitlines()
    head = lines[: next(k for k, line in enumerate(lines) if not line.startswith("#"))]
    return " ".join(line.removeprefix("#").strip() for line in head)


def reports_page(reports: list[PublishedReport], *, with_suites: bool) -> str:
    """Return the page that lists the reports, and the way to fly the suites where they are missing."""
    lines = [
        "# Reports",
        "",
        "Every comparison writes a page like these, with a league table, curves, tests, and episodes to replay. These "
        "were flown when the site was built.",
        "",
    ]
    for each in reports:
        it = each.comparison
        lines += [f"## {it.heading}", "", f"[**Open the report**]({it.name}.html). {it.about}", ""]
        lines += [f"Flown on {', '.join(each.origin.machines)} at {each.origin.flown} with", ""]
        lines += [f"    {it.command}", ""]
    if not with_suites:
        lines += [
            "## The suites",
            "",
            "The maps of the suites `floors` and `dungeons` belong to others. With clones of them in a folder, `make "
            "docs DATA=FOLDER` flies the test parts and lists their reports here; [the "
            "leaderboards](../leaderboard.md) have their tables.",
            "",
        ]
    lines += [
        "## A small one",
        "",
        "[**Open the report**](../example-report.html). Four policies, two scenarios, eight episodes each.",
        "",
    ]
    return "\n".join(lines)
