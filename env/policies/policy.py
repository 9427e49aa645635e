"""The policy interface: shared knowledge (``Policy``), the controller of one UAV in one episode (``Pilot``)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.errors import InputError, one_line, shown
from indoor_explorers.env.policies.view import Briefing, Message, View


def is_action(action: object, count: int = 5) -> TypeGuard[int]:
    """Tell whether a pilot's answer is one of ``count`` actions: an integer from 0, and no bool."""
    return isinstance(action, (int, np.integer)) and not isinstance(action, bool) and bool(0 <= action < count)


def no_action(answer: object, count: int = 5, names: str = "") -> str:
    """Say what was expected, with the ``names`` of the actions, and what was received that is none of them."""
    span, kind = f"from 0 to {count - 1}{names}", one_line(type(answer).__name__)
    if answer is None or (isinstance(answer, (int, np.integer)) and not isinstance(answer, bool)):
        return f"expected an action {span}, got {shown(answer)}"
    return f"expected an int {span}, got the {kind} {shown(answer)}"


def integers(actions: ArrayLike, count: int = 5) -> NDArray[np.integer[Any]]:
    """Return numbers as an array, of which those that are no integers are refused; their range is not checked.

    Raises:
        InputError: there are others, such as floats and bools.

    """
    try:
        array = np.asarray(actions)
    except (TypeError, ValueError):  # lists of different lengths
        raise InputError(no_action(actions, count)) from None
    if array.dtype.kind not in "iu":
        for each in array.reshape(-1).tolist():
            if not is_action(each, count):
                raise InputError(no_action(each, count))
    return array


#: Values of :attr:`Policy.plans_for`.
ALL_CELLS, TRAINED_GOAL = "all cells", "the goal of its training"


class Pilot(ABC):
    """Choose the actions of one UAV in one episode."""

    message: Message = None
    """Sent to the teammates in radio range after the move: None or at most 16 numbers."""

    done: bool = False
    """Whether this UAV would end its mission now, as the map seems complete enough to it. It flies on all the same;
    results tell what stopping would have cost in coverage and saved in steps."""

    @abstractmethod
    def act(self, view: View) -> int:
        """Choose one of the five actions from what this UAV knows; where ``view.heading`` is not None, of six."""

    def tally(self) -> dict[str, float]:
        """Return named figures about this episode for the results, such as a share of guarded decisions."""
        return {}


class Policy(ABC):
    """Hold what all UAVs share: parameters and weights. Immutable and picklable.

    Make subclasses frozen keyword-only dataclasses: their fields are then stored with the results.
    """

    privileged: ClassVar[bool] = False
    """True for a reference policy that gets the true map; results mark it."""

    uses_generator: ClassVar[bool] = False
    """True for a policy that reads ``briefing.generator``, which any policy may; results mark it."""

    plans_for: ClassVar[str] = ""
    """The coverage that it plans for, in a few words, such as "all cells"; empty if it does not say. Results tell where
    policies plan for different coverage."""

    batched: ClassVar[bool] = False
    """True if :meth:`act` is faster for many UAVs at once than one by one, such as with one forward pass. It is then
    called for all UAVs of a batch at once, and a decision's time is its share of the batch's; otherwise it is called,
    and timed, for one UAV after the other."""

    map_shape: tuple[int, int] | None = None
    """(H, W) of the only maps that it flies, such as those of a network's training; None for any. It may be set on the
    instance. The conformance suite then flies rooms of this size and no large map."""

    @abstractmethod
    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV for one episode."""

    def provenance(self) -> dict[str, str]:
        """Return facts about this policy besides its parameters, such as a hash of its weights, for the results."""
        return {}

    def seen_seeds(self) -> Mapping[str, Sequence[range]]:
        """Return the episode seeds that the policy was trained, validated or tuned on, by use, such as "training".

        Results say where they rest on such seeds.
        """
        return {}

    def seen_maps(self) -> Mapping[str, Sequence[str]]:
        """Return the map files that the policy was trained, validated or tuned on, by use, such as "training".

        They are told by their digests, or as a part of a suite, such as "floors/train". Results warn where they rest
        on such maps.
        """
        return {}

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> Sequence[int]:
        """Return the actions of one UAV, or of many if the policy is ``batched``; each must be the same as alone.

        Pilots may belong to different episodes and must not exchange information.
        """
        return [pilot.act(view) for pilot, view in zip(pilots, views, strict=True)]
