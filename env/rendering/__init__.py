"""Pictures of an episode: what to draw, how it looks, a window to see it in, and files to keep it in."""

from indoor_explorers.env.rendering.painter import paint
from indoor_explorers.env.rendering.scene import Scene, Trails, scene_of

__all__ = ["Scene", "Trails", "paint", "scene_of"]
