"""The watch command end to end: the episode that compare flies, in a window or in a file."""

import os
import signal
import sys

import numpy as np
import pytest
from PIL import Image, ImageSequence

from indoor_explorers.env import make_policy
from indoor_explorers.env.rendering.explained import HEIGHT
from indoor_explorers.env.rendering.window import Window, load_pygame
from indoor_explorers.evaluation.cli.watch import WatchedFlight
from indoor_explorers.evaluation.harness.episodes.runner import fly
from indoor_explorers.evaluation.harness.experiment.planning import plan
from indoor_explorers.evaluation.harness.experiment.request import ComparisonRequest
from tests.evaluation.cli.test_cli import PLUGINS, run, start


@pytest.fixture(autouse=True)
def _no_windows(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


@pytest.fixture
def shown(monkeypatch):
    """The shapes of the pictures that a window shows."""
    shapes, show = [], Window.show
    monkeypatch.setattr(Window, "show", lambda self, picture: (shapes.append(picture.shape), show(self, picture)))
    return shapes


WATCH = ["watch", "--policy", "frontier-minpos", "--scenario", "thesis-team-2"]


@pytest.mark.parametrize("policy", ["random", "frontier-minpos", "pso", "dddqn"])
@pytest.mark.parametrize("seed", [0, 5])
def test_the_episode_is_the_one_that_compare_flies(policy, seed):
    """Messages and batched policies included."""
    experiment = plan(ComparisonRequest(policies=[policy], scenario="thesis-team-4", episodes=1, seed=seed))
    scenario = experiment.scenarios[0]
    (record,) = fly(make_policy(policy), policy, scenario, experiment.tasks())
    watched, cells, covered = WatchedFlight(experiment, 0, None), [], []
    for _ in watched.moments():
        cells.append(watched.world.state.cell[0].copy())
        covered.append(int(watched.world.state.team_covered[0]))
    assert np.array_equal(np.array(cells), record.cells)
    assert np.array_equal(covered, record.covered[:, 0])


def test_a_gif_has_a_frame_for_each_step(capsys, tmp_path):
    path = tmp_path / "new" / "film.gif"
    status, printed, errors = run(capsys, *WATCH, "--steps", "9", "--fps", "5", "--save", path)
    assert (status, errors) == (0, "")
    with Image.open(path) as image:
        assert f"Saved: {path} (10 frames of {image.width} x {image.height} pixels)" in printed
        assert (image.n_frames, image.info["duration"]) == (10, 200)
    assert "frontier-minpos on thesis-team-2, seed 0: step 9 of 400, coverage" in printed


def test_a_video_of_a_map_file(capsys, tmp_path):
    import av

    pixels = np.full((24, 41), 254, np.uint8)
    pixels[[0, -1]] = pixels[:, [0, -1]] = pixels[4:20, 20] = 0
    Image.fromarray(pixels).save(tmp_path / "flat.png")
    words = ["watch", "--policy", "frontier-nearest", "--maps", tmp_path / "flat.png", "--team", "2"]
    path = tmp_path / "film.mp4"
    status, printed, errors = run(capsys, *words, "--set", "lidar.range=4", "--steps", "6", "--save", path)
    assert (status, errors) == (0, "")
    assert "frontier-nearest on flat, seed 0: step 6 of " in printed
    with av.open(str(path)) as container:
        assert len(list(container.decode(video=0))) == 7


def test_a_still_is_the_end_of_the_episode(capsys, tmp_path):
    path = tmp_path / "end.png"
    status, printed, _ = run(capsys, "watch", "--policy", "pso", "--seed", "3", "--save", path)
    assert status == 0
    assert "coverage 100.0%" in printed
    with Image.open(path) as image:
        assert image.format == "PNG"


def test_the_window_shows_every_step(capsys, shown):
    status, printed, errors = run(capsys, *WATCH, "--steps", "5", "--fps", "1000")
    assert (status, errors) == (0, "")
    assert len(shown) == 6
    assert len(set(shown)) == 1
    assert "step 5 of" in printed
    assert not load_pygame().display.get_init()


def test_a_film_explains_a_uav_in_lines_below(capsys, tmp_path):
    films = [tmp_path / "plain.gif", tmp_path / "told.gif"]
    for path, more in zip(films, ([], ["--explain", "1"]), strict=True):
        status, _, errors = run(capsys, *WATCH, "--steps", "6", *more, "--save", path)
        assert (status, errors) == (0, "")
    frames = []
    for path in films:
        with Image.open(path) as film:
            frames.append([np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(film)])
    assert {frame.shape[0] for frame in frames[1]} == {frames[0][0].shape[0] + HEIGHT}
    height = frames[0][0].shape[0]
    below = [np.count_nonzero(frame[height:] < 200) for frame in frames[1]]
    assert below[0] < below[1] / 2
    changed = [
        np.abs(told[:height].astype(int) - plain).max(axis=2) > 60 for told, plain in zip(*frames[::-1], strict=True)
    ]
    assert np.count_nonzero(changed[0]) == 0
    assert all(np.count_nonzero(each) > 50 for each in changed[1:])


def test_a_key_explains_one_uav_after_the_other(capsys, shown, monkeypatch):
    pygame, show = load_pygame(), Window.show

    def show_and_press(self, picture):
        show(self, picture)
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=pygame.K_e))

    monkeypatch.setattr(Window, "show", show_and_press)
    status, _, errors = run(capsys, *WATCH, "--steps", "5", "--fps", "1000")
    assert (status, errors) == (0, "")
    heights = [shape[0] for shape in shown]
    assert [height - min(heights) for height in heights] == [0, 0, HEIGHT, HEIGHT, 0, HEIGHT]


