"""Moving pictures of a run: what is in a frame, when the frames are, and the files."""

import itertools
import json
import stat
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import same_color
from PIL import Image

from fuzzy.figures.drawing import COLORS, style
from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, YIELD
from robotics.plugins.films import animation
from robotics.plugins.films.animation import AnimationError, check_animation, frame_times, write_animation
from robotics.plugins.films.scene import Scene, set_scene, show_frame
from robotics.show.playback.replay import replay
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run, load_run
from robotics.simulation.scenario.reading import parse_scenario
from robotics.simulation.spans import ReplayError
from robotics.world.environment.world import Disc, Geometry, Polygon, Wall, World, box, compile_world
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.faults import FAULTS
from tests.drawn import x_of
from tests.robotics.show.playback.test_player import ROBOTS, Page, times

TEAM = f"""
kind = "team"
duration = 12.0
controller = "virtual-structure-virtual"
[radio]
graph = "star"
[[faults]]
robot = 2
kind = "failure"
start = 3.0
duration = 2.0
[[faults]]
robot = 3
kind = "delay"
start = 6.0
duration = 1.5
[[faults]]
robot = 1
kind = "silence"
start = 8.0
duration = 1.0
[[faults]]
robot = 2
kind = "stall"
start = 9.2
duration = 0.6
{ROBOTS}"""


@pytest.fixture(scope="module")
def run() -> Run:
    scenario = parse_scenario(TEAM, "three")
    return simulate(scenario, make_controller(scenario.controller), (4, 7), name=scenario.controller, message_ages=True)


