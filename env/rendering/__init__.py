"""Pictures of an episode: what to draw, how it looks, a window to see it in, and files to keep it in."""

from indoor_explorers.env.rendering.painter import paint, percent
from indoor_explorers.env.rendering.scene import Scene, Trails, scene_of

__all__ = ["Scene", "Trails", "paint", "percent", "scene_of"]
