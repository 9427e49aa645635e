"""The policy interface: shared knowledge (``Policy``), the controller of one UAV in one episode (``Pilot``)."""

from __future__ import annotations

import operator
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, SupportsIndex, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from indoor_explorers.env.errors import InputError, one_line, shown
from indoor_explorers.env.policies.explanation import Explanation
from indoor_explorers.env.policies.view import Briefing, Message, View


def checked_action(answer: object, count: int = 5, names: str = "") -> int:
    """Return an answer as an action in [0, count).

    Args:
        answer: Any object; a bool is no action.
        count: Number of actions.
        names: Their names for the error.

    Raises:
        InputError: the answer is no action.

    """
    if type(answer) is int and 0 <= answer < count:  # nearly always; all else takes longer
        return answer
    number = isinstance(answer, (int, np.integer)) and not isinstance(answer, bool)
    action = operator.index(cast("SupportsIndex", answer)) if number else -1
    if 0 <= action < count:
        return action
    span = f"from 0 to {count - 1}{names}"
    if number or answer is None:
        raise InputError(f"expected an action {span}, got {shown(answer)}")
    raise InputError(f"expected an int {span}, got the {one_line(type(answer).__name__)} {shown(answer)}")


def integers(actions: ArrayLike, count: int = 5) -> NDArray[np.integer[Any]]:
    """Return actions as an array of integers, whose range is not checked; raise :class:`InputError` for other types."""
    try:
        array = np.asarray(actions)
    except (TypeError, ValueError):  # lists of different lengths
        checked_action(actions, count)  # which it is not
        raise
    if array.dtype.kind not in "iu":
        for each in array.reshape(-1).tolist():
            checked_action(each, count)
    return array


#: Values of :attr:`Policy.plans_for`.
ALL_CELLS, TRAINED_GOAL = "all cells", "the goal of its training"


class Pilot(ABC):
    """Choose the actions of one UAV in one episode."""

    message: Message = None
    """Sent to the teammates in radio range after the move: None or at most 16 numbers."""

    done: bool = False
    """Whether this UAV would end its mission now, because its map seems complete enough. It flies on; results report
    the coverage lost and the steps saved by stopping."""

    explaining: bool = False
    """Whether to keep what :meth:`explain` needs. It is set before the first step, in flights that nobody measures."""

    @abstractmethod
    def act(self, view: View) -> int:
        """Choose one of five actions from this UAV's view; one of six if ``view.heading`` is not None."""

    def explain(self) -> Explanation | None:
        """Return why the UAV flies where it does, as of its latest action; None if the pilot cannot tell.

        It is called only where :attr:`explaining` is set. Actions must depend on neither.
        """
        return None

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
    """The coverage that the policy plans for, such as "all cells"; empty if unknown. Results report policies that plan
    for different coverage."""

    batched: ClassVar[bool] = False
    """True if :meth:`act` is faster for many UAVs at once, such as with one forward pass. It is then called for all
    UAVs of a batch, and a decision's time is its share of the call; otherwise it is called and timed for each UAV."""

    map_shape: tuple[int, int] | None = None
    """(H, W) of the only maps that the policy flies, such as those of a network's training; None for any. It may be set
    on the instance. The conformance suite then flies rooms of this size and no large map."""

    @abstractmethod
    def pilot(self, briefing: Briefing) -> Pilot:
        """Make the pilot of one UAV for one episode."""

    def provenance(self) -> dict[str, str]:
        """Return facts about this policy besides its parameters, such as a hash of its weights, for the results."""
        return {}

    def seen_seeds(self) -> Mapping[str, Sequence[range]]:
        """Return the episode seeds that the policy was trained, validated or tuned on, by use, such as "training".

        Results report evaluations on such seeds.
        """
        return {}

    def seen_maps(self) -> Mapping[str, Sequence[str]]:
        """Return the map files that the policy was trained, validated or tuned on, by use, such as "training".

        Each is a digest of a map or of a layout, or the name of a part of a suite, such as "floors/train". Results
        warn where they rest on such maps; by a digest of a layout, turned, mirrored and rescaled ones are found too.
        """
        return {}

    def act(self, pilots: Sequence[Pilot], views: Sequence[View]) -> Sequence[int]:
        """Return the actions of one UAV, or of many if the policy is ``batched``; each must be the same as alone.

        Pilots may belong to different episodes and must not exchange information.
        """
        return [pilot.act(view) for pilot, view in zip(pilots, views, strict=True)]
