"""Skeletons of floors: the corridors of bars, of L, T, U, H and Z shapes, combs, rings, deep and linked blocks."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from indoor_explorers.env.maps.generators.floors.style import Style


class Corridor(NamedTuple):
    """A rectangle of floor from (top, left) on, with rows of rooms along some of its sides; lengths in cells."""

    top: int
    left: int
    tall: int
    wide: int
    loaded: float = 1.0
    """Share of its sides with rooms, as a factor of the style's."""


class Skeleton(NamedTuple):
    """Corridors, and rectangles (top, left, tall, wide) whose gaps between rooms become rooms as well."""

    corridors: list[Corridor]
    filled: list[tuple[int, int, int, int]]


def bar(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return one corridor for about ``floor`` cells of floor."""
    return Skeleton([_across(style, 0, 0, _length(style, floor))], [])


def ell(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return two corridors that meet at their ends."""
    length = _length(style, floor)
    cut = round(length * rng.uniform(0.3, 0.7))
    wide = _either(rng, style)
    return Skeleton([_across(style, 0, 0, cut), Corridor(0, cut - wide, length - cut, wide)], [])


def tee(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return a corridor and one that leaves it at a right angle, or crosses it."""
    length = _length(style, floor)
    main = round(length * rng.uniform(0.5, 0.7))
    place = round(main * rng.uniform(0.15, 0.85))
    up = round((length - main) * (rng.uniform(0.2, 0.8) if rng.random() < 0.3 else 0.0))
    return Skeleton([_across(style, 0, 0, main), Corridor(-up, place, length - main, _either(rng, style))], [])


def comb(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return a corridor with two to four wings to one side: a U, an E or a comb."""
    length = _length(style, floor)
    pitch = 2 * style.depth + style.corridor + style.cells(rng.uniform(3.0, 14.0))
    wings = min(int(rng.choice([2, 2, 2, 3, 4])), max(2, length // (2 * pitch) + 1))
    overhang = round(rng.uniform(0, 1) * style.module) if rng.random() < 0.5 else 0
    base = (wings - 1) * pitch + style.corridor + 2 * overhang
    leg = max((length - base) // wings, 2 * style.module)
    side = _either(rng, style)
    legs = [
        Corridor(0, overhang + n * pitch, max(style.module, round(leg * rng.uniform(0.6, 1.4))), side)
        for n in range(wings)
    ]
    return Skeleton([_across(style, 0, 0, base), *legs], [])


def zigzag(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return two parallel corridors, or two in a line that are offset, and one that joins them: a Z or an H."""
    length = _length(style, floor)
    gap = min(round(length * rng.uniform(0.12, 0.35)), 4 * style.depth + style.corridor)
    one = round((length - gap) * rng.uniform(0.35, 0.65))
    other = length - gap - one
    side = _either(rng, style)
    at = round(one * rng.uniform(0.1, 0.95))
    shift = at - round(other * rng.uniform(0.05, 0.95))
    link = Corridor(0, at, gap + style.corridor, side, float(rng.choice([0.0, 0.5, 1.0])))
    return Skeleton([_across(style, 0, 0, one), _across(style, gap, shift, other), link], [])


def ring(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return corridors around a core of rooms or a courtyard, perhaps with more across it."""
    length = max(_length(style, floor), 4 * style.depth)
    court = rng.random() < 0.4
    core = round(style.depth * rng.uniform(0.7, 2.3))
    if court:
        core = 2 * style.depth + style.cells(rng.uniform(6.0, 18.0))
    core = min(max(core, 2), length // 4)
    side, along = _either(rng, style), max(length // 2 - core, core)
    more = int(rng.integers(0, 3)) if along > 6 * style.module else 0
    lefts = [0, along - side, *(round(along * rng.uniform(0.25, 0.75)) for _ in range(more))]
    out = style.cells(rng.uniform(2.0, 12.0)) if rng.random() < 0.4 else 0
    rows = [_across(style, 0, -out, along + out), _across(style, core + style.corridor, 0, along)]
    filled = [] if court else [(style.corridor, side, core, along - 2 * side)]
    return Skeleton([*rows, *(Corridor(0, left, core + 2 * style.corridor, side) for left in lefts)], filled)


def plate(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return a deep block, divided by corridors until no part is deeper than some rooms."""
    least = 2 * style.depth + style.corridor + 3
    tall = max(round((1.3 * floor * rng.uniform(0.4, 1.0)) ** 0.5), least)
    wide = max(round(1.3 * floor / tall), least)
    corridors: list[Corridor] = []
    stack = [(0, 0, tall, wide, style.corridor)]
    while stack:
        top, left, height, width, aisle = stack.pop()
        if corridors and min(height, width) <= style.depth * rng.uniform(2.2, 4.2):
            continue
        if height > width if rng.random() < 0.85 or not corridors else height <= width:
            upper = _divided(rng, style, height, aisle)
            if upper:
                corridors.append(Corridor(top + upper, left, aisle, width))
                lower = upper + aisle
                stack += [(top, left, upper, width, style.aisle)]
                stack += [(top + lower, left, height - lower, width, style.aisle)]
        elif first := _divided(rng, style, width, aisle):
            corridors.append(Corridor(top, left + first, height, aisle))
            last = first + aisle
            stack += [(top, left, height, first, style.aisle)]
            stack += [(top, left + last, height, width - last, style.aisle)]
    return Skeleton(corridors, [(0, 0, tall, wide)])


def _divided(rng: np.random.Generator, style: Style, span: int, aisle: int) -> int:
    """Return where a corridor divides a span of cells, 0 where it is too short for that."""
    most = span - style.depth - aisle
    return int(rng.integers(style.depth, most + 1)) if most >= style.depth else 0


def hub(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return an open hall with rooms around it and corridors that leave it."""
    tall, wide = (style.cells(metres) for metres in rng.uniform(5.0, 14.0, 2))
    length = max(_length(style, floor) - tall - wide, 0)
    corridors = [Corridor(0, 0, tall, wide)]
    arms = rng.permutation(4)[: int(rng.integers(1, 5))]
    for arm, share in zip(arms.tolist(), rng.dirichlet(np.full(len(arms), 3.0)).tolist(), strict=True):
        long, aisle = round(length * share), _either(rng, style)
        span = wide if arm < 2 else tall
        place = int(rng.integers(max(1, span - aisle + 1)))
        if long > style.module:
            corridors.append(
                (
                    Corridor(-long, place, long, aisle),
                    Corridor(tall, place, long, aisle),
                    Corridor(place, -long, aisle, long),
                    Corridor(place, wide, aisle, long),
                )[arm]
            )
    return Skeleton(corridors, [])


def linked(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return two blocks of other skeletons, one above the other, and a corridor that links them."""
    makers = (bar, bar, ring, tee, plate)
    share = rng.uniform(0.35, 0.65)
    blocks = [makers[int(rng.integers(len(makers)))](rng, style, round(floor * part)) for part in (share, 1.0 - share)]
    gap = 2 * style.depth + style.cells(rng.uniform(2.0, 15.0))
    low = max(one.top + one.tall for one in blocks[0].corridors)
    high = min(one.top for one in blocks[1].corridors)
    start = max((one for one in blocks[0].corridors if one.top + one.tall == low), key=lambda one: one.wide)
    stop = max((one for one in blocks[1].corridors if one.top == high), key=lambda one: one.wide)
    aisle = _either(rng, style)
    here = start.left + round(max(start.wide - aisle, 0) * rng.random())
    there = stop.left + round(max(stop.wide - aisle, 0) * rng.random())
    below = moved(blocks[1], low + gap - high, here - there)
    link = Corridor(low, here, gap, aisle, float(rng.choice([0.0, 0.5, 1.0])))
    return Skeleton([*blocks[0].corridors, *below.corridors, link], [*blocks[0].filled, *below.filled])


def moved(skeleton: Skeleton, down: int, right: int) -> Skeleton:
    """Return a skeleton moved by some cells."""
    corridors = [one._replace(top=one.top + down, left=one.left + right) for one in skeleton.corridors]
    return Skeleton(corridors, [(top + down, left + right, tall, wide) for top, left, tall, wide in skeleton.filled])


def size_of(skeleton: Skeleton) -> tuple[int, int, int, int]:
    """Return top, left, height and width of the rectangle around all corridors."""
    top, left = min(one.top for one in skeleton.corridors), min(one.left for one in skeleton.corridors)
    low = max(one.top + one.tall for one in skeleton.corridors)
    right = max(one.left + one.wide for one in skeleton.corridors)
    return top, left, low - top, right - left


def fitted(skeleton: Skeleton, tall: int, wide: int) -> Skeleton:
    """Return a skeleton that is shortened where it is larger than ``tall`` by ``wide`` cells; widths are kept."""
    _, _, height, width = size_of(skeleton)
    down, right = min(1.0, tall / height), min(1.0, wide / width)
    if down == right == 1.0:
        return skeleton
    top, left, *_ = size_of(skeleton)
    skeleton = moved(skeleton, -top, -left)
    corridors = [_shortened(one, down, right, tall, wide) for one in skeleton.corridors]
    filled = [(round(a * down), round(b * right), round(c * down), round(d * right)) for a, b, c, d in skeleton.filled]
    return Skeleton(corridors, filled)


def _shortened(one: Corridor, down: float, right: float, tall: int, wide: int) -> Corridor:
    """Return a corridor with its place and length scaled, inside ``tall`` by ``wide`` cells."""
    aisle = min(one.tall, one.wide)
    height = one.tall if one.tall == aisle else round(one.tall * down) + aisle
    width = one.wide if one.wide == aisle else round(one.wide * right) + aisle
    height, width = min(height, tall), min(width, wide)
    top, left = min(round(one.top * down), tall - height), min(round(one.left * right), wide - width)
    return Corridor(top, left, height, width, one.loaded)


#: The skeletons, how often each is drawn, and how many of its corridors are in line: long buildings have more wings.
SKELETONS: tuple[tuple[Callable[[np.random.Generator, Style, int], Skeleton], float, float], ...] = (
    (bar, 0.14, 1.0),
    (ell, 0.10, 0.6),
    (tee, 0.10, 0.6),
    (comb, 0.10, 0.35),
    (zigzag, 0.09, 0.4),
    (ring, 0.14, 0.4),
    (plate, 0.17, 0.1),
    (hub, 0.07, 0.5),
    (linked, 0.09, 0.5),
)
#: Metres of corridor in line from which on a skeleton is drawn less often.
LONG = 60.0


def draw_skeleton(rng: np.random.Generator, style: Style, floor: int) -> Skeleton:
    """Return a random skeleton for about ``floor`` cells of floor."""
    length = _length(style, floor) / style.metre / LONG
    weights = np.array([share / (1.0 + (part * length) ** 4) for _, share, part in SKELETONS])
    chosen = int(rng.choice(len(SKELETONS), p=weights / weights.sum()))
    return SKELETONS[chosen][0](rng, style, floor)


def _length(style: Style, floor: int) -> int:
    """Return how many cells of corridor about ``floor`` cells of floor need, with rooms along both sides."""
    return max(round(floor / (style.corridor + 1.7 * style.depth * style.loaded)), 3 * style.module)


def _across(style: Style, top: int, left: int, wide: int) -> Corridor:
    return Corridor(top, left, style.corridor, max(wide, style.corridor))


def _either(rng: np.random.Generator, style: Style) -> int:
    """Return the width of a main or of a lesser corridor."""
    return style.corridor if rng.random() < 0.6 else style.aisle
