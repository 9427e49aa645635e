"""What is printed is text, whatever it is from; tables are read in pipes too."""

import pytest
from rich.table import Table
from rich.text import Text

from indoor_explorers.evaluation.cli.command import make_console, print_line


@pytest.mark.parametrize("name", ["[bold red]x[/bold red] [/]", "\x1b[31mred", "a\u202eb", "\udcff", ":boom:"])
def test_names_are_printed_as_they_are(name, capsys):
    console, shown = make_console(), name.encode("unicode_escape").decode()
    table = Table("policy", f"steps / {name}'s", title=name)
    table.add_row(name, Text(name))
    console.print_table(table)
    console.print(f"{name} on thesis-open")
    print_line(console, name)
    printed = capsys.readouterr().out
    assert f"\n{shown} on thesis-open\n{shown}\n" in printed
    assert printed.replace("\n", "").isprintable()


def test_a_table_in_a_pipe_is_as_wide_as_it_needs(capsys):
    table = Table()
    for heading in ("policy", "old", "verdict"):
        table.add_column(heading, overflow="fold")
    table.add_row("a" * 80, "1,000.0 [900.0, 1,100.0]", "too few tasks for a test")
    make_console().print_table(table)
    (row,) = [line for line in capsys.readouterr().out.splitlines() if "1,000.0" in line]
    assert "too few tasks for a test" in row