@pytest.fixture(scope="module")
def file(run: Run, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("run") / "run.npz"
    run.save(path)
    return str(path)


@pytest.fixture
def styled() -> Iterator[None]:
    with style():
        yield


def scene_of(run: Run, seed: int | None = 7) -> Scene:
    return set_scene(replay(run, run.time, seed), 1.0, 60)


def vertices(collection: object) -> np.ndarray:
    return np.array([path.vertices[:4] for path in collection.get_paths()])  # type: ignore[attr-defined]


# A replay -------------------------------------------------------------------------------------------------------


def test_between_samples_a_robot_is_between_its_places(run: Run) -> None:
    film = replay(run, run.time, 4)
    for k, share in ((10, 0.0), (40, 0.5), (100, 0.25)):
        now = film.at(run.time[k] + 0.05 * share)
        for name in ("x", "y", "v", "w", "x_target"):
            wanted = (1 - share) * run[name][0, :, k] + share * run[name][0, :, k + 1]
            np.testing.assert_allclose(getattr(now, name), wanted, atol=1e-12)
    np.testing.assert_array_equal(film.at(99.0).x, run["x"][0, :, -1])
    few = replay(run, np.array([1.0, 1.025, 2.0]), 4)
    np.testing.assert_allclose(few.x[:, 1], (run["x"][0, :, 20] + run["x"][0, :, 21]) / 2)


def test_a_heading_that_wraps_does_not_spin(run: Run) -> None:
    samples = run.samples.copy()
    turning = 3.0 + 0.3 * run.time
    samples[:, 2] = ((turning + np.pi) % (2 * np.pi) - np.pi)[:, None, None]
    film = replay(run.with_recorded(samples=samples), run.time)
    np.testing.assert_allclose(np.diff(film.heading, axis=1), 0.015, atol=1e-9)


def test_a_run_that_is_no_team_has_the_reference_for_a_target() -> None:
    scenario = parse_scenario(
        TEAM.replace('kind = "team"', "").replace('controller = "virtual-structure-virtual"', ""), "x"
    )
    run = simulate(replace(scenario, faults=()), make_controller("lyapunov"), (0,))
    film = replay(run, run.time)
    np.testing.assert_array_equal(film.x_target, run.target("x"))
    assert film.progress is None
    assert film.hears is None
    assert film.faults == ()


# A frame --------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("styled")
@pytest.mark.parametrize("time", [1.0, 3.5, 11.0])
def test_robots_are_where_they_were_to_scale(run: Run, time: float) -> None:
    scene = scene_of(run)
    assert scene.enlarged == 1.0
    show_frame(scene, time)
    k = round(time / 0.05)
    bodies, heading = vertices(scene.bodies), run["heading"][1, :, k]
    np.testing.assert_allclose(
        bodies.mean(axis=1), np.stack([run["x"][1, :, k], run["y"][1, :, k]], axis=-1), atol=1e-9
    )
    sides = np.linalg.norm(np.diff(bodies, axis=1), axis=-1)
    np.testing.assert_allclose(sides, np.tile([0.23, 0.20, 0.23], (3, 1)))
    along = bodies[:, 1] - bodies[:, 0]
    np.testing.assert_allclose(along, 0.23 * np.stack([np.cos(heading), np.sin(heading)], axis=-1), atol=1e-9)
    # The mark points ahead: its tip is farther along the heading than the rest of it.
    marks = vertices(scene.marks)
    forward = np.einsum("rpi,ri->rp", marks, along / 0.23)
    assert (forward.argmax(axis=1) == 0).all()
    targets = np.stack([run["x_target"][1, :, k], run["y_target"][1, :, k]], axis=-1)
    np.testing.assert_allclose(np.asarray(scene.targets.get_offsets()), targets, atol=1e-9)
    for i, trail in enumerate(scene.trails.get_segments()):
        np.testing.assert_allclose(trail[:-1], np.stack([run["x"][1, i], run["y"][1, i]], axis=-1)[: k + 1], atol=1e-12)
    assert x_of(scene.cursor)[0] == time
    assert scene.clock.get_text() == f"t = {time:6.2f} s"


@pytest.mark.usefixtures("styled")
def test_faults_are_hatched_and_named(run: Run) -> None:
    scene = scene_of(run)
    seen = {}
    for time in (1.0, 4.0, 7.0, 8.5, 9.5, 11.0):
        show_frame(scene, time)
        hatched = {kind: len(c.get_paths()) for kind, c in scene.hatched.items()}
        seen[time] = ([label.get_text() for label in scene.labels], hatched)
    none = dict.fromkeys(FAULTS, 0)
    assert seen[1.0] == seen[11.0] == (["1", "2", "3"], none)
    assert seen[4.0] == (["1", "2: failure", "3"], none | {"failure": 1})
    assert seen[7.0] == (["1", "2", "3: delay"], none | {"delay": 1})
    assert seen[9.5] == (["1", "2: stalled", "3"], none | {"stall": 1})
    # Robot 1 is the hub: when it is silent, everyone is.
    assert seen[8.5][0][0] == "1: silent"
    assert seen[8.5][1]["silence"] == sum("silent" in text for text in seen[8.5][0])
    assert len({c.get_hatch() for c in scene.hatched.values()}) == len(FAULTS)


@pytest.mark.usefixtures("styled")
def test_a_standing_robot_is_an_outline(run: Run) -> None:
    scene = scene_of(run)
    show_frame(scene, 2.0)
    faces = np.asarray(scene.bodies.get_facecolor())
    assert all(same_color(face, color) for face, color in zip(faces, COLORS, strict=False))
    show_frame(scene, 12.0)
    standing = np.abs(run["v"][1, :, -1]) < 0.005
    assert standing.any()
    for face, still in zip(np.asarray(scene.bodies.get_facecolor()), standing, strict=True):
        assert same_color(face, "white") == still


@pytest.mark.usefixtures("styled")
def test_messages_are_half_lines_fresh_or_dashed(run: Run) -> None:
    scene, film = scene_of(run), replay(run, run.time, 7)
    for time in (2.0, 4.0):
        show_frame(scene, time)
        k = round(time / 0.05)
        places = np.stack([run["x"][1, :, k], run["y"][1, :, k]], axis=-1)
        wanted: dict[bool, list[np.ndarray]] = {True: [], False: []}
        for i, j in itertools.permutations(range(3), 2):
            if 0 in (i, j):  # a star around robot 1
                old = bool(run.message_ages[k, 1, i, j] > film.stale_after)
                wanted[old].append(np.array([places[i], (places[i] + places[j]) / 2]))
        for old, drawn in ((True, scene.old), (False, scene.fresh)):
            assert len(drawn.get_segments()) == len(wanted[old]) == (0, 4, 2, 2)[2 * (time == 4.0) + (not old)]
            np.testing.assert_allclose(
                np.reshape(drawn.get_segments(), (-1, 2, 2)), np.reshape(wanted[old], (-1, 2, 2))
            )
    dashed: Any = scene.old.get_linestyle()
    solid: Any = scene.fresh.get_linestyle()
    assert dashed[0][1] is not None
    assert solid[0][1] is None


@pytest.mark.usefixtures("styled")
def test_a_stopped_robot_is_crossed_out(run: Run) -> None:
    samples, team, stopped = run.samples.copy(), run.team.copy(), run.stopped.copy()
    samples[100:, :, 1, 2], team[100:, :, 1, 2], stopped[1, 2] = np.nan, np.nan, 100
    scene = scene_of(replace(run, stopped=stopped).with_recorded(samples=samples, team=team))
    show_frame(scene, 4.0)
    assert len(x_of(scene.stops)) == 0
    show_frame(scene, 9.5)
    assert list(x_of(scene.stops)) == [pytest.approx(run["x"][1, 2, 99])]
    assert scene.labels[2].get_text() == "3: stopped"


@pytest.mark.usefixtures("styled")
def test_robots_of_a_large_scene_are_enlarged_and_it_says_so(run: Run) -> None:
    samples = run.samples.copy()
    samples[:, :2] *= 30
    scene = scene_of(replace(run, paths=tuple(30 * p for p in run.paths)).with_recorded(samples=samples))
    assert scene.enlarged > 2
    show_frame(scene, 5.0)
    sides = np.linalg.norm(np.diff(vertices(scene.bodies), axis=1), axis=-1)
    np.testing.assert_allclose(sides[:, 0], 0.23 * scene.enlarged)
    assert any(f"{scene.enlarged:.1f} times their size" in text.get_text() for text in scene.figure.texts)
    assert any("robots to scale" in text.get_text() for text in scene_of(run).figure.texts)


# Files ----------------------------------------------------------------------------------------------------------


def test_frames_are_evenly_spaced_and_end_at_the_end(run: Run) -> None:
    timing = frame_times(run, "mp4", start=1.0, end=9.0, fps=10, speed=2)
    np.testing.assert_allclose(timing.times, np.arange(41) * 0.2 + 1)
    assert frame_times(run, "mp4", fps=7, speed=3).times[-1] == 12.0
    assert frame_times(run, "mp4").speed == 1.0
    long = replace(run, time=run.time * 10)
    assert frame_times(long, "mp4").speed == 5.0  # the least of 1, 2, 5 that ends within 25 s
    assert len(frame_times(long, "mp4").times) == 120 * 20 / 5 + 1
    assert frame_times(run, "gif", fps=30).fps == pytest.approx(100 / 3)  # 3 hundredths of a second


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fps": 0.0}, "fps must be >= 0.001 and <= 50 for a .gif, got 0"),
        ({"speed": float("nan")}, "speed must be >= 0.001 and <= 10000 for a .gif, got nan"),
        ({"dpi": 5}, "dpi must be >= 20 and <= 600, got 5"),
        ({"speed": 0.001}, "are too many for a .gif: raise speed"),
        ({"start": 5.0, "end": 5.0}, "from must be before to"),
        ({"seed": 1}, "seed 1 is not among those of the run: 4, 7"),
    ],
)
def test_wrong_options_are_said(run: Run, tmp_path: Path, options: dict[str, float], message: str) -> None:
    with pytest.raises((AnimationError, ReplayError), match=message):
        write_animation(run, tmp_path / "x.gif", **options)  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


