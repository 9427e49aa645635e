"""Training commands of earlier versions and their translations."""

import shlex

from indoor_explorers.learners.sessions.former import translated


def test_former_commands_are_translated() -> None:
    words = "--suites floors,dungeons --data a b --flights 400 --learn-from real --no-guess --seed 2 --out results/x"
    assert shlex.join(translated("dddqn-places", words.split())) == (
        "train --learner dddqn-places --set suites=floors,dungeons data=a,b flights=400 learn_from=real guess=false "
        "--seed 2 --out results/x --resume"
    )
    assert translated("pockets", ["--out", "x"]) == ["train", "--learner", "pockets", "--out", "x", "--resume"]
