"""Which of a simulator's maps a command flies."""

from __future__ import annotations

from collections.abc import Sequence

from indoor_explorers.env.errors import InputError, did_you_mean


def asked_maps(wanted: Sequence[str], names: Sequence[str]) -> list[str]:
    """Return names of map files in the simulator's order: all, the first few for a number, or some by name.

    Raises:
        InputError: there is no such map.

    """
    if len(wanted) == 1 and wanted[0].isdecimal() and 0 < int(wanted[0]) <= len(names):
        return list(names[: int(wanted[0])])
    named = {name.removesuffix(".png"): name for name in names}
    for each in wanted:
        if each.removesuffix(".png") not in named or (each.isdecimal() and len(wanted) == 1):
            known = did_you_mean(each, names)
            raise InputError(
                f"--maps: expected a number up to {len(names)} or names such as {names[0]}, got {each!r}{known}"
            )
    return [named[each.removesuffix(".png")] for each in wanted] or list(names)
