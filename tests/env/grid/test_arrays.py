from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.grid.arrays import allocated


class Some(NamedTuple):
    one: Annotated[NDArray[np.float32], "N 2"]
    until: Annotated[np.ndarray[tuple[Any, ...], np.dtype[np.int32]], "N"]  # what NDArray was until numpy 2.4
    since: Annotated[list[np.int32], "N M"]  # one argument, as NDArray has since numpy 2.5


def test_arrays_have_the_types_and_axes_of_their_annotations() -> None:
    some: Any = allocated(Some, N=3, M=4)  # type: ignore[type-var]  # a list is no array
    assert [array.dtype for array in some] == [np.float32, np.int32, np.int32]
    assert [array.shape for array in some] == [(3, 2), (3,), (3, 4)]
