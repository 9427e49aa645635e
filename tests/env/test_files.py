"""Outputs are whole or as they were."""

import os
import threading

import pytest

from indoor_explorers.env.files import written_whole


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "summary.csv"
    path.write_text("old")
    with pytest.raises(TypeError), written_whole(path) as partial:  # noqa: PT012, the failure is half-way
        partial.write_text("ne")
        partial.write_text(None)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    with written_whole(path) as partial:
        partial.write_text("new")
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_pipe_stays_and_is_written_to(tmp_path):
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()), daemon=True)
    reader.start()
    with written_whole(pipe) as partial:
        partial.write_text("all of it")
    reader.join(10)
    assert (read, list(tmp_path.iterdir()), pipe.is_fifo()) == (["all of it"], [pipe], True)


def test_a_link_stays_and_its_target_is_written(tmp_path):
    target, link = tmp_path / "results" / "page.html", tmp_path / "link.html"
    target.parent.mkdir()
    link.symlink_to(target)
    for text in ("first", "second"):
        with written_whole(link) as partial:
            partial.write_text(text)
        assert (link.is_symlink(), target.read_text()) == (True, text)
    assert list(target.parent.iterdir()) == [target]


def test_two_that_write_one_file_do_not_disturb_each_other(tmp_path):
    path = tmp_path / "summary.csv"
    with written_whole(path) as first, written_whole(path) as second:
        first.write_text("first")
        second.write_text("second")
    assert path.read_text() == "first"
    assert list(tmp_path.iterdir()) == [path]
