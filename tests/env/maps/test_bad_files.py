"""Broken and hostile map files: one clear line each, never a traceback or a warning."""

import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from indoor_explorers.env import InputError
from indoor_explorers.env.maps.files import read_map

GOOD = {
    "image": "map.pgm",
    "resolution": "0.05",
    "origin": "[0, 0, 0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


def refusal(path: Path) -> str:
    """Return the message that ``path`` is refused with, which is one line and names the file."""
    with pytest.raises(InputError) as caught:
        read_map(path, None)
    message = str(caught.value)
    assert str(path) in message
    assert message.isprintable()
    assert len(message) < 600
    return message


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    Image.fromarray(np.full((4, 4), 254, np.uint8)).save(tmp_path / "map.pgm")
    return tmp_path


def yaml_file(folder: Path, **changes: str | None) -> Path:
    """Write a good YAML file with some keys changed, or left out where None."""
    path = folder / "map.yaml"
    lines = [f"{key}: {value}" for key, value in (GOOD | changes).items() if value is not None]
    path.write_text("\n".join(lines))
    return path


def test_the_unchanged_file_is_read(folder: Path) -> None:
    assert read_map(yaml_file(folder), None).shape == (6, 6)


@pytest.mark.parametrize("key", ["image", "resolution", "negate", "occupied_thresh", "free_thresh"])
def test_a_missing_key_is_named(folder: Path, key: str) -> None:
    message = refusal(yaml_file(folder, **{key: None}))
    assert f"expected the key {key!r}" in message
    assert message.endswith("add it")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("resolution", "-0.05", "resolution: expected a number from 1e-06 to 1e+06"),
        ("resolution", "0", "got '0'"),
        ("resolution", ".nan", "got '.nan'"),
        ("resolution", "nan", "got 'nan'"),
        ("resolution", ".inf", "got '.inf'"),
        ("resolution", "1e999", "got '1e999'"),
        ("resolution", "9" * 5000, "resolution: expected a number"),
        ("resolution", "five", "got 'five'"),
        ("resolution", "[0.05]", "got a list"),
        ("resolution", "", "got ''"),
        ("occupied_thresh", "65", "occupied_thresh: expected a number from 0 to 1"),
        ("free_thresh", "{a: b}", "got a mapping"),
        ("free_thresh", "0.65", "expected free_thresh below occupied_thresh, got 0.65 and 0.65"),
        ("free_thresh", "0.9", "are they swapped?"),
        ("negate", "2", "negate: expected one of 0, false"),
        ("negate", "[0]", "got a list"),
        ("mode", "raw", "mode: expected one of trinary, scale, got 'raw'"),
        ("mode", "[]", "got a list"),
        ("origin", "[0, 0]", "origin: expected three numbers"),
        ("origin", "[0, 0, east]", "origin: expected three numbers"),
        ("origin", "home", "got 'home'"),
        ("image", "", "image: expected the picture's path"),
        ("image", "[map.pgm]", "got a list"),
        ("image", "elsewhere.pgm", "elsewhere.pgm: expected a file, got a path where there is none"),
        ("image", ".", "expected a file, got a directory"),
        ("image", '"map\\0.pgm"', "embedded null byte"),
        ("image", "x" * 300, "File name too long"),
        ("image", "x" * 5000 + "END", "END: cannot be read: File name too long; correct the path"),
        ("image", '"a\\nb\\e[31m"', r"a b\x1b[31m: expected a file"),
        ("image", "map.yaml", "expected a PNG, PGM or BMP picture"),
    ],
)
def test_a_wrong_value_is_named(folder: Path, key: str, value: str, message: str) -> None:
    assert message in refusal(yaml_file(folder, **{key: value}))


ALIASES = "a0: &a0 [x, x]\n" + "".join(f"a{k}: &a{k} [*a{k - 1}, *a{k - 1}]\n" for k in range(1, 60))
MERGES = "a0: &a0 {x: 1}\n" + "".join(f"a{k}: &a{k} {{<<: [*a{k - 1}, *a{k - 1}]}}\n" for k in range(1, 60))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "got an empty file"),
        ("# only a comment\n", "got an empty file"),
        ("- image\n- resolution\n", "got a list"),
        ("just text", "got plain text"),
        ("a: [1, 2", "expected YAML"),
        ("a: b: c", "expected YAML"),
        ("a: 1\n---\nb: 2\n", "expected YAML"),
        ("? [a, b]\n: c", "expected YAML"),
        ("\x00\x01", "expected YAML"),
        ("image: !!python/object:os.system x", "expected the key 'resolution'"),
        ("[" * 30_000, "nested deeper"),
        ("- " * 20_000, "nested deeper"),
        ("{a: " * 10_000, "nested deeper"),
        (ALIASES, "expected the key 'image'"),
        (MERGES, "expected the key 'image'"),
        ("a: " + "x" * 70_000, "at most 65,536 bytes"),
    ],
    ids=lambda value: value[:12],
)
def test_a_file_that_is_no_map_server_yaml_is_refused(folder: Path, text: str, message: str) -> None:
    path = folder / "map.yaml"
    path.write_text(text)
    assert message in refusal(path)


