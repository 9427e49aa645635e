"""Long commands in blocks of code, broken as a shell reads them, so that none is cut on a page."""

from __future__ import annotations

import re

#: Characters that a line may have.
WIDE = 90


def broken(code: str) -> str:
    """Return a block of code whose long commands of this program continue on the next line, before an option."""
    return "\n".join(map(_broken_line, code.split("\n")))


def _broken_line(line: str) -> str:
    command = line.lstrip()
    if len(line) <= WIDE or " # " in line or not command.startswith("indoor-explorers "):
        return line
    lines = [""]
    for part in re.split(r" (?=--)", command):
        if lines[-1] and len(lines[-1]) + len(part) > WIDE - 10:
            lines.append(part)
        else:
            lines[-1] = f"{lines[-1]} {part}".strip()
    indent = line[: len(line) - len(command)]
    return indent + f" \\\n{indent}    ".join(lines)
