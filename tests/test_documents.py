"""What the documents show works as it stands there, and the site can be built of them."""

import ast
import importlib
import os
import re
import shlex
import subprocess
import sys

import pytest

from indoor_explorers.env import PRESETS, policy_names
from indoor_explorers.evaluation.cli.commands import COMMANDS
from indoor_explorers.evaluation.cli.parser import build_parser, joined_words
from indoor_explorers.evaluation.exports.episodes.csv_tables import COLUMNS
from indoor_explorers.evaluation.site.reference import command_line_page, files_page, public_modules, python_pages
from tests.documents import BOUNDS, ON_EVIDENCE, PAGES, PLANNERS, ROOT, SITE, printed_of, python_of

DOCUMENTS = (*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "evaluation" / "CLUSTER.md")
#: What needs Ray is run in tests/env/interfaces/test_rllib.py, where Ray is started once and with little.
SNIPPETS = {
    f"{path.stem}-{number}": text
    for path in PAGES
    for number, text in enumerate(python_of(path))
    if "from ray" not in text
}
PRINTED = {f"{path.stem}-{number}": text for path in PAGES for number, text in enumerate(printed_of(path))}
#: A script that trains for long; test_tabular_pictures.py trains with its functions, and compares what the page says.
LONG = ("tabular-0",)
#: Spares a comparison the figures for print, which would take most of its time.
NO_FIGURES = "from indoor_explorers.evaluation import exports; exports.write_figures = lambda *_: []\n"
COMPARISONS = [name for name, text in SNIPPETS.items() if "compare(" in text]


