"""What is changed in numba: constants compile nothing anew."""

from indoor_explorers.env.grid import compile_cache
from indoor_explorers.env.grid.compiled import kernel, leaf


@leaf(entry=False)
def scaled(x: int, factor: int, negative: bool) -> int:
    return -factor * x if negative else factor * x


@kernel()
def of_constants(x: int) -> int:
    return scaled(x, 2, False) + scaled(x, 3, True) + scaled(x, factor=5, negative=False)


def test_a_function_is_compiled_once_for_all_constants(monkeypatch):
    monkeypatch.setattr(compile_cache, "cache_folder", lambda: None)  # what a cache has is not compiled at all
    assert of_constants(10) == 40
    assert len(scaled.signatures) == 1
