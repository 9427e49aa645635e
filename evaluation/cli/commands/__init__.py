"""The commands, one file for each or for a few related ones.

Each file has the options of its commands and the functions that run them. Slow imports are made when a command runs,
so that help and errors come at once.
"""

from typing import Any

from indoor_explorers.evaluation.cli.command import Command
from indoor_explorers.evaluation.cli.commands.bench import BENCH
from indoor_explorers.evaluation.cli.commands.check import CHECK
from indoor_explorers.evaluation.cli.commands.compare import COMPARE
from indoor_explorers.evaluation.cli.commands.demo import DEMO
from indoor_explorers.evaluation.cli.commands.explain import EXPLAIN
from indoor_explorers.evaluation.cli.commands.export import EXPORT
from indoor_explorers.evaluation.cli.commands.importing import IMPORT
from indoor_explorers.evaluation.cli.commands.leaderboard import LEADERBOARD
from indoor_explorers.evaluation.cli.commands.listings import LEARNERS, POLICIES, SCENARIOS
from indoor_explorers.evaluation.cli.commands.maps import AUDIT, MAPS
from indoor_explorers.evaluation.cli.commands.new import NEW
from indoor_explorers.evaluation.cli.commands.peer import DARE
from indoor_explorers.evaluation.cli.commands.peer_ir2 import IR2
from indoor_explorers.evaluation.cli.commands.playground import PLAYGROUND
from indoor_explorers.evaluation.cli.commands.report import REPORT
from indoor_explorers.evaluation.cli.commands.suites import SUITES
from indoor_explorers.evaluation.cli.commands.training import ABLATE, SCALE, THESIS, TRAIN
from indoor_explorers.evaluation.cli.commands.watch import WATCH

#: All commands, in the order of the help.
COMMANDS: tuple[Command[Any], ...] = (
    *(DEMO, PLAYGROUND, COMPARE, WATCH, EXPLAIN, REPORT, IMPORT, EXPORT, LEADERBOARD, DARE, IR2),
    *(TRAIN, ABLATE, SCALE, THESIS),
    *(POLICIES, SCENARIOS, LEARNERS, SUITES, MAPS, AUDIT, BENCH, NEW, CHECK),
)
