"""Makes the folder that a plug-in starts from: names that fit together, in files made of templates."""

from __future__ import annotations

import importlib.util
import keyword
import re
import sys
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.maps.sources import SOURCES
from indoor_explorers.env.plugins import MAPS, declared
from indoor_explorers.env.policies.registry import opener_entry_points, policy_entry_points
from indoor_explorers.evaluation.studies.training import learner_entry_points

#: The template of each file of all plug-ins, and of those that some kinds have beside them.
FILES = {name: name for name in ("README.md", "comparison.toml", "pyproject.toml")} | {
    **{".github/workflows/test.yml": "workflow.yml", ".gitignore": "gitignore"},
    **{"{module}.py": "{kind}.py", "tests/test_{module}.py": "{kind}_test.py"},
}
KINDS: dict[str, dict[str, str]] = {"planner": {}, "learner": {}, "map-reader": {"maps/example.csv": "example.csv"}}
#: A distribution's name, as in https://packaging.python.org/en/latest/specifications/name-normalization.
DISTRIBUTION = re.compile(r"[A-Z0-9]|[A-Z0-9][A-Z0-9._-]*[A-Z0-9]", re.IGNORECASE | re.ASCII)
#: Modules that would hide this package, or be taken for something else in the folder.
RESERVED = {"indoor_explorers", "conftest", "setup", "tests"}


def names_of(kind: str, name: str) -> dict[str, str]:
    """Return kind, name, module and class of a plug-in: ``my-planner`` has ``my_planner`` and ``MyPlanner``.

    Raises :class:`InputError` if the name is no distribution's, makes no module, or is taken.
    """
    module = re.sub(r"[-_.]+", "_", name).lower()
    cls = "".join(word.capitalize() for word in module.split("_"))
    if fault := _fault(kind, name, module, cls):
        raise InputError(f"expected a new name, such as my-{kind}, got {name!r}: {fault}; choose another")
    return {"kind": kind, "name": name, "module": module, "cls": cls}


def _fault(kind: str, name: str, module: str, cls: str) -> str:
    """Return why a plug-in cannot have these names; empty if it can."""
    if not DISTRIBUTION.fullmatch(name):
        return "names have letters, digits, '-', '_' and '.', and a letter or digit at both ends"
    if not module.isidentifier() or keyword.iskeyword(module) or keyword.iskeyword(cls):
        return f"Python allows no module {module} with a class {cls}"
    known = {**policy_entry_points(), **opener_entry_points(), **learner_entry_points(), **SOURCES, **declared(MAPS)}
    if {name, module} & known.keys():
        return "an installed policy, learner or source of maps has it"
    if module in RESERVED | sys.stdlib_module_names or getattr(importlib.util.find_spec(module), "origin", None):
        return f"its module {module} would hide another, or be hidden"
    template = (Path(__file__).parent / "templates" / f"{kind}.py.jinja").read_text("utf-8")
    used = re.findall(r"\w+", " ".join(re.findall(r"(?:import|class) .*", template)))
    return f"its module uses another class {cls}" if cls in used else ""


def make_folder(kind: str, name: str, out: Path) -> list[str]:
    """Write the folder ``out`` completely or not at all; return the paths of its files in it.

    Raises :class:`InputError` if the name cannot be used, or the folder exists or cannot be written.
    """
    names, loader = names_of(kind, name), PackageLoader(__name__.rpartition(".")[0])
    templates = Environment(
        loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    files = {
        path.format(**names): templates.get_template(f"{template.format(**names)}.jinja").render(names)
        for path, template in (FILES | KINDS[kind]).items()
    }
    try:
        if out.exists() or out.is_symlink():
            raise InputError(f"expected a new folder, got {out}, which exists; give another --out")
        with written_whole(out) as partial:
            partial.mkdir()
            for path, text in files.items():
                (partial / path).parent.mkdir(parents=True, exist_ok=True)
                (partial / path).write_text(text, "utf-8")
    except OSError as error:
        raise InputError(
            f"expected a folder that can be made, got {out}: {error.strerror}; give another --out"
        ) from error
    return sorted(files)
