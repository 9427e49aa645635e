"""The surface of a map of several levels: obstacle voxels that share a face with free voxels that count."""

from __future__ import annotations

from indoor_explorers.env import UNKNOWN, World
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.levels import Levels, plane_of


def surface_of(world: World, episode: int) -> Mask:
    """Return the mask (H, W) of the surface of an episode's map, in the plane of its levels."""
    from scipy import ndimage  # here, since it takes long to import

    counted = world.state.counts[episode]
    free = Levels.of(counted.shape, world.scenario.map.level_count).volume(counted)
    return plane_of(ndimage.binary_dilation(free) & ~free, False)


def seen_share(world: World, episode: int, surface: Mask) -> float:
    """Return the share of an episode's surface that the team's map shows; 1 where there is none."""
    seen = world.state.union[episode][surface] != UNKNOWN
    return float(seen.mean()) if seen.size else 1.0
