"""The distribution holds what the tree holds, and works when it is installed from a wheel."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

ROOT = Path(__file__).resolve().parent.parent
FLOORS = ("env", "planners", "learners", "evaluation")
#: What wheels do not hold: figures of documents, what the site is made of, and what is said of the project elsewhere.
OUTSIDE = (ROOT / "learners" / "figures", ROOT / "evaluation" / "site", ROOT / "evaluation" / "paper")
DOCUMENTATION = tuple(f"indoor_explorers/{folder.relative_to(ROOT).as_posix()}/" for folder in OUTSIDE)
SITE = OUTSIDE[1]


def tracked():
    """The files of the packages that git holds."""
    listed = subprocess.run(["git", "ls-files", *FLOORS], cwd=ROOT, capture_output=True, text=True, check=True)
    paths = {ROOT / name for name in listed.stdout.splitlines()}
    return {path for path in paths if not set(OUTSIDE) & set(path.parents)}


@pytest.fixture(scope="module")
def project():
    return tomllib.loads((ROOT / "pyproject.toml").read_text())


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """A wheel built from a copy of the tree, so that no earlier build can lend it a file."""
    out = tmp_path_factory.mktemp("wheel")
    made = shutil.ignore_patterns("*.egg-info", "__pycache__", ".*_cache")

    def ignored(folder, names):
        made_here = {".git", ".venv", "build", "dist", "results"} if Path(folder) == ROOT else set()
        return made(folder, names) | made_here

    source = shutil.copytree(ROOT, out / "source", ignore=ignored, symlinks=True)
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", out, source],
        check=True,
        capture_output=True,
        text=True,
    )
    (found,) = out.glob("*.whl")
    return found


def test_every_module_has_a_package():
    for floor in FLOORS:
        for path in (ROOT / floor).rglob("*.py"):
            assert SITE in path.parents or (path.parent / "__init__.py").exists(), path


def test_data_files_of_every_kind_are_part_of_the_package(project):
    (patterns,) = project["tool"]["setuptools"]["package-data"].values()
    strange = {path for path in tracked() if not any(path.match(pattern) for pattern in ("*.py", "*.md", *patterns))}
    assert strange == set()


def test_an_editable_install_is_a_folder_on_the_path():
    """Editors follow a path, and no import hook."""
    assert str(ROOT / ".src") in sys.path
    assert not [finder for finder in sys.meta_path if "editable" in repr(finder).lower()]


def test_one_version_everywhere(project):
    version = project["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert re.search(r"^## (\d\S*)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[1] == version


@pytest.mark.slow
def test_the_wheel_holds_every_module_and_data_file(wheel):
    held = set(zipfile.ZipFile(wheel).namelist())
    missing = {path for path in tracked() if f"indoor_explorers/{path.relative_to(ROOT).as_posix()}" not in held}
    assert {path for path in missing if path.suffix != ".md"} == set()
    assert not [name for name in held if name.startswith(DOCUMENTATION)]
    tops = {name.split("/")[0] for name in held}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"indoor_explorers"}


@pytest.mark.slow
def test_the_wheel_works_where_the_source_is_not(wheel, tmp_path):
    """Unpacked beside nothing, it imports itself, finds its data, and flies."""
    zipfile.ZipFile(wheel).extractall(tmp_path / "site")
    code = """
import sys
sys.path = [p for p in sys.path if "indoor" not in p]
sys.meta_path = [f for f in sys.meta_path if "editable" not in getattr(f, "__module__", "") + repr(f).lower()]
sys.path.insert(0, "site")
import indoor_explorers.env, indoor_explorers.evaluation
assert indoor_explorers.env.__file__.startswith(sys.argv[1]), indoor_explorers.env.__file__
from indoor_explorers.evaluation import compare
table = compare("out", policies=["random"], scenario=["office", "thesis-open"], episodes=1, workers=0,
                settings={"budget": 20})
