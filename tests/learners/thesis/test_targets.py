"""Targets worked out by hand, as they are and as they should be."""

import pytest
import torch
from torch import nn

from indoor_explorers.learners.thesis.learner import td_loss, td_targets
from indoor_explorers.learners.thesis.replay import ThesisBatch


class Table(nn.Module):
    """A network whose values are rows of a table: that of the image's only number."""

    def __init__(self, rows):
        super().__init__()
        self.rows = nn.Parameter(torch.tensor(rows))

    def forward(self, image_BKHW):
        return self.rows[image_BKHW.flatten(1)[:, 0].long()]


ONLINE = Table([[1.0, 2.0, 0.0, 0.0], [5.0, 1.0, 9.0, 2.0]])
TARGET = Table([[10.0, 20.0, 30.0, 40.0], [50.0, 60.0, 70.0, 80.0]])
#: Three moves: to state 1; to state 0; to state 1, which ends the episode.
BATCH = ThesisBatch(
    torch.tensor([0.0, 1.0, 0.0]).view(3, 1, 1, 1),
    torch.tensor([1, 3, 0]),
    torch.tensor([0.5, -10.0, -400.0]),
    torch.tensor([False, False, True]),
    torch.tensor([1.0, 0.0, 1.0]).view(3, 1, 1, 1),
)


@pytest.mark.parametrize(("terminal", "last"), [("zero", 0.0), ("reward", -400.0)])
def test_the_online_network_chooses_and_the_target_network_values(terminal, last):
    found = td_targets(ONLINE, TARGET, BATCH, 0.9, terminal)
    assert found.tolist() == pytest.approx([0.5 + 0.9 * 70.0, -10.0 + 0.9 * 20.0, last])


def test_the_loss_is_the_mean_over_all_moves_of_which_one_is_wrong():
    loss = td_loss(ONLINE, TARGET, BATCH, 0.9, "reward")
    wrong = [2.0 - 63.5, 2.0 - 8.0, 1.0 + 400.0]
    assert loss.item() == pytest.approx(sum(each**2 for each in wrong) / 12)
    loss.backward()
    assert ONLINE.rows.grad.tolist()[1] == pytest.approx([0.0, 0.0, 0.0, 2 * wrong[1] / 12])
    assert TARGET.rows.grad is None
