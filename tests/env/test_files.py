"""Outputs are whole or as they were."""

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
