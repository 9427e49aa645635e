"""Settings that the tests of the thesis's learner share."""

from pathlib import Path

from indoor_explorers.env import PRESETS, Scenario
from indoor_explorers.learners.sessions.networks import network_arrays
from indoor_explorers.learners.thesis.config import TrainingConfig
from indoor_explorers.learners.thesis.inference import ImageFormat, write_weights
from indoor_explorers.learners.thesis.learner import new_network

#: What the thesis's network sees, and what the mended one does.
THESIS, MENDED_FORMAT = ImageFormat(16, 16, 1, False), ImageFormat(16, 16, 4, True)
CENTRED = ImageFormat(31, 31, 4, True, True)
#: A training of a second or two.
TINY = TrainingConfig(
    episodes=12,
    environments=2,
    batch=4,
    target_every=50,
    memory=60,
    evaluation_every=6,
    evaluation_episodes=2,
    checkpoint_every=4,
)


def short(name: str, budget: int = 25) -> Scenario:
    """A preset with a short budget; a move into a wall ends an episode, so most are shorter still."""
    return PRESETS[name].with_settings({"budget": budget})


def write_network(path: Path, seed: int, image_format: ImageFormat = THESIS) -> str:
    """Write the weights of an untrained network."""
    network = new_network(image_format, "actions", seed)
    write_weights(path, network_arrays(network), image_format)
    return str(path)
