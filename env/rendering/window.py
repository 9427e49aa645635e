"""A window that shows pictures as they come, through pygame. Needs the extra ``render`` and a display."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from indoor_explorers.env.errors import InputError

#: Share of the screen that a new window takes at most.
SCREEN_SHARE = 0.9
#: SDL's drivers without a display; accepted only if requested.
BLIND = ("dummy", "offscreen")
#: The advice for a missing display.
WITHOUT = "use render_mode='rgb_array', or set SDL_VIDEODRIVER=dummy to draw where nobody looks"


class Window:
    """Show (h, w, 3) uint8 pictures, at most ``fps`` a second.

    It opens with the first picture. The close button and Esc close it permanently. pygame has one window in a process;
    a second one replaces it.

    Raises:
        InputError: pygame is not installed, or there is no display.

    """

    def __init__(self, title: str, fps: float, instead: str = WITHOUT) -> None:
        """Prepare a window; ``instead`` is the advice in the error for a missing display."""
        self._pygame = load_pygame()
        self._title = title
        self._fps = fps
        self._instead = instead
        self._clock: Any = None
        #: Whether the user has closed it.
        self.closed = False
        #: Names of the keys that were pressed since :meth:`taken_keys`, such as "e".
        self._keys: list[str] = []
        if sys.platform.startswith("linux") and not any(
            os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")
        ):
            raise self._no_display("neither DISPLAY nor WAYLAND_DISPLAY is set")

    def __reduce__(self) -> tuple[Any, ...]:
        made_anew = Window, (self._title, self._fps, self._instead)  # pygame's objects cannot be copied
        return *made_anew, {"closed": self.closed}

    def show(self, picture: NDArray[np.uint8]) -> None:
        """Show a picture (h, w, 3), scaled to the window, and wait until the next one is due."""
        pygame = self._pygame
        if not self.closed and (self._clock is None or not pygame.display.get_init()):
            self._open(picture)
        self._heed()
        if self.closed:
            return
        screen = pygame.display.get_surface()
        height, width = picture.shape[:2]
        scale = min(screen.get_width() / width, screen.get_height() / height)
        size = max(round(width * scale), 1), max(round(height * scale), 1)
        surface = pygame.image.frombuffer(np.ascontiguousarray(picture).data, (width, height), "RGB")
        if size != (width, height):
            surface = pygame.transform.smoothscale(surface, size)
        screen.fill((255, 255, 255))
        screen.blit(surface, ((screen.get_width() - size[0]) // 2, (screen.get_height() - size[1]) // 2))
        pygame.display.flip()
        self._clock.tick(self._fps)

    def linger(self, picture: Callable[[], NDArray[np.uint8]]) -> None:
        """Show a picture (h, w, 3) until the window is closed; return at once if there is no visible window.

        It is asked for again and again, as keys may change it.
        """
        self.show(picture())
        while not self.closed and self._pygame.display.get_driver() not in BLIND:
            self.show(picture())

    def taken_keys(self) -> list[str]:
        """Return the names of the keys that were pressed since the last call."""
        keys, self._keys = self._keys, []
        return keys

    def close(self) -> None:
        """Close the window; the next picture opens it again unless the user has closed it."""
        if self._clock is not None:
            self._pygame.display.quit()
        self._clock = None

    def _open(self, picture: NDArray[np.uint8]) -> None:
        pygame = self._pygame
        try:
            pygame.display.init()
            if pygame.display.get_driver() in BLIND and os.environ.get("SDL_VIDEODRIVER") not in BLIND:
                raise pygame.error("no video device")
            height, width = picture.shape[:2]
            screen = pygame.display.get_desktop_sizes()[0]
            scale = min(1.0, SCREEN_SHARE * screen[0] / width, SCREEN_SHARE * screen[1] / height)
            pygame.display.set_mode((max(int(width * scale), 1), max(int(height * scale), 1)), pygame.RESIZABLE)
        except pygame.error as error:
            pygame.display.quit()
            raise self._no_display(str(error)) from error
        pygame.display.set_caption(self._title)
        self._clock = pygame.time.Clock()

    def _no_display(self, reason: str) -> InputError:
        return InputError(f"expected a display to open a window on, got none ({reason}); {self._instead}")

    def _heed(self) -> None:
        """Close the window on a quit event or Esc, and note other keys."""
        pygame = self._pygame
        for event in pygame.event.get() if self._clock is not None else ():
            if event.type == pygame.QUIT or (event.type == pygame.KEYDOWN and event.key == pygame.K_ESCAPE):
                self.closed = True
            elif event.type == pygame.KEYDOWN:
                self._keys.append(pygame.key.name(event.key))
        if self.closed:
            self.close()


def load_pygame() -> Any:
    """Import pygame without its messages; raise :class:`InputError` if it is not installed."""
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # pygame imports pkg_resources, which complains
            import pygame
    except ModuleNotFoundError as error:
        raise InputError(
            "pygame is not installed, which windows need; pip install 'indoor-explorers[render]'"
        ) from error
    return pygame
