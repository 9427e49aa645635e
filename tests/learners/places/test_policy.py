from pathlib import Path
from typing import Any

import numpy as np
import pytest

from indoor_explorers.env import InputError, make_policy
from indoor_explorers.learners.places.network import Loaded, load_weights, write_weights
from indoor_explorers.learners.places.pilot import PlacesPilot
from indoor_explorers.learners.places.policy import SHIPPED, DddqnPlaces
from indoor_explorers.learners.places.scene import OTHERS, Scene
from tests.learners.places.small import world_on_a_floor
from tests.learners.places.test_scene import no_weights, pilot_of


def seen_of_others(loaded: Loaded, monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    """What the network sees of the other places, on a floor."""
    seen = []

    def noted(scene: Scene, _: Loaded) -> np.ndarray:
        seen.append(scene.places[:, OTHERS].copy())
        return -scene.costs

    monkeypatch.setattr("indoor_explorers.learners.places.pilot.values", noted)
    world = world_on_a_floor()
    pilot = PlacesPilot(world.briefing(0, 0), loaded)
    pilot.act(world.view(0, 0))
    return seen[0]


def test_it_flies_the_shipped_weights_or_those_of_a_training(tmp_path: Path) -> None:
    shipped = make_policy("dddqn-places")
    assert shipped == DddqnPlaces()
    assert shipped.seen_maps() == {"training": ["floors/train", "dungeons/train"]}
    assert set(shipped.provenance()) == {"pocket_weights", "weights_sha256"}
    write_weights(tmp_path / "places.safetensors", load_weights(SHIPPED))
    trained = make_policy(f"dddqn-places:{tmp_path}")
    assert trained == DddqnPlaces(weights=str(tmp_path))
    assert trained.provenance() == shipped.provenance()
    assert trained.seen_maps() == {"training": ["floors/train", "dungeons/train"]}
    with pytest.raises(InputError, match="expected a safetensors file, found none"):
        DddqnPlaces(weights=str(tmp_path / "no"))


def test_lookouts_are_as_in_the_training_unless_others_are_asked_for(tmp_path: Path) -> None:
    briefing = world_on_a_floor().briefing(0, 0)
    write_weights(tmp_path / "places.safetensors", load_weights(SHIPPED)._replace(lookouts=8))

    def lookouts(**parameters: Any) -> int:
        pilot = DddqnPlaces(**parameters).pilot(briefing)
        assert isinstance(pilot, PlacesPilot)
        return pilot._loaded.lookouts

    assert [lookouts(), lookouts(lookouts=4)] == [0, 4]
    assert [lookouts(weights=str(tmp_path)), lookouts(weights=str(tmp_path), lookouts=0)] == [8, 0]
    with pytest.raises(InputError, match="expected lookouts of at least 0, got -1"):
        DddqnPlaces(lookouts=-1)
    with pytest.raises(InputError, match="expected sector of at least 0, got None"):
        DddqnPlaces(sector=None)  # type: ignore[arg-type]  # None only where it is the default


def test_without_the_others_they_are_not_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    loaded = Loaded(no_weights(), 1.0, guess=True, others=True)
    assert seen_of_others(loaded, monkeypatch).any()
    assert not seen_of_others(loaded._replace(others=False), monkeypatch).any()


def test_a_choice_is_kept_for_a_lidar_range() -> None:
    world = world_on_a_floor()
    assert pilot_of(world).replan_period == round(world.scenario.lidar.range)
