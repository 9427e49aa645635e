"""The command line."""

from indoor_explorers.evaluation.cli.parser import build_parser, main

__all__ = ["build_parser", "main"]
