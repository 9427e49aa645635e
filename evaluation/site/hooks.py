"""Hooks of mkdocs: documents of the other folders become pages, and links between files lead to pages.

Pages and documents link to files of the repository, so that they read as well there. ``gallery.py`` and
``reference.py`` generate pages from the code.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File

from indoor_explorers.evaluation.cli.command import make_console, print_line
from indoor_explorers.evaluation.site.commands import broken
from indoor_explorers.evaluation.site.gallery import example_report, gallery_page, pictures
from indoor_explorers.evaluation.site.pictures.architecture import architecture_pictures
from indoor_explorers.evaluation.site.pictures.atlas import atlas_pictures
from indoor_explorers.evaluation.site.pictures.concepts import concept_pictures
from indoor_explorers.evaluation.site.pictures.dynamics import dynamics_pictures
from indoor_explorers.evaluation.site.pictures.learners import learner_pictures
from indoor_explorers.evaluation.site.pictures.maps import map_pictures
from indoor_explorers.evaluation.site.pictures.planners import planner_pictures
from indoor_explorers.evaluation.site.pictures.radio import radio_pictures
from indoor_explorers.evaluation.site.pictures.sensor_errors import sensor_error_pictures
from indoor_explorers.evaluation.site.pictures.statistics import statistics_pictures
from indoor_explorers.evaluation.site.pictures.tabular import tabular_pictures
from indoor_explorers.evaluation.site.pictures.thesis import thesis_pictures
from indoor_explorers.evaluation.site.pictures.thesis_changes import thesis_changes_pictures
from indoor_explorers.evaluation.site.pictures.which_planner import which_planner_pictures
from indoor_explorers.evaluation.site.published import experiments, published, reports_page, suites
from indoor_explorers.evaluation.site.reference import (
    command_line_page,
    files_page,
    metrics_page,
    python_pages,
    settings_page,
)
from indoor_explorers.evaluation.studies.playground.page import playground

ROOT = Path(__file__).resolve().parents[2]
#: The folder of the pages in the repository.
PAGES = "evaluation/site/pages"
#: The pages that are documents of the repository.
DOCUMENTS = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "evaluation/site/concepts.md": "concepts.md",
    "evaluation/CLUSTER.md": "guides/cluster.md",
    "evaluation/SUITES.md": "reference/suites.md",
    "evaluation/DATASHEETS.md": "reference/datasheets.md",
    "evaluation/STATISTICS.md": "methods/statistics.md",
    "evaluation/NEXT_TEST.md": "methods/next-test.md",
    "evaluation/BOUNDS.md": "methods/bounds.md",
    "planners/PLANNERS.md": "methods/planners.md",
    "learners/DDDQN.md": "methods/dddqn.md",
    "learners/BASELINES.md": "methods/baselines.md",
    "learners/MODEL_CARDS.md": "reference/model-cards.md",
    "learners/THESIS.md": "methods/thesis.md",
    "learners/attention/ATTENTION.md": "methods/attention.md",
    "learners/places/PLACES.md": "methods/places.md",
    "learners/reports/REPORTS.md": "methods/reports.md",
    "learners/pockets/POCKETS.md": "methods/pockets.md",
    "env/maps/FLOORS.md": "methods/floors.md",
}
#: The pages that are generated from the code.
MADE = {
    "gallery.md": gallery_page,
    "reference/command-line.md": command_line_page,
    "reference/settings.md": settings_page,
    "reference/metrics.md": metrics_page,
    "reference/files.md": files_page,
}
#: What draws the pictures of the pages, by name.
DRAWN = (
    pictures,
    architecture_pictures,
    atlas_pictures,
    concept_pictures,
    dynamics_pictures,
    learner_pictures,
    map_pictures,
    planner_pictures,
    radio_pictures,
    sensor_error_pictures,
    statistics_pictures,
    tabular_pictures,
    thesis_pictures,
    thesis_changes_pictures,
    which_planner_pictures,
)
#: Files that are no pages, which the site has a copy of: pictures and short texts.
COPIED = (".svg", ".png", ".gif", ".cff", ".bib", ".ipynb", ".csv", ".json", ".toml", ".py", "LICENSE")
_LINK = re.compile(r"\[([^\[\]]*)\]\((?!https?:|mailto:)([^)#\s]+)(#[^)\s]*)?\)")
_CODE = re.compile(r"(^```.*?^```$|^ {4}[^\n]*$)", re.MULTILINE | re.DOTALL)


def on_files(files: Any, config: Any) -> Any:
    """Add the documents, what they link to, and the pages generated from the code."""
    for source, page in DOCUMENTS.items():
        files.append(File.generated(config, page, content=(ROOT / source).read_text("utf-8")))
    for page, make in MADE.items():
        files.append(File.generated(config, page, content=make()))
    for page, content in python_pages().items():
        files.append(File.generated(config, page, content=content))
    data = config.extra["data"]
    comparisons = [*experiments(config.extra["episodes"]), *(suites(Path(data).expanduser()) if data else ())]
    console = make_console()  # mkdocs prints nothing meanwhile, and flights and pictures take minutes
    reports = list(published(Path(config.site_dir).parent / "published", comparisons, console))
    for report in reports:
        files.append(File.generated(config, report.file, content=report.report))
    files.append(File.generated(config, "reports/index.md", content=reports_page(reports, with_suites=bool(data))))
    files.append(File.generated(config, "example-report.html", content=example_report()))
    files.append(File.generated(config, "playground.html", content=playground()))
    for draw in DRAWN:
        print_line(console, f"drawing {draw.__name__.replace('_', ' ')}")
        for name, picture in draw().items():
            files.append(File.generated(config, f"gallery/{name}", content=picture))
    for page in list(files.documentation_pages()):
        for target in _linked(page.src_uri, page.content_string):
            uri = _uri(target)
            if target.endswith(COPIED) and files.get_file_from_path(uri) is None:
                files.append(File.generated(config, uri, abs_src_path=str(ROOT / target)))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, files: Any) -> str:
    """Let links between files of the repository lead to pages."""
    uri = page.file.src_uri

    def led(match: re.Match[str]) -> str:
        label, target, anchor = match[1], _in_repository(uri, match[2]), match[3] or ""
        if (ROOT / target).is_dir():
            return label
        if files.get_file_from_path(_uri(target)) is None:
            raise PluginError(f"{_source(uri)}: no page or file {target} to link to")
        return f"[{label}]({posixpath.relpath(_uri(target), posixpath.dirname(uri) or '.')}{anchor})"

    parts = _CODE.split(markdown)
    return "".join(broken(part) if k % 2 else _LINK.sub(led, part) for k, part in enumerate(parts))


def _linked(uri: str, text: str) -> list[str]:
    """Return the files of the repository that a page links to."""
    return [_in_repository(uri, match[2]) for part in _CODE.split(text)[::2] for match in _LINK.finditer(part)]


def _in_repository(uri: str, target: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(_source(uri)), target))


def _source(uri: str) -> str:
    """Return the repository file behind a page."""
    return next((source for source, page in DOCUMENTS.items() if page == uri), f"{PAGES}/{uri}")


def _uri(target: str) -> str:
    """Return where the site has a file of the repository."""
    if target.startswith(f"{PAGES}/"):
        return target.removeprefix(f"{PAGES}/")
    return DOCUMENTS.get(target, f"files/{target}")
