"""``train``, ``ablate`` and ``thesis``: train learners, and say what came of it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.experiment.request import NO_SETTINGS, SEED, Request, Settings
from indoor_explorers.evaluation.options import Option, read_count, read_names

COUNT = Option(metavar="N", read=read_count)
DEFAULT_SCENARIO = "thesis-obstacles"


class TrainOptions(Request):
    """What is trained, on what, and where it is written."""

    learner: Annotated[str, Option(metavar="NAME")] = "dddqn"
    """What learns: dddqn, sb3-ppo and others."""
    preset: Annotated[str | None, Option(metavar="NAME")] = None
    """Scenario, hyperparameters and seed of weights that ship, or of a quick training, where not given here."""
    scenario: Annotated[str | None, Option(metavar="PRESET|FILE.toml")] = None
    """What to train on (default thesis-obstacles)."""
    settings: Settings = NO_SETTINGS
    """Hyperparameters of the training, such as batch=512 or observation.tours=false."""
    seed: Annotated[int | None, SEED] = None
    """Makes the whole training (default 1)."""
    out: Annotated[Path, Option(metavar="DIR")]
    """Folder of checkpoints, weights and history."""
    resume: Annotated[bool, Option()] = False
    """Go on from the checkpoint in DIR."""


def run_train(options: TrainOptions, typed: str) -> int:
    """Train a learner on a scenario, both given or a preset's."""
    from indoor_explorers.env.scenarios.loading import named_scenario
    from indoor_explorers.evaluation.training import preset_of, run_training

    preset = None if options.preset is None else preset_of(options.learner, options.preset)
    seed = preset.seed if preset else 1
    return run_training(
        options.learner,
        named_scenario(options.scenario or (preset.scenario if preset else DEFAULT_SCENARIO)),
        {**(preset.settings if preset else {}), **options.settings},
        out=options.out,
        seed=seed if options.seed is None else options.seed,
        resume=options.resume,
    )


class AblateOptions(Request):
    """Which variants of a learner are trained and compared."""

    learner: Annotated[str, Option(metavar="NAME")] = "dddqn"
    """What learns."""
    scenario: Annotated[str, Option(metavar="PRESET|FILE.toml")] = DEFAULT_SCENARIO
    """What to train on."""
    only: Annotated[tuple[list[str], ...], Option(metavar="PATTERN", read=read_names, several=True)] = (["*"],)
    """Train these variants and the full one."""
    seeds: Annotated[int, COUNT] = 3
    """Trainings of each variant."""
    settings: Settings = NO_SETTINGS
    """Hyperparameters of all trainings, such as total_steps=2000000."""
    jobs: Annotated[int, COUNT] = 1
    """Trainings at once."""
    episodes: Annotated[int, COUNT] = 200
    """Unseen maps that each training is evaluated on."""
    out: Annotated[Path, Option(metavar="DIR")]
    """Folder of trainings, table and figures; resumed when it exists."""


def run_ablate(options: AblateOptions, typed: str) -> int:
    """Train a learner's variants and say what each ingredient is worth; the status is 1 where a training failed."""
    from indoor_explorers.evaluation.ablation import run_ablation

    console = make_console()
    failures = run_ablation(
        options.learner,
        options.scenario,
        options.out,
        console,
        patterns=[pattern for patterns in options.only for pattern in patterns],
        settings=options.settings,
        seeds=options.seeds,
        jobs=options.jobs,
        episodes=options.episodes,
        command=typed,
    )
    for training, reason in failures:
        print_line(console, f"failed: {training.title}: {reason}", "red")
    return 1 if failures else 0


class ThesisOptions(Request):
    """Which experiments of the thesis are flown again."""

    episodes: Annotated[int, COUNT] = 10_000
    """Training episodes in the empty room, five times as many among obstacles; the default is the thesis's."""
    versions: Annotated[tuple[str, ...], Option(metavar="a,b,...", read=read_names)] = ("thesis", "mended")
    """thesis: as it was; mended: every mistake corrected; a switch's name: this one alone; each: each of them alone."""
    only: Annotated[tuple[str, ...], Option(metavar="PATTERN,...", read=read_names)] = ("*",)
    """Only experiments with such a name: 'team-*'."""
    settings: Settings = NO_SETTINGS
    """Hyperparameters of all trainings, such as environments=16."""
    seed: Annotated[int, SEED] = 1
    """Makes every training."""
    out: Annotated[Path, Option(metavar="DIR")]
    """Folder of trainings, page and figures; resumed when it exists."""


def run_thesis_experiments(options: ThesisOptions, typed: str) -> int:
    """Fly the thesis's experiments and write the page about them."""
    from indoor_explorers.evaluation.thesis import run_thesis

    console = make_console()
    run_thesis(
        options.out,
        console,
        episodes=options.episodes,
        version_names=options.versions,
        patterns=options.only,
        settings=options.settings,
        seed=options.seed,
    )
    print_line(console, f"Page: {options.out / 'thesis.html'}")
    return 0


TRAIN = Command("train", "train a learner: the DDDQN, or a baseline through another library", TrainOptions, run_train)
ABLATE = Command("ablate", "train a learner without each of its ingredients, and compare", AblateOptions, run_ablate)
THESIS = Command(
    "thesis", "fly every experiment of the IndoorExplorers thesis again", ThesisOptions, run_thesis_experiments
)
