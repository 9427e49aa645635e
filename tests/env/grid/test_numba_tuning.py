"""What is changed in numba: constants compile nothing anew, the collector is back afterwards, options compare alike."""

import gc

import pytest
from numba.core.compiler import Flags
from numba.core.targetconfig import TargetConfig

from indoor_explorers.env.grid import compile_cache
from indoor_explorers.env.grid.compiled import kernel, leaf
from indoor_explorers.env.grid.numba_tuning import install


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


@kernel()
def failing(x: int) -> int:
    return x.nothing  # type: ignore[attr-defined, no-any-return]


@pytest.mark.parametrize("wanted", [True, False])
def test_the_collector_is_afterwards_as_it_was_before(wanted):
    was_on = gc.isenabled()
    (gc.enable if wanted else gc.disable)()
    try:
        with pytest.raises(Exception, match="nothing"):
            failing(1.0 if wanted else 1)
        assert gc.isenabled() == wanted
    finally:
        (gc.enable if was_on else gc.disable)()


def test_compile_options_are_equal_when_their_values_are():
    assert install()
    plain, told, other = Flags(), Flags(), Flags()
    told.nrt = plain.nrt  # told what holds anyway
    other.nrt = not plain.nrt
    assert plain == told != other
    assert hash(plain) == hash(told)
    assert plain != TargetConfig()