assert set(table.scenario) == {"office", "thesis-open"}
"""
    done = subprocess.run(
        [sys.executable, "-P", "-c", code, str(tmp_path)], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000


def test_no_floor_imports_what_lies_above_it():
    """Learners and the harness import of planners the toolbox alone."""
    allowed = {
        "env": ("env",),
        "planners/toolbox": ("env", "planners.toolbox"),
        "planners": ("env", "planners"),
        "learners": ("env", "planners.toolbox", "learners"),
        "evaluation": ("env", "planners.toolbox", "evaluation"),
    }
    for floor, below in allowed.items():
        for path in set((ROOT / floor).rglob("*.py")) - set(SITE.rglob("*.py")):  # the site shows what is inside
            found = re.findall(r"^\s*(?:from|import) indoor_explorers\.([\w.]+)", path.read_text(), re.MULTILINE)
            reached = [name for name in found if not f"{name}.".startswith(tuple(f"{each}." for each in below))]
            assert not reached, (path, reached)


def test_importing_the_command_line_loads_neither_torch_nor_ompl():
    code = "import sys, indoor_explorers.evaluation.cli.parser; print(sorted({'torch', 'ompl'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


LAZY = {
    "env": {"numba", "scipy", "pydantic", "pettingzoo"},
    "env.interfaces": {"numba", "scipy", "pettingzoo", "stable_baselines3"},
    "evaluation": {"numba", "scipy", "pandas", "matplotlib", "plotly", "pyarrow", "rich"},
}


@pytest.mark.parametrize("package", LAZY)
def test_public_names_are_imported_when_they_are_asked_for(package):
    code = f"""
import sys
import indoor_explorers.{package} as package
assert not {LAZY[package]!r} & set(sys.modules)
assert all(hasattr(package, name) for name in package.__all__)
lazy = [name for names in package._MODULES.values() for name in names]
assert sorted(package.__all__) == sorted({{*lazy, *(name for name in package.__all__ if name == "compare")}})
assert "numba" in sys.modules
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_flying_a_shipped_network_needs_no_torch():
    policies = ", ".join(f"indoor_explorers.learners.{learner}.policy" for learner in ("dddqn", "thesis"))
    code = f"import sys, {policies}; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_constraints_pin_everything_and_name_no_host(project):
    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if line and not line.startswith("#")]
    assert "torch==2.13.0" in lines
    assert all(re.fullmatch(r"[A-Za-z0-9._-]+==[A-Za-z0-9.]+", line) for line in lines)
    pinned = {line.split("==")[0].lower().replace("_", "-") for line in lines}
    extras = project["project"]["optional-dependencies"].values()
    wanted = {
        re.match(r"[A-Za-z0-9._-]+", need)[0].lower()
        for needs in (project["project"]["dependencies"], *extras)
        for need in needs
    }
    assert wanted - {"indoor-explorers"} <= pinned


#: The systems of the documents, in uv's words, with whether OMPL has wheels there.
SYSTEMS = {"x86_64-unknown-linux-gnu": True, "aarch64-unknown-linux-gnu": True, "macos": True, "windows": False}


@pytest.fixture(scope="module")
def uv(tmp_path_factory):
    """Run uv in an empty folder, for macOS 15; a test is skipped where the index cannot be reached."""
    folder = tmp_path_factory.mktemp("uv")

    def run(*words, **variables):
        fixed = {"UV_NO_CONFIG": "1", "UV_PYTHON_DOWNLOADS": "never", "MACOSX_DEPLOYMENT_TARGET": "15.0"}
        environment = {**os.environ, **fixed, **variables}
        command = [sys.executable, "-m", "uv", *map(str, words)]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment, check=False)
        if done.returncode and any(
            sign in done.stderr for sign in ("Failed to fetch", "dns error", "Network connectivity is disabled")
        ):
            pytest.skip("the package index cannot be reached")
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run


