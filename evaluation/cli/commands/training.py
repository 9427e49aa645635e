"""``train``, ``ablate``, ``scale`` and ``thesis``: train learners and evaluate them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from indoor_explorers.evaluation.cli.command import Command, make_console, print_line
from indoor_explorers.evaluation.harness.experiment.request import (
    NO_SETTINGS,
    SEED,
    Option,
    Request,
    Settings,
    read_count,
    read_names,
)

if TYPE_CHECKING:
    from rich.console import Console

    from indoor_explorers.evaluation.studies.many_trainings import Failure
    from indoor_explorers.evaluation.studies.variants.study import StudyRequest

COUNT = Option(metavar="N", read=read_count)
DEFAULT_SCENARIO = "thesis-obstacles"
#: The scenario that networks fly in a scaling study where the learner draws its own.
DEFAULT_FLOORS = "small-floors"


class TrainOptions(Request):
    """The options of ``train``."""

    learner: Annotated[str, Option(metavar="NAME")] = "dddqn"
    """The learner: dddqn, sb3-ppo and others."""
    preset: Annotated[str | None, Option(metavar="NAME")] = None
    """Take scenario, hyperparameters and seed from a preset: that of weights that ship, or a quick training. Options
    given here take precedence."""
    scenario: Annotated[str | None, Option(metavar="PRESET|FILE.toml")] = None
    """The scenario to train on (default thesis-obstacles); not for attention-sac, dddqn-places, dddqn-reports and
    pockets, which draw their own."""
    settings: Settings = NO_SETTINGS
    """Hyperparameters of the training, such as batch=512 or observation.tours=false."""
    seed: Annotated[int | None, SEED] = None
    """Random seed of the training (default 1)."""
    out: Annotated[Path, Option(metavar="DIR")]
    """Folder for checkpoints, weights and history."""
    resume: Annotated[bool, Option()] = False
    """Continue from the checkpoint in DIR."""


def run_train(options: TrainOptions, typed: str) -> int:
    """Train a learner on a scenario."""
    from indoor_explorers.env.scenarios.loading import named_scenario
    from indoor_explorers.evaluation.studies.training import find_learner, preset_of, run_training

    preset = None if options.preset is None else preset_of(options.learner, options.preset)
    default = getattr(find_learner(options.learner), "DEFAULT_SCENARIO", DEFAULT_SCENARIO)
    scenario = options.scenario or (preset.scenario if preset else default)
    seed = preset.seed if preset else 1
    return run_training(
        options.learner,
        None if scenario is None else named_scenario(scenario),
        {**(preset.settings if preset else {}), **options.settings},
        out=options.out,
        seed=seed if options.seed is None else options.seed,
        resume=options.resume,
    )


class VariantOptions(Request):
    """The options of the studies that train variants of a learner."""

    learner: Annotated[str, Option(metavar="NAME")] = "dddqn"
    """The learner."""
    only: Annotated[tuple[list[str], ...], Option(metavar="PATTERN", read=read_names, several=True)] = (["*"],)
    """Train only the variants whose names match; an ablation also trains the full one."""
    seeds: Annotated[int, COUNT] = 3
    """Number of trainings of each variant, each with another seed."""
    settings: Settings = NO_SETTINGS
    """Hyperparameters of all trainings, such as total_steps=2000000."""
    jobs: Annotated[int, COUNT] = 1
    """Number of trainings that run at the same time."""
    episodes: Annotated[int, COUNT] = 200
    """Number of unseen maps that each training is evaluated on."""
    out: Annotated[Path, Option(metavar="DIR")]
    """Folder for trainings, table and figures; an existing one is resumed."""

    def study(self, scenario: str, settings: Mapping[str, Any], typed: str) -> StudyRequest:
        """Return the study on a scenario, with ``settings`` that the user's take precedence over."""
        from indoor_explorers.env.scenarios.loading import named_scenario
        from indoor_explorers.evaluation.studies.variants.study import StudyRequest

        return StudyRequest(
            learner=self.learner,
            scenario_name=scenario,
            scenario=named_scenario(scenario),
            out=self.out,
            patterns=[pattern for patterns in self.only for pattern in patterns],
            settings={**settings, **self.settings},
            seeds=self.seeds,
            jobs=self.jobs,
            episodes=self.episodes,
            command=typed,
        )


class AblateOptions(VariantOptions):
    """The options of ``ablate``."""

    scenario: Annotated[str, Option(metavar="PRESET|FILE.toml")] = DEFAULT_SCENARIO
    """The scenario to train on."""


def run_ablate(options: AblateOptions, typed: str) -> int:
    """Train a learner's variants and print what each ingredient is worth; the status is 1 if a training failed."""
    from indoor_explorers.evaluation.studies.variants import run_ablation

    console = make_console()
    return _told(console, run_ablation(options.study(options.scenario, {}, typed), console))


def _told(console: Console, failures: Sequence[Failure]) -> int:
    """Print the trainings that failed, and return the exit status."""
    for training, reason in failures:
        print_line(console, f"failed: {training.title}: {reason}", "red")
    return 1 if failures else 0


class ScaleOptions(VariantOptions):
    """The options of ``scale``."""

    preset: Annotated[str | None, Option(metavar="NAME")] = None
    """Take scenario and hyperparameters from a preset of ``train``."""
    scenario: Annotated[str | None, Option(metavar="PRESET|FILE.toml")] = None
    """The scenario to train on and to fly (default thesis-obstacles). Learners that draw their own maps and tasks only
    fly it (default small-floors)."""


def run_scale(options: ScaleOptions, typed: str) -> int:
    """Train with more and less experience, width and maps; the status is 1 if a training failed."""
    from indoor_explorers.evaluation.studies.training import find_learner, preset_of
    from indoor_explorers.evaluation.studies.variants import run_scaling

    preset = None if options.preset is None else preset_of(options.learner, options.preset)
    default = getattr(find_learner(options.learner), "DEFAULT_SCENARIO", DEFAULT_SCENARIO) or DEFAULT_FLOORS
    scenario = options.scenario or (preset.scenario if preset else default)
    console = make_console()
    request = options.study(scenario, preset.settings if preset else {}, typed)
    return _told(console, run_scaling(request, console))


class ThesisOptions(Request):
    """The options of ``thesis``."""

    episodes: Annotated[int, COUNT] = 10_000
    """Training episodes in the empty room; among obstacles five times as many. The default is that of the thesis."""
    versions: Annotated[tuple[str, ...], Option(metavar="a,b,...", read=read_names)] = ("thesis", "mended")
    """Which versions to train. thesis: as it was; mended: with all its mistakes corrected; the name of a switch: with
    this one corrected; each: one version for each switch."""
    only: Annotated[tuple[str, ...], Option(metavar="PATTERN,...", read=read_names)] = ("*",)
    """Repeat only the experiments whose names match, such as 'team-*'."""
    settings: Settings = NO_SETTINGS
    """Hyperparameters of all trainings, such as environments=16."""
    seed: Annotated[int, SEED] = 1
    """Random seed of every training."""
    out: Annotated[Path, Option(metavar="DIR")]
    """Folder for trainings, page and figures; an existing one is resumed."""


def run_thesis_experiments(options: ThesisOptions, typed: str) -> int:
    """Repeat the thesis's experiments and write the page about them."""
    from indoor_explorers.evaluation.studies.thesis import run_thesis

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


TRAIN = Command(TrainOptions, run_train)
ABLATE = Command(AblateOptions, run_ablate)
SCALE = Command(ScaleOptions, run_scale)
THESIS = Command(ThesisOptions, run_thesis_experiments)
