"""Pictures of an episode: their content and style, a window, and files."""

from indoor_explorers.env.rendering.painter import floored_percent, paint
from indoor_explorers.env.rendering.painter import floored_percent as percent
from indoor_explorers.env.rendering.scene import Scene, Trails, scene_of

__all__ = ["Scene", "Trails", "floored_percent", "paint", "percent", "scene_of"]
