"""Render the episodes of Gymnasium and PettingZoo environments: their trails, and the window if there is one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.rendering.painter import paint
from indoor_explorers.env.rendering.scene import Trails, scene_of
from indoor_explorers.env.rendering.window import Window
from indoor_explorers.env.simulation.world import World


class Renderer:
    """Render a world as a render mode asks: ``rgb_array``, ``human`` (its first episode in a window), or None.

    Call :meth:`begun` for every episode that begins and :meth:`stepped` after every step; with None both do nothing.

    Raises:
        InputError: the mode is ``human``, and pygame or a display is missing.

    """

    def __init__(self, world: World, render_mode: str | None, fps: float) -> None:
        self._world = world
        self._window = Window(world.scenario.name, fps) if render_mode == "human" else None
        self._trails: list[Trails] = []
        if render_mode is not None:
            self._trails = [Trails(world.state.truth.shape[1:]) for _ in range(world.batch)]
            for trails, cells in zip(self._trails, world.state.cell, strict=True):
                trails.restart(cells)

    def begun(self, episode: int) -> None:
        """Start the trails of an episode that has begun, and show it in the window, if any."""
        if self._trails:
            self._trails[episode].restart(self._world.state.cell[episode])
        if self._window is not None:
            self._window.show(self.picture(episode))

    def stepped(self) -> None:
        """Extend the trails after a step, and show the first episode in the window, if any."""
        for trails, cells in zip(self._trails, self._world.state.cell, strict=False):
            trails.add(cells)
        if self._window is not None:
            self._window.show(self.picture(0))

    def picture(self, episode: int) -> NDArray[np.uint8]:
        """Return the picture of one episode now, (h, w, 3) uint8."""
        return paint(scene_of(self._world, episode, self._trails[episode]))

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture (h, w, 3) uint8 of the first episode, or show it in the window, or return None."""
        if self._window is not None:
            self._window.show(self.picture(0))
            return None
        return self.picture(0) if self._trails else None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()