def test_an_alias_bomb_as_a_value_is_not_printed(folder: Path) -> None:
    path = yaml_file(folder, resolution="*a59")
    path.write_text(ALIASES + path.read_text())
    assert "resolution: expected a number" in refusal(path)


def png(width: int, height: int, data: bytes = b"") -> bytes:
    """A grey PNG whose header promises ``width`` x ``height`` pixels."""

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + header + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.pgm", b"", "got an empty file"),
        ("a.png", b"", "got an empty file"),
        ("a.png", b"GIF89a" + bytes(30), "another kind, or a broken header"),
        ("a.png", b"\x89PNG\r\n\x1a\n", "a.png"),
        ("a.png", png(4, 4, bytes(20))[:-30], "a.png"),
        ("a.png", png(400, 400, bytes(20)), "a.png"),
        ("a.png", png(4, 4, bytes(20)).replace(b"IHDR", b"IHDX"), "a.png"),
        ("a.png", png(0, 0), "a.png"),
        ("a.png", png(7_000, 7_000), "expected at most 36,000,000 pixels, got 7,000 x 7,000"),
        ("a.png", png(10_000, 10_000), "expected at most 36,000,000 pixels, got 10,000 x 10,000"),
        ("a.png", png(2**31 - 1, 2**31 - 1), "got far more"),
        ("a.pgm", b"P5\n1000000 1000000\n255\n", "got far more"),
        ("a.pgm", b"P5\n10000 10000\n255\n" + bytes(100), "got 10,000 x 10,000"),
        ("a.pgm", b"P5\n100 100\n255\n" + bytes(100), "a.pgm"),
        ("a.pgm", b"P5\n-4 4\n255\n" + bytes(100), "a.pgm"),
        ("a.pgm", b"P5\n4 4\n0\n" + bytes(100), "a.pgm"),
        ("a.pgm", b"P5\n4 " + b"4" * 5000, "a.pgm"),
        ("a.pgm", b"P2\n4 4\n255\n1 2 3 x", "a.pgm"),
        ("a.pgm", b"P5\n" + b"# x\n" * 5_000 + b"4 4\n255\n" + bytes(16), "expected a header of at most 10,000 bytes"),
        ("a.pgm", b"P5 4 4 " + b" " * 20_000 + b"255\n" + bytes(16), "expected a header of at most 10,000 bytes"),
        ("a.pgm", b"P2\n4 4\n255\n" + b"#\n" * 5_000, "expected at most 1,000 comments"),
        ("a.pgm", b"P2\n2000 2000\n255\n" + b"255 " * 2_500_000, "expected at most 10,000,000 bytes of text"),
        ("a.bmp", b"BM" + bytes(60), "a.bmp"),
        ("a.pgm", b"P5\n4 4\n255\n" + bytes(16), "expected a map with free pixels, got none"),
    ],
    ids=lambda value: repr(value)[:40],  # some have millions of bytes
)
def test_a_broken_picture_is_refused(tmp_path: Path, name: str, data: bytes, message: str) -> None:
    (tmp_path / name).write_bytes(data)
    assert message in refusal(tmp_path / name)


@pytest.mark.parametrize(
    ("width", "height", "resolution", "message"),
    [
        (6_000, 6_000, None, "expected at most 4,194,304 cells, got 6,000 x 6,000; ask for a coarser --resolution"),
        (2_049, 2_048, 1.0, "expected at most 4,194,304 cells, got 2,048 x 2,049"),
        (6_000, 6_000, 0.5, "expected a resolution of at least the source's 1 m"),
        (1, 36_000_000, 3000.0, "expected at most 4,194,304 pixels along a side"),
    ],
)
def test_a_map_of_an_impossible_size_is_refused_before_it_is_decoded(
    tmp_path: Path, width: int, height: int, resolution: float | None, message: str
) -> None:
    """The picture holds no more than its header."""
    (tmp_path / "a.png").write_bytes(png(width, height))
    (tmp_path / "a.yaml").write_bytes(yaml_file(tmp_path, image="a.png", resolution="1.0").read_bytes())
    for name in ("a.png", "a.yaml"):
        with pytest.raises(InputError) as caught:
            read_map(tmp_path / name, resolution)
        assert str(caught.value).startswith(f"{tmp_path / name}: {message}")


def test_a_truncated_picture_says_so(tmp_path: Path) -> None:
    whole = np.random.default_rng(0).integers(0, 255, (64, 64)).astype(np.uint8)
    for name in ("a.pgm", "a.png", "a.bmp"):
        Image.fromarray(whole).save(tmp_path / name)
        data = (tmp_path / name).read_bytes()
        (tmp_path / name).write_bytes(data[: len(data) // 2])
        assert "truncated" in refusal(tmp_path / name)


def test_missing_unreadable_and_odd_paths_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "there is none" in refusal(tmp_path / "nothing.yaml")
    assert "there is none" in refusal(tmp_path / "nothing.png")
    folder = tmp_path / "folder.yaml"
    folder.mkdir()
    assert "got a directory" in refusal(folder)
    assert "expected a map ending in" in refusal(yaml_file(tmp_path).rename(tmp_path / "map"))
    path = yaml_file(tmp_path)

    def denied(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "read_bytes", denied)
    assert "cannot be read: Permission denied" in refusal(path)
