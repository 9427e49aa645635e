"""The UAVs of a group as each of them knows them: numbers, cells and goals."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from indoor_explorers.env.grid.arrays import Cell
from indoor_explorers.env.policies.view import Mate
from indoor_explorers.planners.toolbox.navigation.teammates import told_goal


class GroupMember(NamedTuple):
    """One UAV of the group."""

    agent: int
    cell: Cell
    goal: Cell | None


def member_of(mate: Mate) -> GroupMember:
    """Return a teammate as a member, with its goal if that is recent."""
    return GroupMember(mate.agent, mate.cell, told_goal(mate))


def group_of(own: GroupMember, mates: Iterable[Mate]) -> list[GroupMember]:
    """Return a UAV and its teammates as members, by number."""
    return sorted([own, *map(member_of, mates)], key=lambda member: member.agent)