def test_explaining_does_not_change_the_flight():
    experiment = plan(ComparisonRequest(policies=["pso"], scenario="thesis-team-4", episodes=1, seed=2))
    ends = []
    for explaining in (False, True):
        watched = WatchedFlight(experiment, 0, 12, explaining=explaining)
        for _ in watched.moments():
            told = watched.explanations()
        ends.append(watched.world.state.cell[0].tolist())
        assert any(each.candidates for each in told) == explaining
    assert ends[0] == ends[1]


def test_closing_the_window_ends_the_flight(capsys, monkeypatch):
    pygame, show = load_pygame(), Window.show

    def show_and_close(self, picture):
        show(self, picture)
        if pygame.display.get_init():
            pygame.event.post(pygame.event.Event(pygame.QUIT))

    monkeypatch.setattr(Window, "show", show_and_close)
    status, printed, errors = run(capsys, *WATCH, "--fps", "1000")
    assert (status, errors) == (0, "")
    assert ": step 1 of" in printed


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--save", "film.avi"], "film.avi: expected a name that ends in .png, .gif or .mp4"),
        (["--save", "file/film.gif"], "its folder cannot be made"),
        (["--policy", "frontier-minpso"], "unknown policy 'frontier-minpso'; did you mean"),
        (["--scenario", "thesis-team-3"], "unknown scenario 'thesis-team-3'"),
        (["--resolution", "0.1"], "expected --maps with --resolution"),
        (["--steps", "0"], "expected a whole number of at least 1, got '0'"),
        (["--fps", "0"], "expected a number of frames a second"),
        (["--set", "gaol=1"], "did you mean 'goal'"),
        (["--maps", "nowhere.yaml"], "nowhere.yaml"),
        (["--explain", "2"], "expected --explain from 0 to 1, got 2"),
        (["--policy", "frontier,pso", "--explain", "0"], "expected one policy to explain, got 2"),
    ],
)
def test_a_usage_error_is_one_line_and_status_2(words, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    status, printed, errors = run(capsys, *WATCH, *words)
    assert (status, printed) == (2, "")
    assert errors.count("\n") == 1
    assert message in errors
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_policy_must_be_named(capsys):
    status, _, errors = run(capsys, "watch")
    assert status == 2
    assert "the following arguments are required: --policy" in errors


def test_no_display_is_one_line_that_names_the_way_out(capsys, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    status, printed, errors = run(capsys, *WATCH)
    assert (status, printed, errors.count("\n")) == (2, "", 1)
    assert "use --save FILE.gif" in errors
    assert "render_mode" not in errors


@pytest.mark.parametrize(("name", "extra"), [("pygame", []), ("av", ["--save", "film.mp4"])])
def test_a_missing_library_is_one_line_that_names_the_extra(name, extra, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, name, None)
    status, _, errors = run(capsys, *WATCH, *extra)
    assert (status, errors.count("\n")) == (2, 1)
    assert "indoor-explorers[render]" in errors


@pytest.mark.parametrize(
    ("policy", "seed", "message"),
    [
        ("Raises", 0, "policy failed at step"),
        ("WrongAction", 0, "policy failed at step"),
        ("ExitsPython", 1, "ended the command: SystemExit: enough"),
    ],
)
def test_a_policy_that_fails_leaves_no_file(policy, seed, message, capsys, tmp_path):
    words = ["watch", "--policy", f"{PLUGINS}:{policy}", "--scenario", "thesis-team-2", "--seed", seed]
    status, _, errors = run(capsys, *words, "--save", tmp_path / "film.gif")
    assert (status, errors.count("\n")) == (1, 1)
    assert message in errors
    assert not list(tmp_path.iterdir())


def test_an_interrupted_film_leaves_nothing(tmp_path):
    running = start("watch", "--policy", f"{PLUGINS}:Slow", "--scenario", "office", "--save", tmp_path / "film.gif")
    assert running.stdout.readline().startswith("flying office")
    os.killpg(running.pid, signal.SIGINT)
    printed, errors = running.communicate(timeout=60)
    assert (running.returncode, printed, errors) == (130, "", "indoor-explorers: interrupted; nothing was written\n")
    assert not list(tmp_path.iterdir())


def test_policies_fly_side_by_side(capsys, tmp_path):
    path = tmp_path / "both.gif"
    words = ["watch", "--policy", "frontier-minpos,random", "--scenario", "thesis-team-2", "--steps", "12"]
    status, printed, errors = run(capsys, *words, "--frames", "8", "--save", path)
    assert (status, errors) == (0, "")
    with Image.open(path) as image:
        assert image.n_frames == 7  # the start, every second step
        assert image.width > 1.2 * image.height
    assert "flying thesis-team-2  \u00b7  2 policies  \u00b7  seed 0" in printed
    for policy in ("frontier-minpos", "random"):
        assert f"{policy} on thesis-team-2, seed 0: step 12 of 400, coverage" in printed
    status, _, errors = run(capsys, "watch", "--policy", ",".join(7 * ["random"]), "--save", path)
    assert (status, errors.count("\n")) == (2, 1)


def test_side_by_side_in_a_window(capsys, shown):
    words = ["watch", "--policy", "frontier-minpos,frontier-nearest", "--scenario", "thesis-open"]
    assert run(capsys, *words, "--steps", "3", "--fps", "1000")[0] == 0
    assert len(shown) == 4
    assert len(set(shown)) == 1
