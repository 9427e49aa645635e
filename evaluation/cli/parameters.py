"""The parameters of policies and the hyperparameters of learners, with defaults and docstrings."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
import textwrap
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, NamedTuple

from pydantic import BaseModel


class Parameter(NamedTuple):
    """One parameter."""

    key: str
    """Dotted where it is in a table."""
    default: str
    """As Python writes it; empty where there is none."""
    about: str
    """Its docstring."""


def policy_parameters(kind: Any) -> list[Parameter]:
    """Return the parameters of a policy's constructor; those of dataclasses have docstrings."""
    classes = getattr(kind, "__mro__", ())
    if not dataclasses.is_dataclass(kind):
        given = inspect.signature(kind).parameters.values()
        return [Parameter(each.name, "" if each.default is each.empty else repr(each.default), "") for each in given]
    about = {name: text for base in reversed(classes) for name, text in _attribute_docstrings(base)}
    return [Parameter(each.name, _default_of(each), about.get(each.name, "")) for each in dataclasses.fields(kind)]


def model_parameters(model: type[BaseModel], prefix: str = "") -> Iterator[Parameter]:
    """Yield the fields of a model, and of the models in it."""
    for name, field in model.model_fields.items():
        value = field.get_default(call_default_factory=True)
        if isinstance(value, BaseModel):
            yield from model_parameters(type(value), f"{prefix}{name}.")
        else:
            default = "" if field.is_required() else repr(value)
            yield Parameter(prefix + name, default, _one_line(field.description or ""))


def _default_of(field: dataclasses.Field[Any]) -> str:
    if field.default_factory is not dataclasses.MISSING:
        return repr(field.default_factory())
    return "" if field.default is dataclasses.MISSING else repr(field.default)


def _attribute_docstrings(kind: type) -> Iterator[tuple[str, str]]:
    """Yield the attributes of a class that are followed by a string, with that string."""
    try:
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(kind))).body
    except (OSError, TypeError, SyntaxError, ValueError):  # a class without a source file
        return
    body = tree.body if isinstance(tree, ast.ClassDef) else []
    for attribute, text in pairwise(body):
        if isinstance(attribute, ast.AnnAssign) and isinstance(attribute.target, ast.Name) and _is_text(text):
            yield attribute.target.id, _one_line(ast.literal_eval(text.value))  # type: ignore[attr-defined]


def _is_text(statement: ast.stmt) -> bool:
    value = getattr(statement, "value", None)
    return isinstance(statement, ast.Expr) and isinstance(value, ast.Constant) and isinstance(value.value, str)


def _one_line(text: str) -> str:
    return " ".join(plain_text(text).split())


def plain_text(docstring: str) -> str:
    """Return a docstring without markup: ``:class:`~a.b.Name``` is ``Name``."""
    return re.sub(r":\w+:`~?(?:[\w.]*\.)?(\w+)`", r"\1", inspect.cleandoc(docstring)).replace("``", "")