@pytest.mark.filterwarnings("default")
@pytest.mark.usefixtures("one_thread")
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in SNIPPETS if name not in COMPARISONS],
)
def test_a_snippet_runs_and_prints_what_the_page_says(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(SNIPPETS[name], name, "exec"), {"__name__": "__main__"})
    assert PRINTED[name] in (None, capsys.readouterr().out)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name != COMPARISONS[0])) for name in COMPARISONS]
)
def test_a_comparison_runs_as_a_script_without_a_main_guard(name, tmp_path):
    script = SNIPPETS[name].replace("episodes=10", "episodes=2, workers=1")
    (tmp_path / "snippet.py").write_text(NO_FIGURES + script)
    done = subprocess.run([sys.executable, "snippet.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr


def test_every_policy_and_scenario_is_in_its_table():
    families = {
        r"rewards-[123]-stuck-[012]": "rewards-R-stuck-S",
        r"team-[24]-radio-([013]|unlimited)": "team-N-radio-X",
    }
    policies, scenarios = ((SITE / "pages" / name).read_text() for name in ("policies.md", "scenarios.md"))
    for name in policy_names():
        assert f"| `{name}` |" in policies
    for name in (name for name in PRESETS if name != "thesis-team-4"):
        for numbers, letters in families.items():
            name = re.sub(numbers, letters, name)
        assert f"`{name}`" in scenarios


@pytest.mark.parametrize("path", [*PAGES, PLANNERS, BOUNDS], ids=lambda path: path.stem)
def test_every_command_line_is_understood(path):
    assert not re.search(r"^ {0,3}indoor-explorers ", path.read_text(), re.MULTILINE)  # would be no code
    for line in re.findall(r"^    indoor-explorers (.*)$", path.read_text(), re.MULTILINE):
        build_parser().parse_args(joined_words(shlex.split(line)))


def test_the_references_know_every_command_and_what_it_exports():
    assert all(f"\n## {command.name}\n" in command_line_page() for command in COMMANDS)
    assert all(f"`{column}`" in files_page() for column in COLUMNS)


def test_the_python_reference_has_a_page_for_each_module_and_lists_the_members_of_enumerations():
    pages, nav = python_pages(), (SITE / "mkdocs.yml").read_text()
    assert len(pages) == 1 + len(public_modules())
    assert all(f": {page}\n" in nav for page in pages)
    shown = re.findall(
        r"^::: \S+\.(\w+)\n {4}options:\n {6}show_if_no_docstring", pages["reference/python/env.md"], re.MULTILINE
    )
    assert shown == ["Action", "End"]
    blocks = re.findall(r"^::: (\S+)$", "\n".join(pages.values()), re.MULTILINE)
    assert len(blocks) == len(set(blocks))
    assert "See [parallel_env][" in pages["reference/python/interfaces.md"]


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_bytes()) <= 8000


def test_documents_import_public_names_alone():
    public = public_modules()
    for path in DOCUMENTS:
        for block in python_of(path):
            for node in ast.walk(ast.parse(block)):
                if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("indoor_explorers"):
                    assert node.module in public, (path, node.module)
                    names = importlib.import_module(node.module).__all__
                    assert {alias.name for alias in node.names} <= set(names), (path, node.module)


@pytest.mark.parametrize("path", [*DOCUMENTS, PLANNERS, BOUNDS, *ON_EVIDENCE], ids=lambda path: path.stem)
def test_links_lead_somewhere(path):
    for target, anchor in re.findall(r"\]\((?!http)([^)#]*)#?([^)]*)\)", path.read_text()):
        if "gallery/" in target:  # drawn when the site is built
            continue
        found = path.parent / target if target else path
        assert found.exists(), target
        headings = re.findall(r"^#+ (.+)$", found.read_text(), re.MULTILINE) if anchor else [""]
        assert anchor in map(anchor_of, headings), (target, anchor)


def test_anchors_are_without_punctuation():
    headings = ("What if, at 99 %, `dddqn` fails?", "Where it flies: a well-known (large) map")
    assert list(map(anchor_of, headings)) == ["what-if-at-99--dddqn-fails", "where-it-flies-a-well-known-large-map"]


def anchor_of(heading):
    """What GitHub calls a heading in addresses; the site does, too, where no two spaces meet."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


@pytest.mark.slow
def test_the_site_is_built_and_fetches_nothing(tmp_path):
    words = ["-m", "mkdocs", "build", "--quiet", "--config-file", SITE / "mkdocs.yml", "--site-dir", tmp_path / "site"]
    few = {**os.environ, "INDOOR_EXPLORERS_SITE_EPISODES": "1"}
    whole = 1500  # seconds: some five minutes of work beside other tests, so only a hang ends it
    done = subprocess.run(
        [sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, timeout=whole, env=few
    )
    assert done.returncode == 0, done.stderr
    pages = {str(path.relative_to(tmp_path / "site")): path.read_text() for path in (tmp_path / "site").rglob("*.html")}
    made = {
        "index.html",
        "methods/planners.html",
        "methods/bounds.html",
        "reference/python.html",
        "reference/python/env.html",
    }
    assert made | {"reference/settings.html", "reports/index.html", "reports/families.html"} <= pages.keys()
    for name, text in pages.items():
        assert not re.search(r"<(script|img|link)[^>]* (src|href)=\"https?://", text), name
    for name in policy_names():
        assert (tmp_path / "site" / "gallery" / f"policy-{name}.png").stat().st_size > 1000
    assert "lidar.range" in pages["reference/settings.html"]
    assert "--ratio-to" in pages["reference/command-line.html"]


def test_the_script_of_the_lower_bounds_prints_a_line_for_each_scenario(capsys):
    (script,) = python_of(BOUNDS)
    script = changed(
        script, "thesis-open thesis-obstacles thesis-team-2 thesis-team-4 office", "thesis-open thesis-team-2"
    )
    script = changed(changed(script, " offices rooms cave floors maze", ""), "1_000_030", "1_000_002")
    exec(compile(script, "bounds", "exec"), {"__name__": "__main__"})
    assert re.fullmatch(r"(thesis-\S+ \[[\d.]+, [\d.]+\]\n){2}", capsys.readouterr().out)


@pytest.mark.slow  # guarded by the imports above
def test_the_scripts_behind_the_costs_of_a_cluster_run(tmp_path):
    costs, driver = python_of(ROOT / "evaluation" / "CLUSTER.md")
    costs = changed(costs, '("thesis-obstacles", 40), ("office", 10)', '("thesis-open", 2),')
    driver = changed(driver, '("thesis-obstacles", 2000), ("office", 60)', '("thesis-open", 2),')
    scripts = {"costs": changed(costs, "in POLICIES", "in POLICIES[:2]"), "driver": changed(driver, '"ray"', '"local"')}
    for (name, script), lines in zip(scripts.items(), (2, 1), strict=True):
        (tmp_path / f"{name}.py").write_text(script)
        done = subprocess.run([sys.executable, f"{name}.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
        assert (done.returncode, len(done.stdout.splitlines())) == (0, lines), done.stderr


def changed(script, old, new):
    assert old in script
    return script.replace(old, new)
