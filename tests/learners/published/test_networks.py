"""Our modules answer as the published networks do, on states that the published code has recorded."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from indoor_explorers.learners.published.checkpoint import converted
from tests.learners.published import peer_flights
from tests.learners.published.recorded import FROZEN, MODULES, difference, drawn_weights, states_of

#: A folder with clones of all three, and a Python of their requirements.
CLONES = Path(os.environ.get("PUBLISHED_CLONES", "no-folder"))
PYTHON = os.environ.get("PUBLISHED_PYTHON", "")
NAMES = {"ariadne": "ARiADNE", "ir2": "IR2", "marvel": "MARVEL"}
needs_clones = pytest.mark.skipif(
    not (CLONES.is_dir() and PYTHON),
    reason="PUBLISHED_CLONES and PUBLISHED_PYTHON name no clones and no Python for them",
)


@pytest.fixture(name="flown", scope="session")
def _flown(tmp_path_factory: pytest.TempPathFactory):
    """Return the function that lets a clone's code fly, and returns the file of the recorded states."""

    def fly(kind: str, states: int) -> Path:
        folder = tmp_path_factory.mktemp(kind)
        command = [
            PYTHON,
            peer_flights.__file__,
            kind,
            str(CLONES / NAMES[kind]),
            str(folder / "states.npz"),
            str(states),
        ]
        subprocess.run(command, cwd=folder, check=True, env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"})
        return folder / "states.npz"

    return fly


@pytest.mark.parametrize("kind", MODULES)
def test_frozen_answers_are_the_same(kind: str) -> None:
    """Logarithms of probabilities to 1e-5, and every choice; the weights are drawn, not stored."""
    states = states_of(FROZEN / f"{kind}.npz")
    worst, same = difference(kind, states)
    assert worst < 1e-5
    assert same == len(states) >= 12


def test_every_weight_matters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers with any one array of the checkpoint changed are others: none is left out; MARVEL has all layers."""
    kind = "marvel"
    states, weights = states_of(FROZEN / f"{kind}.npz")[4:5], drawn_weights(kind)
    for name, array in weights.items():
        if "encoder.layers" in name and "layers.0" not in name:
            continue  # six layers alike
        changed = weights | {name: array * 2.0 + 0.5}
        monkeypatch.setattr("tests.learners.published.recorded.drawn_weights", lambda _, changed=changed: changed)
        assert difference(kind, states)[0] > 1e-5, name


@needs_clones
@pytest.mark.slow
@pytest.mark.parametrize(("kind", "count"), [("ariadne", 340), ("ir2", 320), ("marvel", 340)])
def test_a_thousand_answers_of_the_clones_are_the_same(kind: str, count: int, flown) -> None:
    """The published code flies with random weights; its checkpoint is read, and the answers compared."""
    path, network = flown(kind, count), MODULES[kind].NETWORK
    read = network.read(path.with_suffix(".pth"))
    for name, array in converted(drawn_weights(kind), network.sizes).items():
        assert (read[name] == array).all()
    states = states_of(path)
    worst, same = difference(kind, states)
    assert len(states) == count
    assert worst < 1e-5
    assert same == count
