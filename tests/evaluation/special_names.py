"""Results with names that every format reads as something else."""

from dataclasses import dataclass

from indoor_explorers.env import PRESETS
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.experiment import Task, build_experiment
from indoor_explorers.evaluation.harness.results.results import Results

from .plugins import Raises, Wander

NAMES = (
    "a, b \"quoted\" </script><script>alert('x')</script>",
    "\U0001f681 $x_1$ & <b> 100 % #1 {z} \\input{/etc/passwd} ~ ^ | `ls`",
    "-v",
)
SCENARIO = '| caf\u00e9, "x" </td> [link](#) \\end{table} 50 % of_all \U0001f3e2'
USE = "tests.evaluation.plugins:Wander"


@dataclass(frozen=True, kw_only=True)
class Tallying(Wander):
    """Tally under names that are no identifiers."""

    def pilot(self, briefing):
        pilot = super().pilot(briefing)
        pilot.tally = lambda: {'"; DROP TABLE runs; --': 1.0, "A b": 2.0, "a_b": 3.0}
        return pilot


def results(episodes=6):
    """What a store would hold: an honest policy, one with odd tallies, and one that fails now and then."""
    task = PRESETS["thesis-team-2"].model_copy(update={"name": SCENARIO}).for_evaluation()
    task = task.with_settings({"budget": 60, "goal": 0.9})
    choices = [{"use": USE, "name": name, "parameters": {"speed": k}} for k, name in enumerate(NAMES, 1)]
    planned = build_experiment(choices, [task], episodes=episodes, seed=4, settings={})
    makers = (Wander, Tallying, Raises)
    records = [
        record
        for name, make in zip(NAMES, makers, strict=True)
        for record in fly(make(), name, task, [Task(task.name, 0, 4 + k) for k in range(episodes)])
    ]
    about = {name: {"use": USE, "parameters": {"speed": str(k)}, "hash": str(k)} for k, name in enumerate(NAMES, 1)}
    held = {task.name: {"fingerprint": task.fingerprint, **task.model_dump(mode="json")}}
    run = {"commit": "c0", "indoor-explorers version": "0.1.0", "processor": NAMES[1]}
    return Results(about, held, [run], records, (planned.to_toml(),))
