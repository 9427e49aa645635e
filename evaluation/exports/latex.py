r"""The results as LaTeX tables, one a scenario; they need the booktabs package and nothing else.

The file is plain ASCII and compiles with any engine: letters with accents become commands, and characters that
not every font has, such as emoji, become their code point, such as ``[U+1F681]``.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence

from indoor_explorers.evaluation.analysis.reported import MARK
from indoor_explorers.evaluation.analysis.tables.policy_names import DAGGER, DOUBLE_DAGGER, SECTION
from indoor_explorers.evaluation.drawing.formatting import EN_DASH, MINUS, THIN_SPACE
from indoor_explorers.evaluation.drawing.table import Cell, Row, Table

#: Characters with a meaning in LaTeX, or that not every engine supports.
COMMANDS = {
    **{character: f"\\{character}" for character in "&%$#_{}"},
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': "''",
    "`": "`{}",
    MINUS: "$-$",
    THIN_SPACE: r"\,",
    EN_DASH: r"\textendash{}",
    "\u00b5": r"$\mu$",
    DAGGER: r"$\dagger$",
    DOUBLE_DAGGER: r"$\ddagger$",
    SECTION: r"\S",
    MARK: r"\P{}",
    "\u00df": r"\ss{}",
}
#: Accents by their combining characters.
ACCENTS = {
    "\u0300": "`",
    "\u0301": "'",
    "\u0302": "^",
    "\u0303": "~",
    "\u0308": '"',
    "\u030a": "r",
    "\u030c": "v",
    "\u0327": "c",
}
PREAMBLE = "% One table a scenario. Needs \\usepackage{booktabs} in the preamble; include with \\input{results}.\n"


def latex_tables(tables: Sequence[Table]) -> str:
    """Return a floating table for each of the tables."""
    return PREAMBLE + "".join(map(_table, tables))


def _table(table: Table) -> str:
    lines = [
        "",
        r"\begin{table}[htbp]",
        r"  \centering\footnotesize\setlength{\tabcolsep}{4pt}",
        rf"  \caption{{Scenario {escaped(table.title)}. {escaped(' '.join(table.notes))}}}",
        rf"  \label{{tab:{table.key}}}",
        rf"  \begin{{tabular}}{{l{'r' * (len(table.columns) - 1)}}}",
        r"    \toprule",
        "    " + " & ".join(escaped(column.title) for column in table.columns) + r" \\",
        r"    \midrule",
        *(line for row in table.rows for line in _row(row)),
        r"    \bottomrule",
        r"  \end{tabular}",
        r"\end{table}",
        "",
    ]
    return "\n".join(lines)


def _row(row: Row) -> list[str]:
    """Return a line of figures and, where there are any, one of their intervals; a group guards a leading bracket."""
    lines = ["    " + " & ".join((f"{{{escaped(row.name)}}}", *map(_figure, row.cells))) + r" \\"]
    if any(cell.detail for cell in row.cells):
        lines.append("    " + "".join(f" & {_interval(cell)}".rstrip() for cell in row.cells).strip() + r" \\")
    return lines


def _figure(cell: Cell) -> str:
    return rf"\textbf{{{escaped(cell.text)}}}" if cell.best else escaped(cell.text)


def _interval(cell: Cell) -> str:
    return rf"{{\scriptsize {escaped(cell.detail)}}}" if cell.detail else ""


def escaped(text: str) -> str:
    """Return ASCII source that LaTeX typesets as ``text``, on one line."""
    line = unicodedata.normalize("NFC", re.sub(r"\s+", " ", text, flags=re.ASCII).strip())
    return re.sub("-(?=-)", "-{}", "".join(map(_character, line)))


def _character(character: str) -> str:
    if character in COMMANDS:
        return COMMANDS[character]
    if re.fullmatch(r"[ -~]", character):
        return character
    parts = unicodedata.normalize("NFD", character)
    if len(parts) == 2 and parts[1] in ACCENTS and re.fullmatch("[A-Za-z]", parts[0]):
        return rf"\{ACCENTS[parts[1]]}{{{parts[0]}}}"
    return f"[U+{ord(character):04X}]"
