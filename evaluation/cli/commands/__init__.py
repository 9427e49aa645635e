"""The commands, one file for each or for a few related ones.

Each file has the options of its commands and the functions that run them. A file is loaded when one of its commands is
called, and slow imports are made when that runs, so that help and errors come at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from indoor_explorers.evaluation.cli.command import Command


class Listed(NamedTuple):
    """A command by its name, as the help lists it."""

    name: str
    about: str
    """Its line in the help text."""
    home: str
    """``file:NAME`` of the command in this package."""

    def load(self) -> Command[Any]:
        """Return the command."""
        module, _, name = self.home.partition(":")
        command: Command[Any] = getattr(import_module(f"{__name__}.{module}"), name)
        return command


#: All commands, in the order of the help.
COMMANDS = (
    Listed("demo", "a first comparison of three policies, with a page and a film", "demo:DEMO"),
    Listed("playground", "write a page on which a team explores a map that you draw", "playground:PLAYGROUND"),
    Listed("compare", "fly policies on the same tasks and write a report", "compare:COMPARE"),
    Listed("watch", "watch a policy fly one episode, or save it as a video", "watch:WATCH"),
    Listed("explain", "print why each UAV flies where it does at a step", "explain:EXPLAIN"),
    Listed("report", "rebuild a report, or combine several results", "report:REPORT"),
    Listed("import", "take rows that others flew into a results folder", "importing:IMPORT"),
    Listed("export", "write a recorded episode as MCAP, ROS 2 bag or CSV", "export:EXPORT"),
    Listed("leaderboard", "rank the policies of result folders by suite and scenario", "leaderboard:LEADERBOARD"),
    Listed("peer dare", "fly policies in the simulator of DARE, run from a clone of it", "peer:DARE"),
    Listed("peer ir2", "fly teams in the simulator of IR2, run from a clone of it", "peer_ir2:IR2"),
    Listed("robot", "explore with a robot that runs ROS 2 and Nav2", "robot:ROBOT"),
    Listed("robot simulate", "simulated robots for robot", "robot:SIMULATE"),
    Listed("tune", "search for better parameters of a policy, and say what they gain", "tuning:TUNE"),
    Listed("train", "train a learner: the DDDQN, or a baseline through another library", "training:TRAIN"),
    Listed("ablate", "train a learner without each of its ingredients, and compare", "training:ABLATE"),
    Listed("scale", "train with more and less experience, width and maps, and compare", "training:SCALE"),
    Listed("thesis", "repeat every experiment of the IndoorExplorers thesis", "training:THESIS"),
    Listed("policies", "list the installed policies, or explain some", "listings:POLICIES"),
    Listed("scenarios", "list the preset scenarios, or print some", "listings:SCENARIOS"),
    Listed("learners", "list the installed learners, or explain some", "listings:LEARNERS"),
    Listed("suites", "list the suites, or explain one", "suites:SUITES"),
    Listed("maps", "draw map files, or the maps of a scenario, and print their facts", "maps:MAPS"),
    Listed("maps audit", "find the test maps that a training folder has, turned and rescaled ones too", "maps:AUDIT"),
    Listed("bench", "measure the speed figures on this machine", "bench:BENCH"),
    Listed("new", "make a folder that a plug-in starts from", "new:NEW"),
    Listed("check", "run the conformance suite on a policy", "check:CHECK"),
)
