"""Pages of studies: one HTML file with its style and its pictures in it, from a template of the study's package."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

from indoor_explorers.env.files import write_whole
from indoor_explorers.evaluation.drawing.formatting import percent


def write_study_page(package: str, path: Path, folder: Path, /, **context: Any) -> None:
    """Write a page from ``page.html`` of a package, which extends ``study.html``.

    In it ``picture("name")`` is the PNG of that name in ``folder``, and ``share|percent`` whole percents.
    """
    environment = Environment(
        loader=ChoiceLoader([PackageLoader(package, "."), PackageLoader("indoor_explorers.evaluation.drawing", ".")]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["percent"] = lambda share: percent(share, 0)
    text = environment.get_template("page.html").render(
        picture=lambda stem: _embedded(folder / f"{stem}.png"), **context
    )
    write_whole(path, text)


def _embedded(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode("ascii")
