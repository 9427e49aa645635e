"""The window, on SDL's driver that draws into memory."""

import subprocess
import sys
import time

import numpy as np
import pytest

from indoor_explorers.env import InputError
from indoor_explorers.env.rendering.window import Window, load_pygame

PICTURE = np.random.default_rng(0).integers(0, 256, (90, 161, 3), dtype=np.uint8)


@pytest.fixture
def pygame():
    return load_pygame()


@pytest.fixture
def window():
    made = Window("test", fps=1000)
    yield made
    made.close()


def shown(pygame):
    return pygame.surfarray.array3d(pygame.display.get_surface()).swapaxes(0, 1)


def test_a_picture_is_shown_as_it_is(window, pygame):
    window.show(PICTURE)
    assert pygame.display.get_caption()[0] == "test"
    assert np.array_equal(shown(pygame), PICTURE)


def test_a_large_picture_is_made_to_fit_the_screen(window, pygame):
    window.show(np.full((3000, 6000, 3), 200, np.uint8))
    width, height = pygame.display.get_surface().get_size()
    screen = pygame.display.get_desktop_sizes()[0]
    assert width <= 0.9 * screen[0]
    assert height <= 0.9 * screen[1]
    assert abs(width / height - 2) < 0.02


@pytest.mark.parametrize("kind", ["close button", "Esc"])
def test_somebody_closes_it_and_the_flight_goes_on_unseen(window, pygame, kind):
    window.show(PICTURE)
    quit_ = pygame.event.Event(pygame.QUIT)
    pygame.event.post(quit_ if kind == "close button" else pygame.event.Event(pygame.KEYDOWN, key=pygame.K_ESCAPE))
    for _ in range(3):
        window.show(PICTURE)
        assert window.closed
        assert not pygame.display.get_init()


def test_a_closed_window_may_be_closed_again_and_opened_again(window, pygame):
    window.close()
    window.show(PICTURE)
    window.close()
    window.close()
    assert not pygame.display.get_init()
    assert not window.closed
    window.show(PICTURE)
    assert np.array_equal(shown(pygame), PICTURE)


def test_of_two_windows_the_later_one_is_seen_and_either_may_close(window, pygame):
    other = Window("other", fps=1000)
    window.show(PICTURE)
    other.show(PICTURE[:50])
    other.close()
    window.show(PICTURE)
    assert np.array_equal(shown(pygame), PICTURE)


def test_pictures_come_no_faster_than_asked_for():
    window = Window("test", fps=50)
    window.show(PICTURE)
    start = time.perf_counter()
    for _ in range(5):
        window.show(PICTURE)
    window.close()
    assert time.perf_counter() - start > 0.08


def test_the_last_picture_does_not_linger_where_nobody_looks(window):
    window.linger(lambda: PICTURE)
    assert not window.closed


def test_no_display_is_one_clear_error(monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(InputError, match=r"expected a display .* got none .*use render_mode='rgb_array', or set SDL"):
        Window("test", 8)


def test_a_display_that_cannot_be_opened_is_one_clear_error(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "nonsense")
    window = Window("test", 8)
    with pytest.raises(InputError, match="expected a display"):
        window.show(PICTURE)


def test_a_missing_pygame_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(InputError, match=r"indoor-explorers\[render\]"):
        Window("test", 8)


def test_pygame_and_the_encoder_are_loaded_only_when_they_are_used():
    code = (
        "import sys, indoor_explorers.evaluation.cli.parser, indoor_explorers.env.interfaces.gymnasium_env;"
        "print({'pygame', 'av'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"


def test_pygame_loads_without_a_word():
    code = "from indoor_explorers.env.rendering.window import load_pygame; load_pygame()"
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
