"""Write pictures to a file: a still (PNG), a short loop (GIF), or a video (MP4, which needs the extra ``render``)."""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from indoor_explorers.env.errors import InputError, RunError, did_you_mean
from indoor_explorers.env.files import expanded, written_whole
from indoor_explorers.env.rendering.indexed import Palette

#: The most frames of a video, by ending; of longer episodes every second, fourth, ... frame is kept.
FRAMES = {".png": 1, ".gif": 240, ".mp4": 1800}
#: Bounds of the default frames a second, for which a video lasts ``SECONDS``.
FPS, SECONDS = (8, 25), 30
#: Seconds that a GIF rests on its last frame.
REST = 2.0
#: Frames that a GIF's palette is chosen from.
SAMPLED = 8

Picture = NDArray[np.uint8]


class VideoWriter:
    """Collect the frames of an episode and write them to one file, whole or not at all.

    Frames are stored compressed and thinned to the limit of the file type, and to ``most`` if given.

    Raises:
        InputError: the ending is none of ``FRAMES``, the folder cannot be written, or the encoder is missing.

    """

    def __init__(self, path: str | Path, fps: float | None = None, most: int | None = None) -> None:
        self.path = expanded(path)
        self._kind = _checked_kind(self.path)
        self._limit = min(FRAMES[self._kind], most or FRAMES[self._kind])
        self._fps = fps
        self._frames: list[bytes] = []
        self._shape: tuple[int, ...] = ()
        self._moments, self._stride = 0, 1

    def add(self, picture: Callable[[], Picture], *, last: bool = False) -> None:
        """Add the next frame; ``picture`` is called only if the frame is kept, as the ``last`` one always is."""
        if last or (self._moments % self._stride == 0 and self._limit > 1):
            frame = picture()
            self._shape = frame.shape
            self._frames.append(zlib.compress(frame.tobytes(), 1))
        self._moments += 1
        if len(self._frames) > self._limit and not last:
            del self._frames[1::2]
            self._stride *= 2

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._frames)

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) of the frames in pixels."""
        return self._shape[1], self._shape[0]

    @property
    def fps(self) -> float:
        """Frames a second."""
        return self._fps if self._fps is not None else min(max(len(self) / SECONDS, FPS[0]), FPS[1])

    def save(self, progress: Callable[[int], None] = lambda written: None) -> None:
        """Write the file; ``progress`` is called with the number of frames written so far.

        Raises:
            RunError: the file could not be written; an earlier one is unchanged.

        """
        writer = {".png": _write_png, ".gif": _write_gif, ".mp4": _write_mp4}[self._kind]
        try:
            with written_whole(self.path) as partial:
                writer(partial, self, progress)
        except OSError as error:
            raise RunError(f"{self.path}: cannot be written: {error.strerror or error}") from error

    def frame(self, number: int) -> Picture:
        """Return one frame, (h, w, 3) uint8."""
        return np.frombuffer(zlib.decompress(self._frames[number]), np.uint8).reshape(self._shape)


def _checked_kind(path: Path) -> str:
    """Return the ending of a path that a video can be written to."""
    kind = path.suffix.lower()
    if kind not in FRAMES:
        raise InputError(f"{path}: expected a name that ends in .png, .gif or .mp4{did_you_mean(kind, FRAMES)}")
    if path.is_dir():
        raise InputError(f"{path}: expected a file to write, got a folder; choose another name")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: its folder cannot be made: {error.strerror}; choose another one") from error
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: expected a folder that can be written, got a read-only one; choose another one")
    if kind == ".mp4":
        _load_av()
    return kind


def _load_av() -> Any:
    try:
        import av
    except ModuleNotFoundError as error:
        raise InputError(
            "PyAV is not installed, an .mp4 needs it; save a .gif, or pip install 'indoor-explorers[render]'"
        ) from error
    return av


def _write_png(path: Path, video: VideoWriter, progress: Callable[[int], None]) -> None:
    Image.fromarray(video.frame(len(video) - 1)).save(path, format="PNG", optimize=True)
    progress(1)


def _write_gif(path: Path, video: VideoWriter, progress: Callable[[int], None]) -> None:
    pause = max(round(100 / video.fps), 2) * 10  # a GIF counts in hundredths of a second
    durations = [pause] * (len(video) - 1) + [round(1000 * REST)]
    sampled = np.unique(np.linspace(0, len(video) - 1, SAMPLED).round().astype(int)).tolist()
    palette = Palette([video.frame(number) for number in sampled])

    def frames() -> Iterator[Image.Image]:
        for number in range(len(video)):
            yield palette.image(video.frame(number))
            progress(number + 1)

    moving = frames()
    next(moving).save(path, format="GIF", save_all=True, append_images=moving, duration=durations, loop=0)


def _write_mp4(path: Path, video: VideoWriter, progress: Callable[[int], None]) -> None:
    av = _load_av()
    width, height = (side + side % 2 for side in video.size)
    with av.open(str(path), "w", format="mp4", options={"movflags": "+faststart"}) as container:
        stream = container.add_stream("libx264", rate=Fraction(video.fps).limit_denominator(1000))
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        stream.options = {"crf": "20", "tune": "animation"}
        for number in range(len(video)):
            picture = video.frame(number)
            even = np.pad(picture, ((0, height - len(picture)), (0, width - picture.shape[1]), (0, 0)), mode="edge")
            container.mux(stream.encode(av.VideoFrame.from_ndarray(even, format="rgb24")))
            progress(number + 1)
        container.mux(stream.encode())