@pytest.mark.slow
@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13", "3.14"])
@pytest.mark.parametrize("system", SYSTEMS)
def test_every_dependency_has_wheels(uv, system, python):
    """For each system and Python of the documents; OMPL is left out where it has none."""
    asked = uv(
        *("pip", "compile", "--only-binary", ":all:", "--no-header", "--no-annotate", ROOT / "pyproject.toml"),
        *("--python-platform", system, "--python-version", python),
    )
    found = {line.partition("==")[0] for line in asked.splitlines()}
    assert {"numba", "gymnasium", "matplotlib"} <= found
    assert ("ompl" in found) == (SYSTEMS[system] and python != "3.14")


@pytest.mark.slow
def test_the_wheel_is_installed_as_a_tool(uv, wheel, tmp_path):
    """With the versions that constraints.txt pins, in an environment of its own."""
    folders = {"UV_TOOL_DIR": str(tmp_path / "tools"), "UV_TOOL_BIN_DIR": str(tmp_path / "bin")}
    uv("tool", "install", "--python", sys.executable, "--constraints", ROOT / "constraints.txt", wheel, **folders)
    command = tmp_path / "bin" / "indoor-explorers"
    done = subprocess.run([command, "policies"], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "frontier-nearest" in done.stdout


def test_a_missing_ompl_is_told_by_the_policies_that_need_it_alone():
    code = """
import sys
sys.modules["ompl"] = None
from indoor_explorers.env.policies.registry import policy_class, policy_names
for name in policy_names():
    try:
        policy_class(name)
    except ValueError as error:
        print(name, "OMPL has wheels for" in str(error))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    sampling = ("prm-tour", "rrt", "rrt-aep", "rrt-frontier", "rrt-nbv", "rrt-predictive")
    assert done.stdout.splitlines() == [f"{name} True" for name in sampling]


def test_the_image_runs_the_comparison_as_an_ordinary_user(project):
    """The Dockerfile is read, not built."""
    steps = re.sub(r"\\\n\s*", "", (ROOT / "Dockerfile").read_text())
    words = [line.split(maxsplit=1) for line in steps.splitlines() if line and not line.startswith("#")]
    version = re.fullmatch(r"python:(\d+\.\d+)-slim", words[0][1])[1]
    assert words[0][0] == "FROM"
    assert SpecifierSet(project["project"]["requires-python"]).contains(version)
    assert [rest for word, rest in words if word == "USER"] == ["explorer"]
    assert words[-1] == ["CMD", '["make", "compare"]']
    made = next(rest for word, rest in words if word == "RUN" and rest.startswith("make ")).split()[1]
    assert subprocess.run(["make", "-n", made], cwd=ROOT, capture_output=True, check=True)
    container = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text())
    assert (ROOT / ".devcontainer" / container["build"]["dockerfile"]).resolve() == ROOT / "Dockerfile"
    assert subprocess.run(["make", "-n", container["postCreateCommand"].split()[1]], cwd=ROOT, check=True)


def test_the_conda_recipe_needs_what_the_package_needs(project):
    recipe = yaml.safe_load((ROOT / ".conda" / "recipe.yaml").read_text())
    told = {Requirement(each) for each in recipe["requirements"]["run"]}
    wanted = {Requirement(each) for each in project["project"]["dependencies"]}
    names = {"matplotlib": "matplotlib-base"}
    assert {(each.name, str(each.specifier)) for each in told} == {
        ("python", project["project"]["requires-python"]),
        *((names.get(each.name, each.name), str(each.specifier)) for each in wanted),
    }
    assert recipe["package"] == {"name": project["project"]["name"], "version": project["project"]["version"]}
    (script,) = recipe["build"]["python"]["entry_points"]
    assert dict([script.split(" = ")]) == project["project"]["scripts"]


def test_windows_is_told_what_to_do():
    code = """
import sys
import indoor_explorers.env.errors
sys.platform = "win32"
try:
    import indoor_explorers.evaluation.harness.engines
except ValueError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "use the Windows Subsystem for Linux" in done.stdout
