"""Stills, GIFs and videos: the right frames, whole or not at all."""

import os
import sys

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.env.errors import InputError, RunError
from indoor_explorers.env.rendering.indexed import EXACT, Palette
from indoor_explorers.env.rendering.video_writer import FRAMES, VideoWriter


def picture(number, shape=(40, 61)):
    """A white page with a black bar whose length counts."""
    page = np.full((*shape, 3), 255, np.uint8)
    page[10:20, : 1 + number % shape[1]] = 0
    page[30:, number % shape[1]] = (200, 30, number % 256)
    return page


def shot(path, count, fps=None):
    video = VideoWriter(path, fps)
    for number in range(count):
        video.add(lambda number=number: picture(number), last=number == count - 1)
    return video


def frames_of(path):
    if path.suffix == ".mp4":
        import av

        with av.open(str(path)) as container:
            return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    with Image.open(path) as image:
        found = []
        for number in range(image.n_frames):
            image.seek(number)
            found.append(np.asarray(image.convert("RGB")))
        return found


@pytest.mark.parametrize("name", ["a.gif", "b.mp4", "c.GIF"])
def test_a_film_has_every_moment(name, tmp_path):
    told = []
    shot(tmp_path / name, 12).save(told.append)
    frames = frames_of(tmp_path / name)
    assert told == list(range(1, 13))
    assert len(frames) == 12
    assert [path.name for path in tmp_path.iterdir()] == [name]
    for number, frame in enumerate(frames):
        expected = picture(number)
        assert frame.shape[:2] in {(40, 61), (40, 62)}
        assert abs(frame[12:18, : max(number - 4, 0)].astype(int)).max(initial=0) < 40
        assert (frame[:8, :61] > 225).all()
        if not name.endswith(".mp4"):
            assert abs(frame.astype(int) - expected).max() <= 4


def test_a_video_is_h264_in_a_form_that_every_player_knows(tmp_path):
    import av

    shot(tmp_path / "a.mp4", 5, fps=12.5).save()
    with av.open(str(tmp_path / "a.mp4")) as container:
        (stream,) = container.streams
        assert (stream.codec_context.name, stream.pix_fmt) == ("h264", "yuv420p")
        assert (stream.width, stream.height, stream.average_rate) == (62, 40, 12.5)


def test_a_gif_goes_round_and_rests_at_its_end(tmp_path):
    shot(tmp_path / "a.gif", 4, fps=10).save()
    with Image.open(tmp_path / "a.gif") as image:
        assert image.info["loop"] == 0
        pauses = []
        for number in range(image.n_frames):
            image.seek(number)
            pauses.append(image.info["duration"])
    assert pauses == [100, 100, 100, 2000]


def test_a_still_is_the_last_moment(tmp_path):
    video = shot(tmp_path / "a.png", 7)
    video.save()
    assert len(video) == 1
    assert np.array_equal(frames_of(tmp_path / "a.png")[0], picture(6))


def test_a_long_film_is_thinned_evenly_and_ends_with_the_last_moment(tmp_path, monkeypatch):
    monkeypatch.setitem(FRAMES, ".gif", 10)
    drawn = []

    def draw(number):
        drawn.append(number)
        return picture(number)

    video = VideoWriter(tmp_path / "a.gif")
    for number in range(54):
        video.add(lambda number=number: draw(number), last=number == 53)
    video.save()
    frames = frames_of(tmp_path / "a.gif")
    assert [int((frame[15, :, 0] == 0).sum()) - 1 for frame in frames] == [0, 8, 16, 24, 32, 40, 48, 53]
    assert len(drawn) < 30  # what is left out is not drawn


def test_a_film_s_speed_follows_its_length(tmp_path):
    assert shot(tmp_path / "a.gif", 20).fps == 8
    assert shot(tmp_path / "a.mp4", 450).fps == 15
    assert shot(tmp_path / "a.gif", 20, fps=3).fps == 3


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("film.avi", "expected a name that ends in .png, .gif or .mp4"),
        ("film.gfi", "did you mean '.gif'"),
        ("film", "expected a name that ends in"),
        ("folder.gif", "expected a file to write, got a folder"),
        ("file/film.gif", "its folder cannot be made"),
    ],
)
def test_a_name_that_cannot_be_written_is_refused_before_anything_is_flown(name, message, tmp_path):
    (tmp_path / "folder.gif").mkdir()
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=message):
        VideoWriter(tmp_path / name)


def test_a_read_only_folder_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)
    with pytest.raises(InputError, match="read-only"):
        VideoWriter(tmp_path / "film.gif")


def test_a_folder_that_is_not_there_is_made(tmp_path):
    shot(tmp_path / "deep" / "er" / "a.gif", 2).save()
    assert (tmp_path / "deep" / "er" / "a.gif").exists()


def test_a_missing_encoder_names_the_extra_and_the_way_without_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match=r"save a \.gif, or pip install 'indoor-explorers\[render\]'"):
        VideoWriter(tmp_path / "film.mp4")
    shot(tmp_path / "film.gif", 2).save()


@pytest.mark.parametrize("name", ["a.gif", "a.mp4", "a.png"])
@pytest.mark.parametrize("error", [KeyboardInterrupt(), OSError(28, "No space left on device")])
def test_what_was_there_stays_when_writing_breaks_off(name, error, tmp_path):
    (tmp_path / name).write_text("before")
    video = shot(tmp_path / name, 5)

    def breaks(written):
        raise error

    with pytest.raises(RunError if isinstance(error, OSError) else KeyboardInterrupt) as caught:
        video.save(breaks)
    if isinstance(error, OSError):
        assert str(caught.value) == f"{tmp_path / name}: cannot be written: No space left on device"
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "before"


def test_frequent_colours_are_exact_and_rare_ones_near():
    rng = np.random.default_rng(0)
    page = np.repeat(rng.integers(0, 256, (EXACT, 1, 3), dtype=np.uint8), 50, axis=1)
    page[:, 0] = rng.integers(0, 256, (EXACT, 3))
    colours = np.asarray(Palette([page]).image(page).convert("RGB"))
    assert np.array_equal(colours[:, 1:], page[:, 1:])
    assert abs(colours[:, 0].astype(int) - page[:, 0]).max() < 64