def test_gif_has_the_frames_and_the_same_bytes_again(
    file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.gif"
    command = ["animate", file, "--seed", "7", "--from", "2", "--to", "5", "--fps", "4", "--dpi", "50", "-q"]
    assert main([*command, "-o", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}: 13 frames, 3.2 s, 1 times real time, robots to scale\n"
    assert main([*command, "-o", str(tmp_path / "b.gif"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["frames"], said["fps"], said["enlarged"]) == (13, 4.0, 1.0)
    assert out.read_bytes() == (tmp_path / "b.gif").read_bytes()
    with Image.open(out) as picture:
        assert picture.n_frames == 13  # type: ignore[attr-defined]
        assert picture.info["duration"] == 250
        assert picture.size[0] == pytest.approx(7.16 * 50, abs=1)
        frames = []
        for k in range(13):
            picture.seek(k)
            frames.append(np.asarray(picture.convert("RGB")).astype(int))
    assert (frames[0][:3, :3] == 255).all()
    assert all((a != b).any() for a, b in itertools.pairwise(frames))
    # Robot 1's blue moves to the right along its path, frame by frame until it stops.
    blue = np.array([0, 114, 178])
    top = frames[0].shape[0] // 3
    right = [np.nonzero((np.abs(f[:top] - blue) < 30).all(axis=-1).any(axis=0))[0].max() for f in frames]
    assert right == sorted(right)
    assert right[-1] > right[0] + 20


def test_many_robots_are_drawn_too(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    robots = "".join(
        f"[[robots]]\nstart = [{x}, {y}, 0.0]\ntiming = {{ duration = 20.0 }}\n"
        f'path = {{ shape = "quintic", start = [{x}, {y}], end = [{x + 4}, {y + 1}] }}\n'
        for x, y in np.round(rng.uniform(0, 10, (30, 2)), 2).tolist()
    )
    text = f'kind = "team"\nplant = "kinematic"\nduration = 2.0\ncontroller = "cooperation"\n{robots}'
    scenario = parse_scenario(text, "thirty")
    run = simulate(scenario, make_controller("cooperation"), (0,), message_ages=True)
    written = write_animation(run, tmp_path / "x.gif", fps=2, dpi=40)
    assert written.frames == 5
    with style():
        scene = scene_of(run, None)
        show_frame(scene, 1.0)
    assert len(scene.bodies.get_paths()) == 30
    assert [label.get_text() for label in scene.labels] == [""] * 30
    assert scene.fresh.get_segments() == []  # 870 links would hide the robots


def fake_ffmpeg(folder: Path, body: str) -> str:
    program = folder / "ffmpeg"
    program.write_text(f"#!{sys.executable}\nimport sys\n{body}\n", encoding="utf-8")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return str(program)


def test_mp4_gives_ffmpeg_every_frame(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out"
    out.mkdir()
    keep = "open(sys.argv[-1], 'wb').write(sys.stdin.buffer.read())"
    program = fake_ffmpeg(tmp_path, f"{keep}; open(sys.argv[0] + '.args', 'w').write('|'.join(sys.argv))")
    monkeypatch.setattr(animation, "ffmpeg", lambda: program)
    ticks: list[None] = []

    def progress(frames: int):
        assert frames == 5
        return lambda: ticks.append(None)

    write_animation(run, out / "x.mp4", 7, start=2.0, end=4.0, fps=4, speed=2, dpi=41, progress=progress)
    assert len(ticks) == 5
    given = (tmp_path / "ffmpeg.args").read_text(encoding="utf-8").split("|")
    width, height = map(int, given[given.index("-s") + 1].split("x"))
    assert (width % 2, height % 2) == (0, 0)
    assert float(given[given.index("-framerate") + 1]) == 4
    frames = np.frombuffer((out / "x.mp4").read_bytes(), dtype=np.uint8).reshape(-1, height, width, 4)
    assert len(frames) == 5
    assert all((a != b).any() for a, b in itertools.pairwise(frames))


def test_what_ffmpeg_says_when_it_fails_is_one_message(
    file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    program = fake_ffmpeg(tmp_path, "print('unknown encoder', file=sys.stderr); sys.exit(1)")
    monkeypatch.setattr(animation, "ffmpeg", lambda: program)
    out = tmp_path / "out"
    out.mkdir()
    assert main(["animate", file, "-o", str(out / "x.mp4"), "--to", "3", "--fps", "1", "-q"]) == 2
    assert capsys.readouterr().err == "robotics: ffmpeg could not write the .mp4: unknown encoder\n"
    assert list(out.iterdir()) == []


def test_without_ffmpeg_one_sentence_names_what_works(
    file: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(animation.shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert animation.ffmpeg() is None
    assert main(["animate", file, "-o", str(tmp_path / "x.mp4")]) == 2
    message = capsys.readouterr().err
    assert message.count("\n") == 1
    for word in ("ffmpeg", ".gif", ".html", "pip install 'imageio-ffmpeg>="):
        assert word in message


@pytest.mark.skipif(animation.ffmpeg() is None, reason="no ffmpeg here, nor the package imageio-ffmpeg")
def test_a_real_mp4(run: Run, tmp_path: Path) -> None:
    for name in ("a.mp4", "b.mp4"):
        write_animation(run, tmp_path / name, 7, end=2.0, fps=5, dpi=50)
    data = (tmp_path / "a.mp4").read_bytes()
    assert data[4:8] == b"ftyp"
    assert b"avc1" in data
    assert data == (tmp_path / "b.mp4").read_bytes()


def test_commands_say_what_is_wrong(file: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for wrong, message in (
        ([file, "-o", "x.avi"], "a moving picture needs a name that ends in .mp4, .gif or .html, got 'x.avi'"),
        ([str(tmp_path / "none.npz"), "-o", "x.gif"], "none.npz: cannot be read: No such file or directory"),
        ([file, "-o", "x.gif", "--from", "9", "--to", "3"], "the run lasts from 0 to 12 s"),
        ([file, "-o", str(tmp_path / "no" / "x.gif"), "--to", "1"], "there is no folder"),
        ([file, "-o", str(tmp_path / "x.html"), "--speed", "0"], "speed must be >= 0.001"),
    ):
        assert main(["animate", *wrong, "-q"]) == 2
        error = capsys.readouterr().err
        assert message in error
        assert "Traceback" not in error
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(AnimationError, match="write_player writes"):
        write_animation(load_run(file), tmp_path / "x.html")
    assert check_animation("A.GIF") == "gif"


def test_a_saved_team_has_its_messages(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "three.toml").write_text(TEAM, encoding="utf-8")
    save = tmp_path / "run.npz"
    assert main(["run", str(tmp_path / "three.toml"), "-c", "cooperation", "--save", str(save), "-q"]) == 0
    ages = load_run(save).message_ages
    assert ages is not None
    assert ages.shape == (241, 1, 3, 3)
    assert np.isfinite(ages[100, 0]).sum() == 4
    assert main(["run", "lyapunov-sine", "-c", "lyapunov", "--save", str(save), "-q"]) == 0
    assert load_run(save).message_ages is None
    assert (
        main(["animate", str(save), "-o", str(tmp_path / "one.gif"), "--to", "1", "--fps", "2", "--dpi", "40", "-q"])
        == 0
    )


# Among obstacles ------------------------------------------------------------------------------------------------


def among_obstacles(run: Run) -> Run:
    """The same run, as if a disc rested in it, a box moved through it, and its robots had had modes."""
    line = Line(start=(0.5, 2.0), end=(2.5, 2.0))
    moving = Polygon(corners=box(0.4, 0.2), path=line, timing=Timing(speed=0.1), orientation="fixed")
    wall = Wall(points=((2.5, -2.0), (2.5, 0.0)))
    world = compile_world(World(obstacles=(Disc(position=(1.0, -0.5), radius=0.2), moving, wall)))
    placed = Geometry(*(np.concatenate(parts) for parts in zip(*(world.at(t) for t in run.time), strict=True)))
    modes = np.zeros((len(run.time), 2, 3), dtype=np.int8)
    modes[40:80, 1, 0], modes[60:100, 1, 1], modes[90:, 1, 2] = AVOID, YIELD, FOLLOW + LEFT_BEHIND
    return replace(run, obstacles=placed).with_recorded(modes=modes)


@pytest.mark.usefixtures("styled")
def test_obstacles_are_where_they_are_at_the_time(run: Run) -> None:
    scene = scene_of(among_obstacles(run))
    for time in (0.0, 3.0, 3.025, 9.0):
        show_frame(scene, time)
        disc, moved = (np.asarray(path.vertices) for path in scene.solids.get_paths())
        np.testing.assert_allclose(np.hypot(*(disc - (1.0, -0.5)).T), 0.2)
        np.testing.assert_allclose(moved[:4].mean(axis=0), (0.5 + 0.1 * time, 2.0), atol=1e-9)
        np.testing.assert_allclose(np.ptp(moved, axis=0), (0.4, 0.2), atol=1e-9)
        (wall,) = scene.walls.get_segments()
        np.testing.assert_allclose(wall, [(2.5, -2.0), (2.5, 0.0)])
    left, right, bottom, top = scene.film.bounds
    assert [left, right] == [0.0, pytest.approx(2.5)]
    assert [bottom, top] == [pytest.approx(-2.0), pytest.approx(2.1)]


@pytest.mark.usefixtures("styled")
def test_among_obstacles_robots_are_never_enlarged(run: Run) -> None:
    samples = run.samples.copy()
    samples[:, :2] *= 30
    large = replace(run, paths=tuple(30 * p for p in run.paths)).with_recorded(samples=samples)
    assert scene_of(large).enlarged > 2
    assert scene_of(replace(large, obstacles=among_obstacles(run).obstacles)).enlarged == 1.0


@pytest.mark.usefixtures("styled")
def test_modes_have_a_ring_and_a_word(run: Run) -> None:
    scene = scene_of(among_obstacles(run))
    seen = {}
    for time in (1.0, 2.0, 3.5, 11.9):
        show_frame(scene, time)
        seen[time] = [label.get_text() for label in scene.labels]
        busy = [i for i in range(3) if scene.film.mode_at(i, time)]
        middles = [ring.mean(axis=0) for ring in np.array(scene.rings.get_segments())[:, :-1]] if busy else []
        k = round(time / 0.05)
        assert len(middles) == len(scene.rings.get_segments()) == len(busy)
        for i, middle in zip(busy, middles, strict=True):
            np.testing.assert_allclose(middle, (run["x"][1, i, k], run["y"][1, i, k]), atol=1e-9)
    assert seen[1.0] == ["1", "2", "3"]
    assert seen[2.0] == ["1: avoiding", "2", "3"]
    assert seen[3.5] == ["1: avoiding", "2: failure", "3"]  # a fault is named before a mode
    assert seen[11.9] == ["1", "2", "3: following the wall, left behind"]
    assert [(e.time, e.robot, e.before, e.after) for e in scene.film.handovers] == [
        (2.0, 0, "tracking", "avoiding"),
        (3.0, 1, "tracking", "yielding"),
        (4.0, 0, "avoiding", "tracking"),
        (4.5, 2, "tracking", "following the wall, left behind"),
        (5.0, 1, "yielding", "tracking"),
    ]


def test_a_gif_among_obstacles_from_a_file(run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    among_obstacles(run).save(tmp_path / "run.npz")
    out = tmp_path / "x.gif"
    command = ["animate", str(tmp_path / "run.npz"), "--seed", "7", "--to", "4", "--fps", "1", "--dpi", "50", "-q"]
    assert main([*command, "-o", str(out)]) == 0
    assert "robots to scale" in capsys.readouterr().out
    with Image.open(out) as picture:
        frames = []
        for k in range(picture.n_frames):  # type: ignore[attr-defined]
            picture.seek(k)
            frames.append(np.asarray(picture.convert("RGB")).astype(int))
    # The grey of the box above all robots moves to the right.
    top = frames[0].shape[0] // 5
    grey = [np.nonzero((np.abs(f[18:top] - 209) < 12).all(axis=-1).sum(axis=0) > 3)[0].mean() for f in frames]
    assert grey == sorted(grey)
    assert grey[-1] > grey[0] + 5


def test_command_writes_a_page_or_nothing(run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run.save(tmp_path / "run.npz")
    source, page = str(tmp_path / "run.npz"), tmp_path / "page.html"
    assert (
        main(["animate", source, "-o", str(page), "--seed", "7", "--from", "2", "--to", "8", "--speed", "3", "--json"])
        == 0
    )
    said = json.loads(capsys.readouterr().out)
    assert said == {"file": str(page), "format": "html", "bytes": page.stat().st_size}
    given = json.loads(Page(page.read_text(encoding="utf-8")).scripts[0])
    assert (given["speed"], given["run"]["seed"], times(given["run"])[-1]) == (3.0, 7, 8.0)
    before = page.read_bytes()
    assert main(["animate", source, "-o", str(page), "--seed", "8"]) == 2
    assert "seed 8 is not among" in capsys.readouterr().err
    assert main(["animate", source, "-o", str(page), "--fps", "5"]) == 2
    assert "--fps belongs to .mp4 and .gif" in capsys.readouterr().err
    assert page.read_bytes() == before
    assert main(["animate", source, "-o", str(tmp_path / "no" / "page.html")]) == 2
    assert "there is no folder" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["page.html", "run.npz"]


def test_a_place_for_no_page_is_refused_before_the_work(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nowhere = tmp_path / "nowhere"
    assert main(["animate", "none.npz", "-o", f"{nowhere}/x.html"]) == 2
    error = capsys.readouterr().err
    assert f"{nowhere}/x" in error
    assert f"there is no folder {str(nowhere)!r} to write into" in error
