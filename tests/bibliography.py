"""BibTeX files, and what the docstrings of policies cite."""

import importlib
import re
import unicodedata
from functools import cache
from pathlib import Path

from indoor_explorers.env.policies.registry import policy_class, policy_entry_points

ENTRY = re.compile(r"^@(\w+)\{(\w+),\n(.*?)^\}$", re.MULTILINE | re.DOTALL)
FIELD = re.compile(r"^  (\w+) = \{(.*)\},$", re.MULTILINE)
NUMBER = re.compile(r"(?:doi:(10\.\d{4,}/\S+)|arXiv:(\d{4}\.\d{4,5}))")


def entries(path: Path) -> dict[str, dict[str, str]]:
    """The entries of a BibTeX file by key, with their fields; a line that belongs to none is refused."""
    text = "\n".join(line for line in path.read_text("utf-8").splitlines() if not line.startswith("%")) + "\n"
    found = {key: {"kind": kind, **dict(FIELD.findall(body))} for kind, key, body in ENTRY.findall(text)}
    assert not ENTRY.sub("", text).strip(), path
    assert len(found) == text.count("\n@") + text.startswith("@"), "a key stands twice"
    assert sum(len(fields) - 1 for fields in found.values()) == text.count(" = {"), "a field stands twice or is odd"
    return found


@cache
def docstrings() -> dict[str, str]:
    """The docstring of each declared policy's class with that of its module, in one line each."""
    found = {}
    for name in policy_entry_points():
        kind = policy_class(name)
        texts = (kind.__doc__, importlib.import_module(kind.__module__).__doc__)
        found[name] = " ".join(" ".join(text or "" for text in texts).split())
    return found


def numbers(text: str) -> set[str]:
    """The DOIs and arXiv numbers in a text."""
    return {(doi or arxiv).rstrip(".,;:)") for doi, arxiv in NUMBER.findall(text)}


def plain(text: str) -> str:
    """A text without TeX's accents and braces, and without accents at all."""
    for command, letter in ((r"{\ss}", "ss"), ("ß", "ss")):
        text = text.replace(command, letter)
    text = re.sub(r"\\[^a-zA-Z]|\\[a-z](?=\{)|[{}]", "", text)
    return unicodedata.normalize("NFD", text).encode("ascii", "ignore").decode().lower()
