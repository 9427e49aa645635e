"""The audit of a split: which test maps are in a training folder, as they are, turned, rescaled, or nearly."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from indoor_explorers.env.errors import InputError
from indoor_explorers.env.files import written_whole
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import FREE
from indoor_explorers.env.maps.files import READERS, read_map
from indoor_explorers.env.maps.layouts import cropped_to_free, layout_digest, mask_digest, overlap, symmetries

#: Side of the small pictures by which near copies are looked for, in cells.
SIDE = 24
#: Training maps whose small pictures are most like that of a test map, whose overlap is measured.
CANDIDATES = 4
#: Test maps whose small pictures are compared at once.
BATCH = 64


class Kind(StrEnum):
    """How a test map is in the training folder; the first that holds counts."""

    SAME = "same cells"
    TURNED = "turned or mirrored"
    RESCALED = "cropped or rescaled"
    NEAR = "near copy"


@dataclass(frozen=True)
class AuditedMap:
    """A map file, by the digests and the small picture of its free cells."""

    path: Path
    digests: tuple[str, str, str]
    """Of its cells, of its cells up to symmetry, and of its layout."""
    small: np.ndarray
    """(SIDE, SIDE) float32: the share of free cells in each part of the map, of mean 0 and length 1."""

    @classmethod
    def read(cls, path: Path, resolution: float | None = None) -> AuditedMap:
        """Read a map file."""
        free = read_free(path, resolution)
        return cls(path, (mask_digest([free]), mask_digest(symmetries(free)), layout_digest(free)), _small(free))


class Match(NamedTuple):
    """A test map that is in the training folder."""

    test: Path
    train: Path
    kind: Kind
    overlap: float
    """Shared share of the free cells of either, 0 to 1; 1 for equal layouts."""


@dataclass(frozen=True)
class Audit:
    """The maps of two folders, and which test maps are among those to train on."""

    train: Sequence[AuditedMap]
    test: Sequence[AuditedMap]
    matches: Sequence[Match]

    @cached_property
    def counts(self) -> dict[Kind, int]:
        """Number of test maps by how they are in the training folder."""
        return {kind: sum(match.kind is kind for match in self.matches) for kind in Kind}

    @property
    def layouts(self) -> tuple[int, int]:
        """Number of different layouts to train and to test on."""
        train, test = ({each.digests[-1] for each in maps} for maps in (self.train, self.test))
        return len(train), len(test)


def read_free(path: Path, resolution: float | None = None) -> Mask:
    """Return the (H, W) mask of the free cells of a map file."""
    free: Mask = read_map(path, resolution).truth == FREE
    return free


def map_files(place: Path) -> list[Path]:
    """Return the map files below a folder, or the file itself; the picture of a ROS map is no map of its own.

    Raises:
        InputError: there is none.

    """
    if place.is_file():
        return [place]
    found = [path for path in sorted(place.rglob("*")) if path.suffix.lower() in READERS and path.is_file()]
    alone = [path for path in found if not _is_picture_of_ros_map(path)]
    if not alone:
        raise InputError(f"{place}: expected a map file or a folder of them ({', '.join(READERS)}), got none")
    return alone


def _is_picture_of_ros_map(path: Path) -> bool:
    return path.suffix not in (".yaml", ".yml") and any(path.with_suffix(end).exists() for end in (".yaml", ".yml"))


def audited(train: Sequence[AuditedMap], test: Sequence[AuditedMap], near: float, resolution: float | None) -> Audit:
    """Compare test maps with those to train on.

    Args:
        train: maps to train on.
        test: maps to test on.
        near: the overlap from which on two maps are near copies, see
            :func:`~indoor_explorers.env.maps.layouts.overlap`.
        resolution: metres a cell in which both were read.

    """
    equal = list(_equal_layouts(train, test))
    found = {match.test for match in equal}
    others = [each for each in test if each.path not in found]
    matches = [*equal, *_near_copies(train, others, near, resolution)]
    return Audit(train, test, sorted(matches, key=lambda match: match.test))


def _equal_layouts(train: Iterable[AuditedMap], test: Iterable[AuditedMap]) -> Iterator[Match]:
    known: dict[str, Path] = {}
    for each in train:
        for digest in each.digests:
            known.setdefault(digest, each.path)
    for each in test:
        for kind, digest in zip((Kind.SAME, Kind.TURNED, Kind.RESCALED), each.digests, strict=True):
            if digest in known:
                yield Match(each.path, known[digest], kind, 1.0)
                break


def _near_copies(
    train: Sequence[AuditedMap], test: Sequence[AuditedMap], near: float, resolution: float | None
) -> Iterator[Match]:
    """Yield the test maps that overlap one of the likeliest training maps enough, with the best of these."""
    pictures = np.stack([each.small.ravel() for each in train])
    count = min(CANDIDATES, len(train))
    for start in range(0, len(test), BATCH):
        batch = test[start : start + BATCH]
        turned = [np.stack([view.ravel() for view in symmetries(each.small)]) for each in batch]
        alike = np.stack([(views @ pictures.T).max(axis=0) for views in turned])
        likely = np.argpartition(-alike, count - 1, axis=1)[:, :count]
        for each, numbers in zip(batch, likely, strict=True):
            free = read_free(each.path, resolution)
            shares = [overlap(free, read_free(train[number].path, resolution)) for number in numbers]
            best = int(np.argmax(shares))
            if shares[best] >= near:
                yield Match(each.path, train[numbers[best]].path, Kind.NEAR, shares[best])


def _small(free: Mask) -> np.ndarray:
    """Return the share of free cells in each of SIDE x SIDE parts of a (H, W) mask, centred and scaled."""
    picture = Image.fromarray(cropped_to_free(free).astype(np.uint8) * 255)
    small = np.asarray(picture.resize((SIDE, SIDE), Image.Resampling.BOX), dtype=np.float32)
    centred = small - small.mean()
    return np.asarray(centred / max(float(np.linalg.norm(centred)), 1e-6))


def write_matches(matches: Iterable[Match], path: Path) -> None:
    """Write a CSV file with a line for each match."""
    with written_whole(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(Match._fields)
        writer.writerows((*match[:3], f"{match.overlap:.4f}") for match in matches)
