"""The command line: ``indoor-explorers compare | watch | report | export | train | ablate | scale | bench | ...``."""

from __future__ import annotations

import argparse
import difflib
import errno
import shlex
import sys
import warnings
from collections.abc import Container, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from indoor_explorers.evaluation.cli.commands import COMMANDS

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from indoor_explorers.evaluation.cli.command import Command
    from indoor_explorers.evaluation.harness.experiment.request import Option, Request

#: Exit statuses.
OK, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130
#: Words that ask for help.
HELP = ("-h", "--help")
#: Shells that scripts for completion are written for.
SHELLS = ("bash", "zsh", "tcsh")
#: What the system says when a file finds no room: full disk, full quota, file too large.
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


class _Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line, with the likely word where one is unknown."""

    def error(self, message: str) -> NoReturn:
        from indoor_explorers.env.errors import InputError

        raise InputError(f"{message}; see {self.prog} --help")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        parsed, rest = super().parse_known_args(args, namespace)
        if rest:
            self.error(f"unrecognized arguments: {' '.join(rest)}{self._likely(rest)}")
        return parsed, rest

    def _likely(self, words: Iterable[str]) -> str:
        """Return the option that the first unknown one is most like."""
        unknown = next((word.partition("=")[0] for word in words if word.startswith("-")), "")
        close = difflib.get_close_matches(unknown, self._option_string_actions, n=1)
        return f"; did you mean {close[0]}?" if close else ""

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        from indoor_explorers.env.errors import did_you_mean

        if action.choices is not None and value not in action.choices:
            raise argparse.ArgumentError(action, f"invalid choice: {value!r}{did_you_mean(value, action.choices)}")


class _Version(argparse.Action):
    """Print the version, which is looked up only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"indoor-explorers {version('indoor-explorers')}\n")
        parser.exit()


class _Completion(argparse.Action):
    """Print a script that completes commands and options in a shell."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: Any, values: Any, *_: Any) -> None:
        import shtab

        sys.stdout.write(f"{shtab.complete(build_parser(), shell=values)}\n")
        parser.exit()


def build_parser(of: Container[str] | None = None) -> argparse.ArgumentParser:
    """Return the parser of the whole command, with the options of the commands ``of`` these names; None for all."""
    parser = _Parser(prog="indoor-explorers", description="Compare exploration policies for teams of UAVs.")
    parser.add_argument(
        "--version", action=_Version, nargs=0, default=argparse.SUPPRESS, help="show the version and exit"
    )
    parser.add_argument(
        "--print-completion",
        action=_Completion,
        choices=SHELLS,
        default=argparse.SUPPRESS,
        help="print a script that completes commands and options: eval it, or put it where the shell looks",
    )
    parsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=_Parser)
    for command in COMMANDS:
        words = parsers.add_parser(command.name, help=command.about)
        if of is None or command.name in of:
            add_options(words, command.load().options)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    words = list(sys.argv[1:] if argv is None else argv)
    with suppress(FileNotFoundError):  # the current folder was removed
        sys.path.append(str(Path.cwd()))  # so that module:Class finds a file of the current folder, as python -m would
    if not words or words[0] in HELP:
        build_parser(of=()).parse_args(["--help"])  # ends here, before anything slow is imported
    return _run(words)


def _run(words: list[str]) -> int:
    from indoor_explorers.env.errors import LONGEST_LINE, InputError, PolicyError, RunError, one_line
    from indoor_explorers.evaluation.cli.command import KEPT, debugging

    kept = KEPT
    try:
        joined = joined_words(words)
        given = vars(build_parser(of=joined[:1]).parse_args(joined))
        name = given.pop("command")
        command = next(each for each in COMMANDS if each.name == name).load()
        kept = command.interrupted
        with warnings.catch_warnings():
            warnings.showwarning = _show_warning
            return _start(command, given, shlex.join(["indoor-explorers", *words]))
    except (InputError, PolicyError, RunError) as error:
        if debugging():
            raise
        sys.stderr.write(f"indoor-explorers: {one_line(str(error), LONGEST_LINE)}\n")
        return USAGE if isinstance(error, InputError) else FAILED
    except BrokenPipeError:
        sys.stderr.close()
        return FAILED
    except OSError as error:
        if debugging():
            raise
        sys.stderr.write(f"indoor-explorers: {one_line(_system_error(error), LONGEST_LINE)}\n")
        return FAILED
    except KeyboardInterrupt:
        sys.stderr.write(f"indoor-explorers: interrupted; {kept}\n")
        return INTERRUPTED


def joined_words(words: list[str]) -> list[str]:
    """Return the words typed, with the name of a command of two words as one."""
    two = " ".join(words[:2])
    return [two, *words[2:]] if any(command.name == two for command in COMMANDS) else words


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Show a warning that is meant for users, such as of an old name, on one line; others with their place in code."""
    from indoor_explorers.env.errors import LONGEST_LINE, one_line

    text = f"{message}" if issubclass(category, FutureWarning) else f"{filename}:{lineno}: {message}"
    sys.stderr.write(f"indoor-explorers: {one_line(text, LONGEST_LINE)}\n")


def _start(command: Command[Any], given: dict[str, Any], typed: str) -> int:
    """Run a command; a policy in this process that exits does not end it without a word."""
    from indoor_explorers.env.errors import RunError, described

    try:
        return command.start(given, typed)
    except SystemExit as error:
        if isinstance(error.__context__, BrokenPipeError):  # rich exits when the reader of a pipe has closed it
            raise error.__context__ from None
        raise RunError(f"a policy, or a library that it uses, ended the command: {described(error)}") from error


def _system_error(error: OSError) -> str:
    line = f"{error.filename or 'the output'}: {error.strerror or error}"
    if error.errno in NO_ROOM:
        line += "; what is finished is kept: make room on the disk, and the same command goes on from there"
    return line


def add_options(parser: argparse.ArgumentParser, request: type[Request]) -> None:
    """Add an option for every field marked as one; options that are not given are missing in the parsed namespace."""
    from indoor_explorers.evaluation.harness.experiment.request import Option

    for name, field in request.model_fields.items():
        for option in field.metadata:
            if isinstance(option, Option):
                words = _words(name, field, option)
                parser.add_argument(*words.pop("flags"), default=argparse.SUPPRESS, help=_help(field), **words)


def _words(name: str, field: FieldInfo, option: Option) -> dict[str, Any]:
    if option.positional:
        several = {"nargs": "+" if field.is_required() else "*"} if option.several else {}
        value = {"type": option.read, "metavar": option.metavar, "choices": option.choices}
        return {"flags": [name], **value, **several}
    words: dict[str, Any] = {"flags": [option.flag or "--" + name.replace("_", "-")], "dest": name}
    words["required"] = field.is_required()
    if field.annotation is bool:
        return words | {"action": "store_true"}
    words |= {"type": option.read, "metavar": option.metavar, "choices": option.choices}
    if option.alone is not None:
        return words | {"nargs": "?", "const": option.alone}
    return words | {"nargs": "+", "action": "extend"} if option.several else words


def _help(field: FieldInfo) -> str:
    """Return the docstring of a field, with its default where that is a word or a number."""
    text = " ".join((field.description or "").split())
    if isinstance(field.default, (str, int, float)) and not isinstance(field.default, bool):
        text += f" Default: {field.default if isinstance(field.default, str) else format(field.default, 'g')}."
    return text.replace("%", "%%")


if __name__ == "__main__":
    sys.exit(main())
