"""Observations, dicts or arrays, compared and filled."""

import numpy as np


def assert_same(one, other):
    """Assert that observations, or dicts of any depth of them, are the same numbers of the same types."""
    if isinstance(one, dict):
        assert one.keys() == other.keys()
        for name in one:
            assert_same(one[name], other[name])
    else:
        assert one.dtype == other.dtype
        assert np.array_equal(one, other)


def filled(arrays, number):
    """Return the arrays with the number everywhere."""
    for array in arrays.values() if isinstance(arrays, dict) else [arrays]:
        array[...] = number
    return arrays
