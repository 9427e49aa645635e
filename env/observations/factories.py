"""Observations by name, compositions of observations, and encoders for a batch of episodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from indoor_explorers.env.errors import InputError, did_you_mean
from indoor_explorers.env.observations.base import Encoder, Observation, Views, row_of
from indoor_explorers.env.observations.coarse import Coarse
from indoor_explorers.env.observations.crop import NEARBY, Crop
from indoor_explorers.env.observations.planes import PLANES, Channels, Occupancy, ThesisImage
from indoor_explorers.env.observations.status import Heading, Legal, Status
from indoor_explorers.env.observations.wrappers import FlatEncoder, PartsEncoder, StackedEncoder
from indoor_explorers.env.policies.view import Briefing

#: Name of the action mask among the parts of an observation.
MASK = "action_mask"


@dataclass(frozen=True)
class Parts:
    """A dict observation of named observations; parts that are dicts contribute their own names."""

    of: Mapping[str, Observation]
    """Name and observation of each part."""

    def __post_init__(self) -> None:
        if not isinstance(self.of, Mapping) or not self.of:
            raise InputError(f"expected a mapping of names to observations, got {self.of!r}")

    def __call__(self, briefing: Briefing) -> PartsEncoder:
        """Make the encoder of one UAV."""
        return PartsEncoder({name: make_encoder(part, briefing) for name, part in self.of.items()})


@dataclass(frozen=True, kw_only=True)
class Egocentric:
    """A dict observation whose shapes are the same on maps of any size, for teams of any size.

    Its parts are ``crop``, ``coarse`` and ``status``: see :class:`Crop`, :class:`Coarse` and :class:`Status`.
    """

    side: int = 15
    """Cells along a side of the crop; odd."""
    planes: tuple[str, ...] = NEARBY
    """Planes of the crop."""
    zones: int = 12
    """Zones along a side of the coarse map."""
    centred: bool = True
    """Whether the coarse map lies around the UAV; else it lies over the map."""
    base: bool = False
    """Whether the status tells of the home base."""

    def __post_init__(self) -> None:
        self._parts()

    def __call__(self, briefing: Briefing) -> PartsEncoder:
        """Make the encoder of one UAV."""
        return self._parts()(briefing)

    def _parts(self) -> Parts:
        crop = Crop(side=self.side, planes=self.planes)
        return Parts(
            {"coarse": Coarse(zones=self.zones, centred=self.centred), "crop": crop, "status": Status(base=self.base)}
        )


@dataclass(frozen=True)
class Masked:
    """A dict observation that also contains the action mask, beside the observation or beside its parts."""

    of: Observation
    """The observation without a mask."""
    name: str = "observation"
    """Key of an observation that is no dict: PettingZoo uses ``observation``, RLlib's masking ``observations``."""

    def __call__(self, briefing: Briefing) -> PartsEncoder:
        """Make the encoder of one UAV."""
        return Parts({self.name: self.of, MASK: Legal()})(briefing)


@dataclass(frozen=True)
class Flat:
    """One float32 vector of all the numbers of an observation, bytes scaled to 0 to 1."""

    of: Observation
    """The observation to flatten."""

    def __call__(self, briefing: Briefing) -> FlatEncoder:
        """Make the encoder of one UAV."""
        return FlatEncoder(make_encoder(self.of, briefing))


@dataclass(frozen=True)
class Stacked:
    """The last few observations of an episode, oldest first, see :class:`StackedEncoder`."""

    of: Observation
    """The observation to stack."""
    depth: int = 4
    """Number of stacked observations."""

    def __post_init__(self) -> None:
        if not isinstance(self.depth, int) or self.depth < 1:
            raise InputError(f"expected depth to be a number of observations from 1, got {self.depth!r}")

    def __call__(self, briefing: Briefing) -> StackedEncoder:
        """Make the encoder of one UAV."""
        inner = make_encoder(self.of, briefing)
        if MASK in getattr(inner.space, "spaces", ()):
            raise InputError(
                "expected an observation without a mask to stack, got a masked one; use Masked(Stacked(...))"
            )
        return StackedEncoder(inner, self.depth)


#: Observations by name.
OBSERVATIONS: Mapping[str, Callable[[Briefing], Encoder]] = {
    "channels": Channels(),
    "thesis": ThesisImage(),
    "egocentric": Egocentric(),
    "egocentric-flat": Flat(Egocentric()),
    "occupancy": Occupancy(),
    "heading": Heading(),
}


def make_encoder(observation: Observation, briefing: Briefing) -> Encoder:
    """Return the encoder of an observation, given by name or factory, for one UAV.

    Raises:
        InputError: no observation or plane has that name, or it is neither a name nor a factory of encoders.

    """
    if not isinstance(observation, str):
        return _made(observation, briefing)
    if observation in OBSERVATIONS:
        return OBSERVATIONS[observation](briefing)
    planes = observation.split("+")
    for plane in planes:
        if plane not in PLANES:
            known = PLANES if len(planes) > 1 else (*OBSERVATIONS, *PLANES)
            raise InputError(f"unknown observation {plane!r}{did_you_mean(plane, known)}")
    return Channels(planes=planes)(briefing)


def _made(factory: Callable[[Briefing], Encoder], briefing: Briefing) -> Encoder:
    encoder = factory(briefing) if callable(factory) else None
    if not isinstance(encoder, Encoder):
        raise InputError(
            f"expected a name, or a factory of an Encoder from a briefing such as Egocentric(side=21), got {factory!r}"
        )
    return encoder


class BatchedEncoder:
    """Encode B episodes of lone UAVs, each as an encoder of its own would."""

    def __init__(self, observation: Observation, briefing: Briefing, count: int) -> None:
        first = make_encoder(observation, briefing)
        self.space = first.space
        self.shared = first if first.stateless else None
        """The encoder of all episodes, when they share one."""
        self._own = [first] + [make_encoder(observation, briefing) for _ in range(0 if first.stateless else count - 1)]

    def of(self, b: int) -> Encoder | None:
        """Return the encoder of the episode in place ``b`` of the batch; None where all share one without a memory."""
        return self._own[b] if self.shared is None else None

    def encode(self, views: Views, out: Any) -> None:
        """Overwrite all of ``out``, arrays (B, ...)."""
        if self.shared is not None:
            self.shared.encode_batch(views, out)
        else:
            for b in range(len(self._own)):
                self.encode_one(b, views, out)

    def encode_one(self, b: int, views: Views, out: Any) -> None:
        """Overwrite entry ``b`` of ``out``."""
        encoder = self._own[b] if self.shared is None else self.shared
        encoder.encode(views.view(b), row_of(out, b))
