"""The sizes of the thesis's network and of its images; this module does not need torch."""

from __future__ import annotations

from typing import NamedTuple

from indoor_explorers.env.errors import InputError

#: Filters, side and stride of the three convolutions; no padding.
CONVOLUTIONS = ((32, 8, 1), (64, 4, 2), (64, 3, 4))
#: Units of the two dense layers.
DENSE = (1024, 512)
#: The moves; the thesis's network never stays.
MOVES = 4


class ImageFormat(NamedTuple):
    """Format of a network's images; a network fits one format only."""

    height: int
    """Rows of the image."""
    width: int
    """Columns of the image."""
    frames: int
    """Stacked images."""
    identity: bool
    """Whether a UAV sees itself as 1 and every teammate as 2, or all by their numbers."""
    centred: bool = False
    """Whether the image is centred on the UAV, (2 H - 1, 2 W - 1) for a map of (H, W)."""

    def view(self) -> tuple[int, int]:
        """Return rows and columns after the convolutions, at least 1 x 1.

        Raises:
            InputError: the map is too small for them.

        """
        rows, cols = self.height, self.width
        for _, side, stride in CONVOLUTIONS:
            rows, cols = (rows - side) // stride + 1, (cols - side) // stride + 1
            if rows < 1 or cols < 1:
                raise InputError(
                    f"expected a map of at least 15 x 15 cells, got {self.height} x {self.width}, which the thesis's "
                    "convolutions do not fit into; train on a larger one"
                )
        return rows, cols

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Return names and shapes of the network's arrays, as torch stores them."""
        rows, cols = self.view()
        found: dict[str, tuple[int, ...]] = {}
        channels = self.frames
        for place, (filters, side, _) in enumerate(CONVOLUTIONS):
            found[f"convolutions.{place}.weight"] = (filters, channels, side, side)
            found[f"convolutions.{place}.bias"] = (filters,)
            channels = filters
        sizes = (channels * rows * cols, *DENSE)
        layers = (("first", *sizes[:2]), ("second", *sizes[1:]), ("value", DENSE[1], 1), ("advantage", DENSE[1], MOVES))
        for name, inputs, outputs in layers:
            found[f"{name}.weight"], found[f"{name}.bias"] = (outputs, inputs), (outputs,)
        return found
