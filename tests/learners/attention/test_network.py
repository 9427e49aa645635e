from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from indoor_explorers.env import InputError
from indoor_explorers.learners.attention.graph import FEATURES, Graph, GraphSettings
from indoor_explorers.learners.attention.model import CriticNet, PolicyNet, batch_of, weights_of
from indoor_explorers.learners.attention.network import Loaded, NetworkSettings, load_weights, scores, write_weights
from indoor_explorers.learners.attention.policy import probabilities
from indoor_explorers.learners.attention.sparse import attention

SMALL = NetworkSettings(units=16, heads=2, layers=2)


def random_graph(nodes: int, seed: int = 0, edges: int = 5) -> Graph:
    rng = np.random.default_rng(seed)
    neighbours = np.stack([rng.permutation(np.delete(np.arange(nodes), n))[:edges] for n in range(nodes)])
    neighbours[:, -1] = -1
    return Graph(np.arange(nodes, dtype=np.int32), rng.normal(size=(nodes, FEATURES)).astype(np.float32), neighbours)


@pytest.fixture(name="policy")
def _policy() -> PolicyNet:
    torch.manual_seed(1)
    return PolicyNet(FEATURES, SMALL)


def loaded(policy: PolicyNet) -> Loaded:
    return Loaded(weights_of(policy), SMALL, GraphSettings())


def log_p(policy: PolicyNet, *graphs: Graph) -> np.ndarray:
    args = zip(*((g.features, g.neighbours, g.neighbours[0]) for g in graphs), strict=True)
    return np.asarray(policy(batch_of(*args)).detach())


def test_it_flies_what_torch_trains(policy: PolicyNet) -> None:
    graph = random_graph(9)
    there = graph.neighbours[0] >= 0
    flown = np.log(probabilities(scores(graph, loaded(policy)), there)[there])
    np.testing.assert_allclose(flown, log_p(policy, graph)[0, there], atol=1e-5)


def test_padding_changes_nothing_and_absent_neighbours_are_never_chosen(policy: PolicyNet) -> None:
    small, large = random_graph(7), random_graph(30, 1)
    both = log_p(policy, small, large)
    np.testing.assert_allclose(both[0], log_p(policy, small)[0], atol=1e-5)
    assert (both[:, -1] < -1e6).all()
    assert scores(small, loaded(policy))[-1] == -np.inf
    critic = CriticNet(FEATURES, SMALL)
    batch = batch_of([small.features], [small.neighbours], [small.neighbours[0]])
    assert critic(batch)[0, -1] == 0.0


def test_a_permutation_of_the_nodes_does_not_change_the_choice(policy: PolicyNet) -> None:
    graph = random_graph(12)
    order = np.concatenate([[0], 1 + np.random.default_rng(2).permutation(11)])
    number = np.argsort(order)
    neighbours = np.where(graph.neighbours >= 0, number[graph.neighbours], -1)[order]
    mixed = Graph(graph.cells[order], graph.features[order], neighbours)
    np.testing.assert_allclose(scores(mixed, loaded(policy)), scores(graph, loaded(policy)), atol=1e-5)


def test_attention_follows_edges_alone(policy: PolicyNet) -> None:
    """Without the decoder, a change reaches as many edges as there are layers."""
    graph = random_graph(9)
    chain = np.full((9, 2), -1)
    chain[1:, 0], chain[:-1, 1] = np.arange(8), np.arange(1, 9)
    far, further = graph.features.copy(), graph.features.copy()
    far[2], further[3] = 9.0, 9.0
    batches = [batch_of([each], [chain], [chain[0]]) for each in (graph.features, far, further)]
    encoded = []
    for batch in batches:
        x = policy.embed(batch.features)
        for layer in policy.layers:
            x = layer(x, x, batch.near)
        encoded.append(x[0].detach())
    assert not torch.equal(encoded[0], encoded[1])
    assert torch.equal(encoded[0], encoded[2])


def test_attention_to_some_rows_is_that_of_torch() -> None:
    torch.manual_seed(3)
    query, pair = torch.randn(7, 16, requires_grad=True), torch.randn(20, 32, requires_grad=True)
    near = torch.stack([torch.randperm(20, dtype=torch.int32)[:5] for _ in range(7)])
    near[2, 1:] = near[4, 3] = -1
    mask = torch.stack([(near == row).any(dim=1) for row in range(20)], dim=1)
    q, k, v = (part.unflatten(-1, (4, 4)).transpose(0, 1) for part in (query, *pair.chunk(2, dim=-1)))
    expected = torch.nn.functional.scaled_dot_product_attention(q, k, v, attn_mask=mask).transpose(0, 1).flatten(1)
    found = attention(query, pair, near, 4)
    np.testing.assert_allclose(found.detach(), expected.detach(), atol=1e-5)
    weight = torch.randn(7, 16)
    gradients = [torch.autograd.grad((each * weight).sum(), (query, pair)) for each in (found, expected)]
    for ours, theirs in zip(*gradients, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-5)


def test_heads_divide_the_units() -> None:
    with pytest.raises(ValueError, match="units is 30, no multiple of heads, 4; change one of them"):
        NetworkSettings(units=30)


def test_weights_files_hold_their_settings(policy: PolicyNet, tmp_path: Path) -> None:
    path = tmp_path / "weights.safetensors"
    write_weights(path, loaded(policy))
    read = load_weights(path)
    assert read[1:] == (SMALL, GraphSettings())
    assert all(np.array_equal(read.weights[name], array) for name, array in weights_of(policy).items())
    write_weights(path, loaded(policy)._replace(network=NetworkSettings()))
    with pytest.raises(InputError, match="expected weights of attention-sac"):
        load_weights(path)
