"""The output of ``indoor-explorers check``: the policy, the result of each check, and how to fix failures."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from indoor_explorers.env import Finding, Policy
from indoor_explorers.env.conformance import is_privileged, shown

#: Columns that everything is indented by.
_INDENT = 2


def print_header(console: Console, name: str, policy: Policy) -> None:
    """Print the policy's name, class and parameters, and whether it knows the true map.

    Raises:
        PolicyError: the policy cannot say whether it is privileged.

    """
    kind = type(policy)
    known = "the true map, too: privileged" if is_privileged(policy) else "its view and briefing alone"
    if policy.uses_generator:
        known += "; it reads the settings of the maps' generator (uses_generator)"
    facts = Table.grid(padding=(0, 2))
    facts.add_column(style="dim", no_wrap=True)
    facts.add_column(overflow="fold")
    for label, value in (
        ("policy", Text(name, style="bold")),
        ("class", Text(f"{kind.__module__}:{kind.__qualname__}")),
        ("parameters", Text(_parameters(policy))),
        ("knows", Text(known)),
    ):
        facts.add_row(label, value)
    console.print(Padding(facts, (1, 0, 1, _INDENT), expand=False), highlight=False)


def _parameters(policy: Policy) -> str:
    if not dataclasses.is_dataclass(policy):
        return "none that results can store; make the policy a dataclass"
    texts = [f"{field.name}={shown(getattr(policy, field.name, None))}" for field in dataclasses.fields(policy)]
    return ", ".join(texts) or "none"


def print_findings(console: Console, findings: Sequence[Finding]) -> None:
    """Print a row for each finding and a line that sums them up."""
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for finding in findings:
        table.add_row(_mark(finding, console.options.ascii_only), Text(finding.name), _found(finding))
    console.print(Padding(table, (0, 0, 1, _INDENT), expand=False), highlight=False)
    passed, seconds = sum(finding.passed for finding in findings), sum(finding.seconds for finding in findings)
    style, warned = "bold red" if any(finding.error for finding in findings) else "bold green", _warned(findings)
    summary = Text(f"{passed} of {len(findings)} checks passed{warned}", style=style).append(
        f" in {seconds:.1f} s", style="dim"
    )
    console.print(Padding(summary, (0, 0, 0, _INDENT), expand=False), highlight=False)


def _warned(findings: Sequence[Finding]) -> str:
    count = sum(finding.warned for finding in findings)
    return f", {count} with a warning" if count else ""


def _mark(finding: Finding, plain: bool) -> Text:
    """Return a tick or a cross with a word beside it, so that colours are not needed."""
    if finding.warned:
        sign, word, style = "! ", "warning", "yellow"
    elif finding.passed:
        sign, word, style = "\N{CHECK MARK} ", "ok", "green"
    elif finding.conclusive:
        sign, word, style = "\N{BALLOT X} ", "FAILED", "bold red"
    else:
        sign, word, style = "- ", "unknown", "yellow"
    return Text(word if plain else sign + word, style=style)


def _found(finding: Finding) -> Text:
    """Return what was found and, on lines of their own, the likely cause and the way to fix it."""
    text = Text(finding.text, style="" if finding.conclusive else "dim")
    if finding.fix:
        text.append(f"\nTo fix: {finding.fix}", style="yellow")
    return text
