from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.grid.levels import plane_of
from indoor_explorers.planners.toolbox.frontiers.clusters import frontier_clusters
from indoor_explorers.planners.toolbox.networks.tensors import write_tensors
from indoor_explorers.planners.toolbox.networks.weights_file import write_weights_file
from indoor_explorers.planners.toolbox.pockets import estimates
from indoor_explorers.planners.toolbox.pockets.estimates import (
    DEFAULT_FILES,
    SHIPPED,
    SHIPPED_LEVELS,
    EstimateFiles,
    PocketEstimator,
    estimates_from,
    load_weights,
)
from indoor_explorers.planners.toolbox.pockets.network import (
    OUTPUTS,
    THRESHOLDS,
    NetworkWeights,
    outputs,
    shapes,
)


def office(known: int = 40) -> np.ndarray:
    """A corridor with rooms on both sides, known up to a column."""
    belief = np.full((21, 60), 2, np.uint8)
    belief[9:12, 1:59] = 1
    for col in range(1, 55, 9):
        belief[1:8, col : col + 8] = belief[13:20, col : col + 8] = 1
        belief[8, col + 3] = belief[12, col + 3] = 1
    belief[:, known:] = 0
    belief[1:8, 1:9] = 0
    return belief


def test_probabilities_fall_and_expected_sizes_are_their_sum() -> None:
    logits = np.linspace(2.0, -3.0, len(THRESHOLDS), dtype=np.float32)
    logits[4] = 5.0  # a larger pocket cannot be more likely
    found = estimates_from(np.append(logits, np.log1p(7.0))[None].astype(np.float32))
    assert (np.diff(found.tails[0]) <= 0).all()
    places = np.log1p(np.arange(THRESHOLDS[-1]))
    by_cells = np.interp(places, np.log1p(THRESHOLDS), found.tails[0]).sum() + 400.0 * found.tails[0, -1]
    assert found.sizes[0] == pytest.approx(by_cells)
    assert found.depths[0] == pytest.approx(7.0)


def test_a_corridor_that_goes_on_hides_more_than_a_corner() -> None:
    belief = office()
    belief[9, 16] = 0  # a cell of the corridor, between known ones
    clusters = frontier_clusters(belief, 10.0)
    sizes = PocketEstimator(10.0).estimate(belief, clusters).sizes
    columns = clusters.cells[clusters.ends[:-1]] % belief.shape[1]
    assert sizes[columns == 39].max() > 20.0 * sizes[(columns > 12) & (columns < 20)].max()


def test_what_looks_the_same_is_not_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def counting(fine: np.ndarray, coarse: np.ndarray, numbers: np.ndarray, weights: NetworkWeights) -> np.ndarray:
        asked.append(len(fine))
        return outputs(fine, coarse, numbers, weights)

    monkeypatch.setattr(estimates, "outputs", counting)
    estimator = PocketEstimator(10.0)
    before, after = office(40), office(41)
    first = estimator.estimate(before, frontier_clusters(before, 10.0))
    again = estimator.estimate(before, frontier_clusters(before, 10.0))
    assert asked == [len(first.sizes)]
    np.testing.assert_array_equal(first.tails, again.tails)
    clusters = frontier_clusters(after, 10.0)
    third = estimator.estimate(after, clusters)
    assert 0 < asked[1] < len(first.sizes)
    fresh = PocketEstimator(10.0).estimate(after, clusters)
    np.testing.assert_allclose(third.tails, fresh.tails, atol=0.2)


def test_a_map_without_frontiers_has_no_estimates() -> None:
    belief = np.ones((5, 5), np.uint8)
    assert PocketEstimator(3.0).estimate(belief, frontier_clusters(belief, 3.0)).sizes.shape == (0,)


def test_shipped_weights_tell_how_they_were_made() -> None:
    seen = {"training": ["floors/train", "dungeons/train"]}
    for path, command, maps in (
        (SHIPPED, "python -m indoor_explorers.learners.pockets ", seen),
        (SHIPPED_LEVELS, "indoor-explorers train --learner pockets --set levels=true ", {}),
    ):
        about = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        assert about["command"].startswith(command)
        assert about.get("seen_maps", {}) == maps
        assert len(about["commit"]) == 40


def test_weights_are_for_plain_maps_or_for_levels() -> None:
    """Either kind is refused in place of the other, and estimates over levels are asked for by name."""
    assert EstimateFiles.named() == DEFAULT_FILES == EstimateFiles(SHIPPED, None)
    assert EstimateFiles.named(level_weights="shipped") == EstimateFiles(SHIPPED, SHIPPED_LEVELS)
    with pytest.raises(InputError, match="expected estimates for plain maps, got those for maps of several levels"):
        EstimateFiles.named(str(SHIPPED_LEVELS))
    with pytest.raises(InputError, match="expected estimates for maps of several levels, got those for plain maps"):
        EstimateFiles.named(level_weights=str(SHIPPED))
    with pytest.raises(InputError, match="found none"):
        EstimateFiles.named(level_weights="missing.safetensors")


def test_a_storey_below_a_hatch_hides_more_than_a_niche() -> None:
    """Over levels, what may be behind a frontier is judged from the levels around it."""
    volume = np.full((5, 24, 24), 2, np.uint8)
    volume[3:, 1:23, 1:23] = 1
    volume[2, 5, 5] = 1  # the hatch; nothing below it is known
    volume[:2, 1:23, 1:23] = 0
    volume[3:, 18, 22] = (0, 2)
    rise = volume.shape[1] + 1
    belief = plane_of(volume)
    clusters = frontier_clusters(belief, 6.0, rise)
    sizes = PocketEstimator(6.0, path=SHIPPED_LEVELS, rise=rise).estimate(belief, clusters).sizes
    levels = clusters.cells[clusters.ends[:-1]] // volume.shape[2] // rise
    assert sizes[levels == 2].max() > 10.0 * sizes[levels == 3].max()


def test_other_weights_are_refused(tmp_path: Path) -> None:
    arrays = {name: np.zeros(shape, np.float32) for name, shape in shapes().items()}
    write_tensors(tmp_path / "v0-2-0.safetensors", arrays)
    assert load_weights(tmp_path / "v0-2-0.safetensors").out.shape[1] == OUTPUTS
    write_weights_file(tmp_path / "w.safetensors", arrays | {"out.bias": np.zeros(3, np.float32)}, {})
    with pytest.raises(InputError, match=r"of the pocket network with 'out.bias' of shape \(19,\), got .* \(3,\)"):
        load_weights(tmp_path / "w.safetensors")
    with pytest.raises(InputError, match="expected a safetensors file, found none"):
        load_weights(tmp_path / "none.safetensors")
