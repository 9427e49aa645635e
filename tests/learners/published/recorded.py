"""States that published code has recorded, and fake clones for policies to fly."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from indoor_explorers.env.grid.cells import FREE, OCCUPIED
from indoor_explorers.learners.published import ariadne, ir2, marvel
from indoor_explorers.learners.published.checkpoint import converted, shapes
from indoor_explorers.learners.published.network import scores
from indoor_explorers.learners.published.policy import Ariadne, Ir2, Marvel, PublishedPolicy
from indoor_explorers.learners.published.sighted import Directions, Observation
from tests.learners.published.peer_flights import random_weights

MODULES = {"ariadne": ariadne, "ir2": ir2, "marvel": marvel}
POLICIES: dict[str, type[PublishedPolicy]] = {"ariadne": Ariadne, "ir2": Ir2, "marvel": Marvel}
#: Recorded by peer_flights.py from the clones; see its first lines.
FROZEN = Path(__file__).with_name("states")
State = dict[str, np.ndarray]


def states_of(path: Path) -> list[State]:
    """Return the states of a file, in their order."""
    found: dict[int, State] = {}
    with np.load(path) as arrays:
        for name in arrays.files:
            number, _, part = name.partition("/")
            found.setdefault(int(number), {})[part] = arrays[name]
    return [found[number] for number in sorted(found)]


def drawn_weights(kind: str) -> dict[str, np.ndarray]:
    """Return the random weights of the recordings, by their names in a checkpoint."""
    drawn: State = random_weights(shapes(MODULES[kind].NETWORK.sizes))
    return drawn


def difference(kind: str, states: list[State]) -> tuple[float, int]:
    """Return the largest difference of the logarithms of probabilities, and how many choices are the same."""
    sizes, weights, worst, same = (
        MODULES[kind].NETWORK.sizes,
        converted(drawn_weights(kind), MODULES[kind].NETWORK.sizes),
        0.0,
        0,
    )
    for state in states:
        shut = state["masked"] == 1
        if kind != "marvel":
            shut[0] = not shut.all() or kind == "ariadne"  # IR2 stays where nothing else is left
        found = np.where(
            np.expand_dims(shut, 1), -1e8, scores(seen(state), weights, sizes).reshape(len(shut), -1)
        ).ravel()
        log_p = np.asarray(torch.from_numpy(found).log_softmax(0))
        worst = max(worst, float(np.abs(log_p - state["logits"])[state["logits"] > -1e6].max()))
        same += log_p.argmax() == state["logits"].argmax()
    return worst, same


def seen(state: State) -> Observation:
    """Return a recorded state as an observation."""
    looks = Directions(state["frontiers"], state["visited"], state["headings"]) if "headings" in state else None
    near, options = state["near"].astype(np.int64), state["options"].astype(np.int64)
    none = np.zeros(len(near), np.bool_)
    legal = state["masked"] == 0
    return Observation(
        np.zeros((len(near), 2), np.int64), state["features"], near, int(state["own"]), options, legal, none, looks
    )


def belief_of(state: State) -> np.ndarray:
    """Return a recorded map (H, W) in the values of this world."""
    values = np.zeros(256, np.uint8)
    values[[1, 255]] = OCCUPIED, FREE
    return values[state["belief"]]


def cells_of(points: np.ndarray) -> np.ndarray:
    """Return recorded columns and rows as rows and columns."""
    return points.astype(np.int64).reshape(-1, 2)[:, ::-1]


def fake_clone(kind: str, folder: Path, monkeypatch: pytest.MonkeyPatch, **entries: Any) -> Path:
    """Return a folder with a checkpoint of random weights that passes as a clone."""
    policy = POLICIES[kind]
    network = policy.NETWORK
    monkeypatch.setattr(policy, "NETWORK", network._replace(code=replace(network.code, files={})))
    weights = {name: torch.from_numpy(value) for name, value in drawn_weights(kind).items()}
    path = folder / network.checkpoint
    path.parent.mkdir(parents=True)
    torch.save({"policy_model": weights, "episode": 7} | entries, path)
    return folder
