"""A clone passes by its files, and every other folder is refused in one line that says what to do."""

import hashlib
from pathlib import Path

import pytest

from indoor_explorers.env.errors import InputError
from indoor_explorers.planners.toolbox.peers.clone import PublishedCode

CODE = PublishedCode(
    url="https://example.org/lab/Explorer",
    commit="0123456789abcdef0123456789abcdef01234567",
    files={"env.py": hashlib.sha256(b"x = 1\n").hexdigest(), "model/net.py": hashlib.sha256(b"").hexdigest()},
)


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """Return a folder with the files of the commit."""
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "net.py").write_bytes(b"")
    (tmp_path / "env.py").write_bytes(b"x = 1\n")
    return tmp_path


def test_a_clone_at_the_commit_passes(clone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its absolute path is returned; other files in it, such as a checkpoint, do not matter."""
    (clone / "checkpoint.pth").write_bytes(b"weights")
    monkeypatch.chdir(clone.parent)
    assert CODE.checked(clone.name) == clone.resolve()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda clone: (clone / "env.py").write_bytes(b"x = 2\n"), "found another env.py; run `git -C "),
        (lambda clone: (clone / "env.py").unlink(), "found no env.py in it; fetch it with `git clone https://"),
        (lambda clone: clone.rename(clone.with_name("moved")), "found no folder; fetch it with `git clone https://"),
    ],
    ids=["another commit", "a missing file", "no folder"],
)
def test_another_folder_is_refused_in_one_line(clone: Path, change, told: str) -> None:
    """The line says what was expected, what was found, and the command that mends it."""
    change(clone)
    with pytest.raises(InputError) as refused:
        CODE.checked(clone)
    assert "expected a clone of https://example.org/lab/Explorer at commit 0123456" in str(refused.value)
    assert told in str(refused.value)
    assert "\n" not in str(refused.value)
