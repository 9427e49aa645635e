"""The picture of the architecture: the folders of the tree and what each imports, read from the code."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import networkx as nx
from matplotlib.figure import Figure

from indoor_explorers.evaluation.site.pictures.drawing import svg

ROOT = Path(__file__).resolve().parents[3]
#: The top-level folders in the order of the panels, and their colours.
TOP_LEVEL = {"env": "#e8eef7", "planners": "#e9f4ec", "learners": "#fbf0e3", "evaluation": "#f3ecf7"}
#: Folders whose own folders are drawn, since they are layers of their own.
OPEN = ("planners/toolbox",)
#: Half the height of a box of one line and what another line adds, and distances between boxes, in units of the axes.
HALF, LINE, ACROSS, DOWN = 0.22, 0.13, 1.9, 0.95
#: Layers of a full panel, and by how much one with fewer is stretched at most.
FULL, STRETCH = 10, 1.7


def architecture_pictures() -> dict[str, bytes]:
    """Return the SVG file of the architecture by name."""
    return {"architecture.svg": svg(_draw)}


def import_graph(root: Path = ROOT) -> nx.DiGraph:
    """Return which packages import which: the folders in the top-level folders, and modules that lie beside them.

    What is imported for types alone does not count, nor does a package itself.
    """
    graph = nx.DiGraph()
    for path in (path for folder in TOP_LEVEL for path in sorted((root / folder).rglob("*.py"))):
        here = package_of(path.relative_to(root).with_suffix("").parts)
        if here is not None:
            graph.add_node(here)
            targets = (package_of(name.split(".")[1:]) for name in _imports(ast.parse(path.read_text("utf-8"))))
            graph.add_edges_from((here, there) for there in targets if there not in (None, here))
    return graph


def package_of(parts: Any) -> str | None:
    """Return the package of a module by the parts of its name below the root; None for a top-level folder."""
    parts = [part for part in parts if part != "__init__"]
    deep = 3 if "/".join(parts[:2]) in OPEN else 2
    name = "/".join(parts[:deep])
    while name and not (ROOT / name).is_dir() and not (ROOT / f"{name}.py").exists():
        name = name.rpartition("/")[0]
    return name if "/" in name and name not in OPEN else None


def _imports(node: ast.AST) -> Iterator[str]:
    """Yield the names that a module imports from this package when it runs."""
    if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        return
    if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("indoor_explorers."):
        yield from (f"{node.module}.{alias.name}" for alias in node.names)
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.expr):  # which holds no import
            yield from _imports(child)


def _draw(figure: Figure) -> None:
    """Draw a panel for each top-level folder: packages above those that they import."""
    graph = import_graph()
    figure.set_size_inches(11.5, 9.2)
    panels = figure.subplots(2, 2, sharey=True)
    for axes, (folder, colour) in zip(panels.flat, TOP_LEVEL.items(), strict=True):
        packages = graph.subgraph([package for package in graph if package.startswith(f"{folder}/")])
        _panel(axes, nx.transitive_reduction(packages), folder, colour)


def _panel(axes: Any, packages: nx.DiGraph, folder: str, colour: str) -> None:
    """Draw the packages of a folder in layers; an arrow leads to what is imported, unless another way leads there."""
    layers = [sorted(layer) for layer in nx.topological_generations(packages)]
    down = DOWN * min(STRETCH, (FULL - 1) / (len(layers) - 1))
    places = {
        package: ((number - (len(layer) - 1) / 2) * ACROSS, -depth * down)
        for depth, layer in enumerate(layers)
        for number, package in enumerate(layer)
    }
    for one, other in packages.edges:
        (x, y), (to_x, to_y) = places[one], places[other]
        ends = (to_x, to_y + _half(other)), (x, y - _half(one))
        style = {"arrowstyle": "-|>", "color": "#7a7f87", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", *ends, arrowprops=style, zorder=1)
    for package, (x, y) in places.items():
        label = package.removeprefix(f"{folder}/").replace("toolbox/", "toolbox/\n")
        box = {"boxstyle": "round,pad=0.3", "facecolor": colour, "edgecolor": "#555a61", "linewidth": 0.8}
        axes.text(x, y, label, ha="center", va="center", fontsize=7.5, bbox=box, zorder=2)
    widest = max(len(layer) for layer in layers)
    axes.set_xlim(-widest * ACROSS / 2, widest * ACROSS / 2)
    axes.set_ylim(min(-(FULL - 0.5) * DOWN, -(len(layers) - 0.5) * down), DOWN / 2)
    axes.set_title(folder)
    axes.set_axis_off()


def _half(package: str) -> float:
    """Return half the height of a package's box."""
    return HALF + LINE * package.startswith(OPEN)
