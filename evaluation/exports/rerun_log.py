"""Episodes in Rerun, a viewer of robot data in three dimensions (https://rerun.io). Needs the extra ``rerun``.

A recording has a time line ``step`` and, below the name of each policy: ``maps/truth``, the obstacles of the true map
as points; ``maps/team`` and ``maps/uav-K``, the obstacles and frontier cells that the team and UAV K know; ``uavs/K``
and ``uavs/K/trail``, where UAV K is and was; and ``coverage``. Coordinates are (column, -row, level), whole numbers at
the centres of cells.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env import World
from indoor_explorers.env.errors import InputError
from indoor_explorers.env.grid.arrays import Mask
from indoor_explorers.env.grid.cells import OCCUPIED
from indoor_explorers.env.grid.levels import Levels
from indoor_explorers.env.rendering.palette import FAINT, HIDDEN, uav_colours
from indoor_explorers.env.search.frontiers import frontier_mask

#: In place of a file: the viewer, which is started.
VIEWER = Path()
#: Most positions of a trail, the last ones; RGB of frontier cells.
TRAIL, FRONTIER = 400, (255, 201, 77)


class RerunLog:
    """A recording of episodes of a ``team`` of UAVs with policies of some ``names``, in a file or a viewer.

    Raises:
        InputError: Rerun is not installed, or ``path`` is neither :data:`VIEWER` nor ends in ``.rrd``.

    """

    def __init__(self, title: str, path: Path, names: Sequence[str], team: int) -> None:
        if path != VIEWER and path.suffix != ".rrd":
            raise InputError(f"expected a file *.rrd to record in, got {str(path)!r}; --rerun alone opens a viewer")
        self._rerun = load_rerun()
        self._stream = self._rerun.RecordingStream("indoor-explorers")
        self._stream.send_recording_name(title)
        self._part: Callable[[str], str] = self._rerun.escape_entity_path_part
        views = self._views([self._part(name) for name in names], team)
        if path == VIEWER:
            self._rerun.spawn(recording=self._stream, default_blueprint=views)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._stream.save(path, default_blueprint=views)
        self._shown: dict[str, NDArray[np.int64]] = {}
        self._trails: dict[str, deque[NDArray[np.float64]]] = {}

    def add(self, name: str, world: World) -> None:
        """Log the present step of the first episode of a world, below a ``name``; steps are logged in order."""
        name, levels, state = self._part(name), world.briefing(0, 0).levels, world.state
        self._stream.set_time("step", sequence=int(state.step[0]))
        truth = {"colors": [HIDDEN[OCCUPIED]], "radii": [0.1]}
        self._cells(f"{name}/maps/truth", "Points3D", state.truth[0] == OCCUPIED, levels, **truth)
        self._map(f"{name}/maps/team", state.union[0], levels)
        for uav, place in enumerate(places(state.cell[0], levels)):
            path, colour = f"{name}/uavs/{uav}", uav_colours(world.scenario.team)[uav]
            self._map(f"{name}/maps/uav-{uav}", world.view(0, uav).belief, levels)
            trail = self._trails.setdefault(path, deque(maxlen=TRAIL))
            trail.append(place)
            self._log(path, "Points3D", [place], colors=[colour], radii=[0.4], labels=[str(uav)])
            self._log(f"{path}/trail", "LineStrips3D", [np.array(trail)], colors=[colour], radii=[0.08])
        self._log(f"{name}/coverage", "Scalars", [float(world.counted_coverage[0])])

    def close(self) -> None:
        """Write what is not yet written."""
        self._stream.flush()
        self._stream.disconnect()

    def _views(self, names: Sequence[str], team: int) -> Any:
        """Return the layout: for each policy a view of each map with the UAVs, and below them the coverage."""
        rrb, beside = self._rerun.blueprint, []
        for name in names:
            parts = {each: (f"maps/{each}", "uavs") for each in ("team", *(f"uav-{uav}" for uav in range(team)))}
            of = {each: [f"/{name}/{part}/**" for part in some] for each, some in parts.items()}
            views = [rrb.Spatial3DView(name=each, contents=contents) for each, contents in of.items()]
            beside.append(rrb.Tabs(*views, name=name))
        curves = rrb.TimeSeriesView(name="coverage", contents=[f"/{name}/coverage" for name in names])
        return rrb.Blueprint(rrb.Vertical(rrb.Horizontal(*beside), curves, row_shares=[4, 1]))

    def _map(self, path: str, belief: NDArray[np.uint8], levels: Levels) -> None:
        for name, mask, colour, half in (
            ("obstacles", belief == OCCUPIED, FAINT, 0.5),
            ("frontier", frontier_mask(belief, levels.rise), FRONTIER, 0.15),
        ):
            look = {"half_sizes": np.full((1, 3), half, np.float32), "colors": [colour], "fill_mode": "solid"}
            self._cells(f"{path}/{name}", "Boxes3D", mask, levels, **look)

    def _cells(self, path: str, kind: str, mask: Mask, levels: Levels, **look: Any) -> None:
        """Log cells of a plane where they are not those that were logged last."""
        cells = np.argwhere(mask & ~levels.between)
        if path not in self._shown or not np.array_equal(cells, self._shown[path]):
            self._shown[path], centres = cells, places(cells, levels)
            self._log(path, kind, **{"centers" if kind == "Boxes3D" else "positions": centres}, **look)

    def _log(self, path: str, kind: str, *values: Any, **fields: Any) -> None:
        self._stream.log(path, getattr(self._rerun, kind)(*values, **fields))


def places(cells: NDArray[Any], levels: Levels) -> NDArray[np.float64]:
    """Return where the centres of cells (N, 2) of a plane are in space, (N, 3): column, -row, level."""
    return np.asarray(levels.voxels(cells)[:, ::-1] * (1.0, -1.0, 1.0))


def load_rerun() -> Any:
    """Import Rerun; raise :class:`InputError` if it is not installed."""
    try:
        import rerun
    except ModuleNotFoundError as error:
        raise InputError("rerun-sdk is not installed; pip install 'indoor-explorers[rerun]'") from error
    return rerun
