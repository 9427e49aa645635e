"""Hashes of the sources and files outside this package that the flights of a policy depend on."""

from __future__ import annotations

import dataclasses
import hashlib
import sys
from collections.abc import Iterator
from importlib.metadata import distributions, packages_distributions
from itertools import islice
from pathlib import Path
from types import ModuleType
from typing import Any

from indoor_explorers.env import Policy
from indoor_explorers.env.files import expanded

#: The package itself, whose commit is a fact of the run, and the modules of the base classes of policies.
_OURS = (__name__.partition(".")[0], "builtins", "abc", "typing")
#: The most files of one package or folder that are hashed.
MOST_FILES = 2000
_LIBRARIES = {"site-packages", "dist-packages"}


def outside_files(policy: Policy, use: str = "") -> dict[str, str]:
    """Return hashes of the sources behind a policy and of the files that its parameters name.

    Sources are those of the packages that its classes are from and of their distributions, and of the module that it
    is asked for by (``use``); of a module by itself, also the loaded modules beside it. Keys are paths that are the
    same on another machine. Parameters count where they are paths, or texts that look like one, and lead to a file or
    a folder. The project's own sources are left out.
    """
    found: dict[str, str] = {}
    for top in sorted(_packages(policy, use)):
        for name, file in islice(_sources(sys.modules[top]), MOST_FILES):
            found[name] = _digest(file)
    for parameter, value in _parameters(policy).items():
        if isinstance(value, Policy):
            found |= outside_files(value)
        for name, file in islice(_given(parameter, value), MOST_FILES):
            found[name] = _digest(file)
    return {name: digest for name, digest in found.items() if digest}


def changed_files(before: dict[str, str] | None, now: dict[str, str] | None) -> list[str]:
    """Return the files whose hashes differ; none where one side did not store them."""
    if before is None or now is None:
        return []
    return sorted(name for name in before.keys() | now.keys() if before.get(name) != now.get(name))


def _packages(policy: Policy, use: str) -> set[str]:
    """Return the top-level packages and modules outside this package that a policy is from."""
    modules = [kind.__module__ for kind in type(policy).__mro__ if not _is_library(kind.__module__)]
    modules += [type(policy).__module__, use.partition(":")[0] if ":" in use else ""]
    tops = {module.partition(".")[0] for module in modules} - {"", *_OURS}
    tops &= sys.modules.keys()
    if tops and _may_be_installed(tops):
        owners = packages_distributions()
        mine = {owner for top in tops for owner in owners.get(top, ())}
        tops |= {top for top, names in owners.items() if top in sys.modules and mine.intersection(names)} - {*_OURS}
    return tops


def _may_be_installed(tops: set[str]) -> bool:
    """Tell whether an installed distribution may hold one of some modules; to be sure takes a third of a second."""
    for distribution in distributions():
        held = (distribution.read_text("top_level.txt") or "").strip() or distribution.read_text("RECORD")
        if held is None or any(f"{before}{top}" in f"\n{held}" for top in tops for before in ("\n", '\n"')):
            return True
    return False


def _is_library(module: str) -> bool:
    """Tell whether a module is of Python itself or of an installed library."""
    if module.partition(".")[0] in sys.stdlib_module_names:
        return True
    file = getattr(sys.modules.get(module), "__file__", None)
    return file is not None and not _LIBRARIES.isdisjoint(Path(file).parts)


def _sources(module: ModuleType) -> Iterator[tuple[str, Path]]:
    """Yield names and files of a package's sources, or of a module and the loaded ones beside it."""
    if hasattr(module, "__path__"):
        for folder in map(Path, module.__path__):
            for file in sorted(folder.rglob("*.py")):
                yield f"{module.__name__}/{file.relative_to(folder).as_posix()}", file
        return
    if not (source := getattr(module, "__file__", None)):  # a notebook and an interactive session have none
        return
    own = Path(source)
    yield own.name, own
    for name, other in sorted(sys.modules.items()):
        file = Path(getattr(other, "__file__", None) or ".")
        ours = name.partition(".")[0] in (*_OURS, "__main__")
        if file.is_relative_to(own.parent) and not ours and not _is_library(name):
            yield file.relative_to(own.parent).as_posix(), file


def _parameters(policy: Policy) -> dict[str, Any]:
    if dataclasses.is_dataclass(policy):
        return {field.name: getattr(policy, field.name, None) for field in dataclasses.fields(policy)}
    return dict(vars(policy)) if hasattr(policy, "__dict__") else {}


def _given(parameter: str, value: object) -> Iterator[tuple[str, Path]]:
    """Yield names and files of what a parameter names."""
    looks_like_path = isinstance(value, str) and len(value) < 1000 and ("/" in value or bool(Path(value).suffix))
    if not isinstance(value, Path) and not looks_like_path:
        return
    path = expanded(str(value))
    try:
        if path.is_file():
            yield f"{parameter}: {path.name}", path
        elif path.is_dir():
            for file in sorted(file for file in path.rglob("*") if file.is_file()):
                yield f"{parameter}: {path.name}/{file.relative_to(path).as_posix()}", file
    except (OSError, ValueError):  # no path after all
        return


def _digest(file: Path) -> str:
    """Return a hash of a file's contents, empty where it cannot be read."""
    try:
        with file.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()[:16]
    except OSError:
        return ""
