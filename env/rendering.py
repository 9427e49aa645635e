"""A picture of one episode: the true map, dimmed where the team does not know it, and the UAVs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid import FREE, UNKNOWN
from indoor_explorers.env.state import End
from indoor_explorers.env.world import World

#: Pixels that the longer side of a picture has at least, as far as whole cells allow.
PIXELS = 512
#: RGB of (unknown, known) floor and of (unknown, known) obstacles.
FLOOR = np.array([(128, 128, 128), (255, 255, 255)], np.uint8)
OBSTACLE = np.array([(96, 96, 96), (32, 32, 32)], np.uint8)


def frame(world: World, episode: int) -> NDArray[np.uint8]:
    """Return the episode as an (H*s, W*s, 3) uint8 image, s pixels a cell; UAVs that have ended are paler."""
    state = world.state
    known = (state.union[episode] != UNKNOWN).astype(np.intp)
    image = np.where((state.truth[episode] == FREE)[..., None], FLOOR[known], OBSTACLE[known])
    colours = uav_colours(state.cell.shape[1])
    ended = state.end[episode] != End.FLYING
    colours[ended] = colours[ended] // 2 + 96
    for agent in np.argsort(~ended, kind="stable"):  # those that fly last, on top
        image[tuple(state.cell[episode, agent])] = colours[agent]
    scale = max(1, PIXELS // max(known.shape))
    return np.asarray(image.repeat(scale, axis=0).repeat(scale, axis=1))


def uav_colours(team: int) -> NDArray[np.uint8]:
    """Return (team, 3) uint8 RGB colours: hues a golden angle apart, neighbours in number far apart in hue."""
    hue = 6.0 * ((0.58 + 0.61803398875 * np.arange(team)) % 1.0)
    ramps = np.abs((hue[:, None] + np.array([0.0, 4.0, 2.0])) % 6.0 - 3.0) - 1.0
    return np.asarray(30 + 200 * np.clip(ramps, 0.0, 1.0), np.uint8)
