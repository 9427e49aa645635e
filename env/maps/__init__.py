"""Maps: generators, file readers and the bundled office."""

from indoor_explorers.env.maps.floorplan import Floorplan

__all__ = ["Floorplan"]
