"""Observation encoders: the knowledge of one UAV as arrays for a learner.

An encoder reads only a :class:`~indoor_explorers.env.policies.view.View` and the briefing that it was made with. An
observation is chosen by name:

- ``channels``: all the planes of :data:`PLANES`, (7, H, W) uint8;
- some of them joined by ``+``, such as ``free+obstacle+self``, in that order;
- ``thesis``: the image of the thesis, (H, W) float32;
- ``occupancy``: the probability that each cell is occupied, (1, H, W) float32; ``heading``: the direction that the UAV
  faces, (4,) float32; both where sensors or poses err;
- ``egocentric``: a dict of a crop around the UAV, a coarse map of the whole and a few numbers, whose shapes are
  the same on maps of any size; ``egocentric-flat``: the same as one vector;

or by an object with parameters: :class:`Channels`, :class:`Crop`, :class:`Coarse`, :class:`Status`, :class:`Occupancy`,
:class:`Heading`, :class:`Egocentric`, and, composed of others or of their names, :class:`Parts`, :class:`Masked`,
:class:`Flat` and :class:`Stacked`, such as ``Flat(Stacked(Egocentric(side=21), 4))``. ``Status(base=True)`` and
``Egocentric(base=True)`` include the position of the home base and the age of the last contact with it. These objects
can be pickled and compared. Any other callable that takes a briefing and returns an :class:`Encoder` also works.
"""

from indoor_explorers.env.observations.base import Encoder, Observation, Views
from indoor_explorers.env.observations.coarse import Coarse
from indoor_explorers.env.observations.crop import Crop
from indoor_explorers.env.observations.factories import (
    OBSERVATIONS,
    Egocentric,
    Flat,
    Masked,
    Parts,
    Stacked,
    make_encoder,
)
from indoor_explorers.env.observations.planes import PLANES, Channels, Occupancy, ThesisImage
from indoor_explorers.env.observations.status import BASE_STATUS, STATUS, Heading, Legal, Status

__all__ = [
    "BASE_STATUS",
    "OBSERVATIONS",
    "PLANES",
    "STATUS",
    "Channels",
    "Coarse",
    "Crop",
    "Egocentric",
    "Encoder",
    "Flat",
    "Heading",
    "Legal",
    "Masked",
    "Observation",
    "Occupancy",
    "Parts",
    "Stacked",
    "Status",
    "ThesisImage",
    "Views",
    "make_encoder",
]
