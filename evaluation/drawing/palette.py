"""The styles of policies: colours that colour-blind readers can tell apart, dashes and markers.

The colours are those of Okabe and Ito (2008) without the yellow, which is hardly visible on white, each with a
lighter variant for dark backgrounds, and an indigo. Policies that know the map are black and chance is grey, whatever
else is drawn. The shipped ones always look the same, so that the figures of two comparisons agree; others get the
least used colours. No two of the first 42 share colour and dash.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from typing import Any, NamedTuple

#: (on white, on black), by name of the hue: blue, vermillion, green, purple, orange, sky, grey, indigo.
COLOURS = (
    ("#0072b2", "#4aa8e0"),
    ("#d55e00", "#f2854a"),
    ("#008f68", "#2fc597"),
    ("#b8578e", "#e093be"),
    ("#c98a00", "#f0b429"),
    ("#3d9fd6", "#8fd0f5"),
    ("#6b6b6b", "#b5b5b5"),
    ("#3b2f8f", "#8c7bff"),
)
#: Index of the colour of chance.
GREY = 6
#: The shipped policies by the index of their colour; those that are often compared differ in it.
SHIPPED = {
    0: ("frontier", "frontier-joint", "rrt-nbv", "frontier-hungarian", "sgba"),
    1: ("frontier-nearest", "frontier-burgard", "hedac", "frontier-mrtsp", "cover-tour", "frontier-octree"),
    2: ("dddqn", "dddqn-places", "pomdp", "prior-tour", "return-to-base", "dddqn-reports"),
    3: ("pso", "frontier-advantage", "pso-robots", "prm-tour", "rrt-predictive", "level-by-level"),
    4: ("rrt", "rrt-aep", "aco", "frontier-tour", "dddqn-thesis", "attention-sac"),
    5: ("frontier-predictive", "horizon", "frontier-minpos", "gso", "pso-predictive", "camera-paths"),
    7: ("frontier-latency", "tours", "frontier-utility", "bat", "rrt-frontier", "loop-closing"),
}
#: The colour of policies that know the map, last in the order.
BLACK = ("#1b1f24", "#eef0f2")
#: All colours by :attr:`PolicyStyle.colour`.
INKS = (*COLOURS, BLACK)
#: On and off lengths; empty is a solid line.
DASHES: tuple[tuple[float, ...], ...] = ((), (7, 3), (2, 2), (9, 3, 2, 3), (4, 2), (9, 3, 2, 3, 2, 3))
#: Plotly's name and matplotlib's letter.
MARKERS = (
    ("circle", "o"),
    ("square", "s"),
    ("diamond", "D"),
    ("triangle-up", "^"),
    ("cross", "P"),
    ("x", "X"),
    ("triangle-down", "v"),
    ("star", "*"),
)
#: The same markers as SVG paths around (0, 0), about 7 wide.
MARKER_PATHS = (
    "M-3.2 0a3.2 3.2 0 1 0 6.4 0a3.2 3.2 0 1 0-6.4 0z",
    "M-3-3h6v6h-6z",
    "M0-4 4 0 0 4-4 0z",
    "M0-4 3.8 3h-7.6z",
    "M-1.3-3.9h2.6v2.6h2.6v2.6h-2.6v2.6h-2.6v-2.6h-2.6v-2.6h2.6z",
    "M-3.7-1.8-1.8-3.7 0-1.9 1.8-3.7 3.7-1.8 1.9 0 3.7 1.8 1.8 3.7 0 1.9-1.8 3.7-3.7 1.8-1.9 0z",
    "M0 4-3.8-3h7.6z",
    "M0-4.4 1.1-1.4 4.2-1.3 1.7.6 2.6 3.6 0 1.8-2.6 3.6-1.7.6-4.2-1.3-1.1-1.4z",
)


def crowded(policies: int) -> bool:
    """Return whether there are more policies than hues, so that bands of curves would overlap too much."""
    return policies > len(SHIPPED)


class PolicyStyle(NamedTuple):
    """The style of one policy, as indices into the cycles above."""

    colour: int
    dash: int
    marker: int

    @property
    def hex(self) -> str:
        """The colour on white."""
        return INKS[self.colour][0]

    @property
    def variable(self) -> str:
        """The page's CSS variable of the colour, which follows the theme."""
        return f"var(--c{self.colour})"

    @property
    def pattern(self) -> str:
        """The dash as SVG and plotly write it, ``solid`` for none."""
        return ",".join(f"{length:g}px" for length in DASHES[self.dash]) or "solid"


#: The style of each policy by name.
Styles = Mapping[str, PolicyStyle]


def _dashes(row: int) -> list[int]:
    """Return the dashes of the policies of one colour, in their order."""
    turning = len(DASHES) - 1
    return [*((row + place) % turning for place in range(turning)), turning]


#: The styles of the shipped policies.
_FIXED = {
    name: PolicyStyle(colour, _dashes(row)[place], (row + place) % len(MARKERS))
    for row, (colour, names) in enumerate(SHIPPED.items())
    for place, name in enumerate(names)
}


def policy_styles(policies: Iterable[str]) -> dict[str, PolicyStyle]:
    """Return the style of each policy: shipped policies have fixed styles, others the least used colours.

    A mapping also gives facts about each policy: privileged policies are black, those that plan for nothing grey.
    """
    facts = dict(policies) if isinstance(policies, Mapping) else {}
    names = list(policies)
    known = [name for name in names if _fact(facts.get(name), "privileged")]
    chance = [name for name in names if _fact(facts.get(name), "plans_for") == "nothing" and name not in known]
    styles = {name: PolicyStyle(GREY, (k + 2) % len(DASHES), 5) for k, name in enumerate(chance)}
    styles |= {name: PolicyStyle(len(COLOURS), k % len(DASHES), 7 - k % 8) for k, name in enumerate(known)}
    styles |= {name: _FIXED[name] for name in names if name in _FIXED and name not in styles}
    for name in names:
        if name not in styles:
            styles[name] = _another(styles.values())
    return {name: styles[name] for name in names}


def styles_beside(styles: Styles, names: Iterable[str]) -> dict[str, PolicyStyle]:
    """Return styles of further names; those of the policies that are drawn anyway stay as they are."""
    found = dict(styles)
    for name in names:
        found[name] = found.get(name) or _another(found.values())
    return {name: found[name] for name in found if name not in styles}


def _another(used: Collection[PolicyStyle]) -> PolicyStyle:
    """Return a style in the colour that fewest have, with a dash that none of them has, if there is one."""
    count = Counter(style.colour for style in used)
    row, colour = min(enumerate(SHIPPED), key=lambda each: count[each[1]])
    taken = {style.dash for style in used if style.colour == colour}
    dashes = _dashes(row)
    dash = next((each for each in dashes if each not in taken), dashes[count[colour] % len(DASHES)])
    return PolicyStyle(colour, dash, len(used) % len(MARKERS))


def _fact(about: object, key: str) -> Any:
    return about.get(key) if isinstance(about, Mapping) else None
