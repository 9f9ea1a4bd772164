"""The player of a run: what it packs, and what it does in a browser."""

import base64
import json
import re
import zlib
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fuzzy.esmodule import composed
from fuzzy.insight.explanation import explain
from robotics.laws.catalogue import make_controller
from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, MODES, YIELD
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.show.playback import player
from robotics.show.playback.player import player_data, player_fragment, player_script, write_player
from robotics.show.playback.replay import replay
from robotics.simulation.loop import simulate
from robotics.simulation.run import CHANNELS, TEAM_CHANNELS, Run
from robotics.simulation.scenario.reading import parse_scenario
from robotics.simulation.spans import ReplayError
from robotics.world.environment.world import Disc, Geometry, Polygon, Wall, World, box, compile_world
from robotics.world.paths.path import Circle, Line
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.sonar import SONAR
from robotics.world.vehicle.floor import Patch
from tests.robotics.handmade import handmade
from tests.robotics.show.playback.browser import CHROMIUM, Browser

ROBOTS = """
[[robots]]
start = [0.0, 1.0, 0.0]
path = { shape = "line", start = [0.0, 1.0], end = [2.0, 1.0] }
timing = { duration = 10.0 }
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [1.5, 0.0] }
timing = { duration = 10.0 }
[[robots]]
start = [0.0, -1.0, 0.0]
path = { shape = "quintic", start = [0.0, -1.0], end = [2.0, -1.5] }
timing = { duration = 10.0 }
"""
TEAM = f"""
kind = "team"
duration = 12.0
controller = "virtual-structure-virtual"
[radio]
graph = "star"
loss = 0.2
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
kind = "stall"
start = 8.0
duration = 1.0
{ROBOTS}"""


@pytest.fixture(scope="module")
def run() -> Run:
    scenario = parse_scenario(TEAM, "three")
    return simulate(scenario, make_controller(scenario.controller), (4, 7), name=scenario.controller, message_ages=True)


def large(robots: int, seconds: float) -> Run:
    """A run of so many robots that wander, made up."""
    rng = np.random.default_rng(0)
    time = np.arange(round(seconds / 0.05) + 1) * 0.05
    samples = np.zeros((len(time), len(CHANNELS), 1, robots))
    samples[:, :5, 0] = rng.normal(size=(len(time), 5, robots)).cumsum(axis=0) * 0.02
    team = np.zeros((len(time), len(TEAM_CHANNELS), 1, robots))
    team[:, 0] = np.linspace(0, 1, len(time))[:, None, None]
    team[:, 1:4] = samples[:, :3]
    paths = tuple(rng.normal(size=(2, 700)).cumsum(axis=1) * 0.01 for _ in range(robots))
    links = np.full((len(time), 1, robots, robots), 0.05, dtype=np.float32)
    links[400:600, 0, :, 1] = 0.05 * np.arange(1, 201)[:, None] if len(time) > 600 else 0.05
    links[:, 0, np.arange(robots), np.arange(robots)] = np.inf
    stopped = np.full((1, robots), -1)
    nowhere = np.zeros((6, len(time), robots))
    named = {"scenario": "many", "controller": "law"}
    return handmade((0,), time, samples, nowhere, paths, stopped, team=team, message_ages=links, **named)


@pytest.fixture(scope="module")
def world_run(run: Run) -> Run:
    """The same run, as if obstacles had been in it, one of them moving, and its robots had had sonars and modes."""
    line = Line(start=(0.5, 2.0), end=(2.5, 2.0))
    moving = Polygon(corners=box(0.4, 0.2), path=line, timing=Timing(speed=0.1), orientation="fixed")
    obstacles = (Disc(position=(1.0, -0.5), radius=0.2), moving, Wall(points=((2.5, -2.0), (2.5, 0.0))))
    world = compile_world(World(obstacles=obstacles))
    placed = Geometry(*(np.concatenate(parts) for parts in zip(*(world.at(t) for t in run.time), strict=True)))
    modes = np.zeros((len(run.time), 2, 3), dtype=np.int8)
    modes[20:40, 1, 0], modes[120:, 1, 1], modes[170:, 1, 2] = AVOID, YIELD, FOLLOW + LEFT_BEHIND
    ranges = np.full((len(run.time), 2, 3, 4), np.inf, dtype=np.float32)
    ranges[20:40, 1, 0, 1] = np.linspace(1.5, 0.5, 20)
    return replace(run, obstacles=placed).with_recorded(modes=modes, ranges=ranges)


def unpacked(packed: dict[str, Any]) -> np.ndarray:
    raw = np.frombuffer(base64.b64decode(packed["data"]), dtype="<i2")
    return np.where(raw == -32768, np.nan, packed["offset"] + packed["scale"] * raw)


def times(data: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(base64.b64decode(data["time"]), dtype="<f4")


# What is packed -------------------------------------------------------------------------------------------------


def test_channels_come_back_as_near_as_sixteen_bits_are(run: Run) -> None:
    data = player_data(run, 7)
    assert data["seed"] == 7
    np.testing.assert_allclose(times(data), run.time, atol=1e-5)
    for name, packed in data["channels"].items():
        if name.startswith("path"):
            continue
        values = run[name][1] if name != "heading" else np.unwrap(run[name][1])
        error = np.abs(unpacked(packed).reshape(3, -1) - values)
        assert error.max() <= packed["scale"] * 0.5001 + 1e-12
        assert packed["scale"] <= np.ptp(values) / 60_000 or np.ptp(values) == 0
    nodes = np.stack([unpacked(data["channels"][f"path_{c}"]).reshape(3, -1) for c in "xy"], axis=1)
    for mine, path in zip(nodes, run.paths, strict=True):
        np.testing.assert_allclose(mine[:, [0, -1]], path[:, [0, -1]], atol=1e-3)


def test_unknown_values_stay_unknown_and_a_stopped_robot_stays(run: Run) -> None:
    samples, team, stopped = run.samples.copy(), run.team.copy(), run.stopped.copy()
    samples[100:, :, 0, 2], team[100:, :, 0, 2], stopped[0, 2] = np.nan, np.nan, 100
    lost = replace(run, stopped=stopped).with_recorded(samples=samples, team=team)
    data = player_data(lost)
    assert data["stops"] == [None, None, 5.0]
    x = unpacked(data["channels"]["x"]).reshape(3, -1)
    np.testing.assert_allclose(x[2, 100:], run["x"][0, 2, 99], atol=data["channels"]["x"]["scale"])
    nothing = player_data(run.with_recorded(team=np.full_like(run.team, np.nan)))
    assert "progress" not in nothing["channels"]


def test_faults_are_spans(run: Run) -> None:
    assert player_data(run)["faults"] == [
        [0, "stall", 8.0, 9.0],
        [1, "failure", 3.0, 5.0],
        [2, "delay", 6.0, 7.5],
    ]


def test_stale_links_are_those_of_the_run_at_every_sample(run: Run) -> None:
    limit, ages = 0.2, run.message_ages[:, 1]
    film = replay(run, run.time, 7, limit)
    assert film.stale_after == limit
    heard = np.isfinite(ages).any(axis=0)
    np.testing.assert_array_equal(film.hears, heard)
    assert heard.sum() == 4  # a star of three
    some = 0
    for k, time in enumerate(run.time):
        receivers, senders, age = film.stale.at(time + 1e-6)
        found = {(int(i), int(j)): float(a) for i, j, a in zip(receivers, senders, age, strict=True)}
        old = heard & (ages[k] > limit + 1e-6)
        if time <= limit:  # the wait for the first message
            old &= np.isfinite(ages[k])
        assert set(found) == {(int(i), int(j)) for i, j in np.argwhere(old)}, time
        for (i, j), value in found.items():
            assert value == pytest.approx(float(ages[k, i, j]), abs=2e-6)
        some += len(found)
    assert some > 100


def test_stale_by_default_is_what_is_unusual(run: Run) -> None:
    limit = player_data(run)["stale_after"]
    assert 0.25 <= limit <= 0.5
    assert player_data(run.with_recorded(message_ages=None))["hears"] is None
    with pytest.raises(ReplayError, match="must be > 0 s, got -1"):
        player_data(run, stale=-1.0)


def test_obstacles_sonars_and_modes_come_back(world_run: Run) -> None:
    data = player_data(world_run, 7)
    places = {name: unpacked(data["obstacles"][name]).reshape(3, -1) for name in ("x", "y", "turn")}
    disc, moving, wall = data["obstacles"]["bodies"]
    assert disc == {"radius": 0.2, "solid": True}
    np.testing.assert_allclose(places["x"][1], 0.5 + 0.1 * world_run.time, atol=1e-4)
    np.testing.assert_allclose(places["turn"], 0.0, atol=1e-4)
    assert moving["solid"]
    assert not wall["solid"]
    np.testing.assert_allclose(np.ptp(moving["points"], axis=0), (0.4, 0.2), atol=1e-4)
    ends = np.add(wall["points"], [places["x"][2, 0], places["y"][2, 0]])
    np.testing.assert_allclose(ends, [(2.5, -2.0), (2.5, 0.0)], atol=1e-3)
    read = unpacked(data["sonar"]["readings"]).reshape(3, 4, -1)
    there = np.isfinite(read)
    np.testing.assert_array_equal(there, np.isfinite(np.moveaxis(world_run.ranges[:, 1], 0, -1)))
    np.testing.assert_allclose(read[0, 1, 20:40], np.linspace(1.5, 0.5, 20), atol=1e-4)
    ranges = [sensor.range for sensor in SONAR.values()]
    assert [[mount[4] for mount in robot] for robot in data["sonar"]["sensors"]] == [ranges] * 3
    codes = np.frombuffer(base64.b64decode(data["modes"]["codes"]), dtype=np.int8).reshape(3, -1)
    np.testing.assert_array_equal(codes, world_run.modes[:, 1].T)
    assert data["modes"]["words"] == list(MODES)
    times_and_who = [(event[0], event[1]) for event in data["modes"]["events"]]
    assert times_and_who == [(1.0, 0), (2.0, 0), (6.0, 1), (8.5, 2)]
    later = player_data(world_run, 7, start=1.5, end=7.0)
    assert [event[0] for event in later["modes"]["events"]] == [2.0, 6.0]
    rest = replace(world_run, obstacles=Geometry(*(part[:1] for part in world_run.obstacles)))
    assert unpacked(player_data(rest)["obstacles"]["x"]).shape == (3,)
    none = player_data(replace(world_run, obstacles=None).with_recorded(ranges=None, modes=None))
    assert none["obstacles"] is none["sonar"] is none["modes"] is None


def test_a_box_that_turns_is_packed_as_it_turns(run: Run) -> None:
    circle = Circle(radius=1.0)
    world = compile_world(World(obstacles=(Polygon(corners=box(0.4, 0.2), path=circle, timing=Timing(speed=0.3)),)))
    placed = Geometry(*(np.concatenate(parts) for parts in zip(*(world.at(t) for t in run.time), strict=True)))
    data = player_data(replace(run, obstacles=placed))["obstacles"]
    turn, x, y = (unpacked(data[name]) for name in ("turn", "x", "y"))
    np.testing.assert_allclose(turn, 0.3 * run.time, atol=2e-3)
    k, points = 160, np.array(data["bodies"][0]["points"])
    c, s = np.cos(turn[k]), np.sin(turn[k])
    drawn = points @ np.array([[c, s], [-s, c]]) + (x[k], y[k])
    np.testing.assert_allclose(drawn[:4], placed.segments[k, :, :2], atol=2e-3)


def test_no_more_frames_than_are_asked_for(run: Run) -> None:
    every, fewer = player_data(run, 7), player_data(run, 7, frames=100)
    assert len(times(every)) == 241
    assert times(fewer).tolist() == times(every)[::3].tolist()
    for name in ("x", "v", "y_target"):
        here, there = (unpacked(data["channels"][name]).reshape(3, -1) for data in (fewer, every))
        assert here == pytest.approx(there[:, ::3], abs=1e-3)


def test_a_part_of_the_time_and_a_seed_that_is_not_there(run: Run) -> None:
    part = times(player_data(run, start=2.0, end=4.0))
    assert (part[0], part[-1]) == (2.0, 4.0)
    with pytest.raises(ReplayError, match="seed 5 is not among those of the run: 4, 7"):
        player_data(run, 5)
    with pytest.raises(ReplayError, match="from 0 to 12 s, and from must be before to; got from 4 to 20 s"):
        player_data(run, start=4.0, end=20.0)


@pytest.mark.long
def test_pages_are_small(tmp_path: Path) -> None:
    write_player(large(3, 60), tmp_path / "three.html")
    assert (tmp_path / "three.html").stat().st_size < 200_000
    data = player_data(large(200, 60))
    frames = times(data)
    assert 100_000 / 200 * 0.5 < len(frames) <= 100_000 / 200 + 1
    assert (frames[0], frames[-1]) == (0.0, 60.0)
    assert len(json.dumps(data)) < 4_000_000
    fast = large(3, 2)
    assert len(times(player_data(replace(fast, time=fast.time / 5)))) == 41 // 5 + 1  # 100 Hz becomes 20


# The page -------------------------------------------------------------------------------------------------------


class Page(HTMLParser):
    """The tags of a page, and the text of its scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[str] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        (self.scripts if self.tags and self.tags[-1][0] == "script" and self.cdata_elem else self.words).append(data)


def test_names_are_text_and_never_markup(run: Run, tmp_path: Path) -> None:
    name = '</script><img src=x onerror=alert(1)> & "quotes" \' <!--'
    write_player(replace(run, about=replace(run.about, scenario=name, controller="<b>law</b>")), tmp_path / "page.html")
    page = Page((tmp_path / "page.html").read_text(encoding="utf-8"))
    assert {tag for tag, _ in page.tags} <= {
        "html",
        "head",
        "meta",
        "title",
        "style",
        "body",
        "main",
        "h1",
        "div",
        "p",
        "script",
    }
    title = f"<b>law</b> on {name}, seed 4"
    (label,) = [attributes["aria-label"] for _, attributes in page.tags if "aria-label" in attributes]
    assert label == f"Player: {title}"
    given = json.loads(page.scripts[0])
    assert given["run"]["title"] == title
    assert any(title in words for words in page.words)


def test_page_asks_for_nothing(run: Run, tmp_path: Path) -> None:
    write_player(run, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    page = Page(text)
    assert not any({"src", "href", "data", "action"} & set(attributes) for _, attributes in page.tags)
    assert not re.search(r"https?:|@import|url\(|\bfetch\(|XMLHttpRequest|\bimport\b", text)
    assert "default-src 'none'" in text
    write_player(run, tmp_path / "again.html")
    assert (tmp_path / "again.html").read_bytes() == (tmp_path / "page.html").read_bytes()


def whole(text: str) -> dict[str, Any]:
    """What a fragment holds, its arrays as base64: packed.js in Python."""
    raw = zlib.decompress(base64.b64decode(text))
    head = 4 + int.from_bytes(raw[:4], "little")

    def revived(value: dict[str, Any]) -> Any:
        if set(value) != {"packed"}:
            return value
        start, length, differences = value["packed"]
        part = raw[head + start : head + start + length]
        if differences:
            count, total, numbers = length // 2, 0, []
            for low, high in zip(part[:count], part[count:], strict=True):
                total = (total + low + 256 * high) % 65536
                numbers.append(total)
            part = np.array(numbers, "<u2").tobytes()
        return base64.b64encode(part).decode()

    return json.loads(raw[4:head], object_hook=revived)


def test_fragments_need_the_script_once(run: Run) -> None:
    fragments = player_fragment(run) + player_fragment(run, 7, start=1.0, end=2.0)
    page = Page(fragments + player_script())
    kinds = [attributes["type"] for tag, attributes in page.tags if tag == "script"]
    assert kinds == ["application/octet-stream", "application/octet-stream", "module"]
    assert whole(page.scripts[0])["run"] == json.loads(json.dumps(player_data(run)))
    assert whole(page.scripts[1])["run"] == json.loads(json.dumps(player_data(run, 7, start=1.0, end=2.0)))
    assert len(page.scripts[0]) < 0.6 * len(json.dumps(player_data(run)))
    assert player_script().count("entry.default.render(") == 1


# In a browser ---------------------------------------------------------------------------------------------------

TOOLS = """
const $ = (selector) => document.querySelector(selector), all = (selector) => [...document.querySelectorAll(selector)];
const slide = (t) => { const s = $("input[type=range]"); s.value = t; s.dispatchEvent(new Event("input")); };
const clock = () => parseFloat($(".clock").textContent);
const cells = () => all("tbody tr").map((row) => [...row.cells].map((cell) => cell.textContent));
const pixels = () => $(".fp-canvas canvas").toDataURL();
const choose = (label, value) => {
  const select = all("label").find((node) => node.textContent.startsWith(label)).querySelector("select");
  select.value = value;
  select.dispatchEvent(new Event("change"));
};
"""


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine (Debian: apt-get install chromium)")
    with Browser(tmp_path_factory.mktemp("browser")) as browser:
        yield browser


@pytest.fixture
def page(browser: Browser, run: Run, tmp_path: Path) -> Iterator[Browser]:
    """The player of the seed 7, just opened; at the end nothing has gone wrong and nothing was asked for."""
    write_player(run, tmp_path / "page.html", 7)
    browser.media()
    browser.size(1300, 900)
    yield visit(browser, tmp_path / "page.html")
    assert browser.problems == []
    assert browser.requests == [(tmp_path / "page.html").as_uri()]


def visit(browser: Browser, file: Path) -> Browser:
    browser.problems.clear()
    browser.requests.clear()
    browser.open(file)
    browser.js(TOOLS)
    return browser


def shown(run: Run, t: float) -> list[list[str]]:
    """What the readout says at ``t`` [s] of the seed 7, less the message column."""
    k = round(t / 0.05)
    words = {0: "driving", 1: "failure", 2: "delay", 4: "stalled"}
    rows = []
    for i in range(3):
        digits = {"x": 2, "y": 2, "heading": 2, "v": 2, "w": 2, "progress": 3}
        numbers = [float(run[name][1, i, k]) for name in digits]
        text = [f"{n:.{d}f}" for n, d in zip(numbers, digits.values(), strict=True)]
        state = words[int(run["fault"][1, i, k])]
        if state == "driving" and abs(numbers[3]) < 0.005 and abs(numbers[4]) < 0.05:
            state = "standing"
        rows.append([str(i + 1), *text, state])
    return rows


def near(found: list[list[str]], wanted: list[list[str]]) -> None:
    """The same words, and numbers to the last digit shown."""
    for mine, theirs in zip(found, wanted, strict=True):
        for a, b in zip(mine[: len(theirs)], theirs, strict=True):
            if re.fullmatch(r"-?\d+\.\d+", b):
                digit = 10.0 ** -len(b.split(".")[1])
                assert float(a.replace("−", "-")) == pytest.approx(float(b), abs=1.1 * digit)
            else:
                assert a == b


def test_the_slider_moves_the_robots(run: Run, page: Browser) -> None:
    near(page.js("cells()"), shown(run, 0.0))
    before = page.js("pixels()")
    page.js("slide(4)")
    near(page.js("cells()"), shown(run, 4.0))
    assert page.js("pixels()") != before
    assert page.js("clock()") == 4.0
    assert (
        page.js("$('input[type=range]').ariaValueText ?? $('input[type=range]').getAttribute('aria-valuetext')")
        == "4.00 s of 12 s"
    )
    assert "robot 2: failure" in page.js("$('.summary').textContent")
    page.js("slide(8.5)")
    near(page.js("cells()"), shown(run, 8.5))
    page.js("slide(4)")
    hears = [row[-1] for row in page.js("cells()")]
    assert hears[1] == f"1: {run.message_ages[80, 1, 1, 0]:.1f} s old"
    assert hears[2].startswith("1: ")


def test_keys_play_and_step(page: Browser) -> None:
    page.js("slide(9)")
    page.key("ArrowRight")
    assert page.js("clock()") == 10.0
    page.key("ArrowLeft", shift=True)
    assert page.js("clock()") == 0.0
    page.key("End")
    assert page.js("clock()") == 12.0
    page.key("Home")
    assert page.js("clock()") == 0.0
    page.key(" ")
    assert page.js("$('.play').textContent") == "Pause"
    page.until("clock() > 0.2")
    page.key(" ")
    assert page.js("$('.play').textContent") == "Play"
    still = page.js("clock()")
    assert page.js("new Promise((done) => setTimeout(() => done(clock()), 100))") == still
    page.js("choose('Speed', '50'); $('.play').click()")
    page.until("clock() === 12 && $('.play').textContent === 'Play'")


def test_chart_seeks_and_legend_toggles(page: Browser) -> None:
    page.js("choose('Chart', 'difference')")
    assert page.js("all('.keys span').map((span) => span.textContent)") == ["s1 − s2", "s1 − s3", "s2 − s3"]
    area = page.js("all('.fp-canvas canvas')[1].getBoundingClientRect().toJSON()")
    page.click(area["left"] + 48 + (area["width"] - 64) / 4, area["top"] + 50)
    assert page.js("clock()") == pytest.approx(3.0, abs=0.05)
    page.js("slide(4)")
    before = page.js("pixels()")
    page.js("all('tbody input')[1].click()")
    assert page.js("all('tbody tr').map((row) => row.classList.contains('hidden'))") == [False, True, False]
    assert page.js("pixels()") != before
    page.js("all('tbody input')[1].click()")
    assert page.js("pixels()") == before
    page.js("all('tbody tr')[2].cells[1].click()")
    assert page.js("all('tbody tr').map((row) => row.classList.contains('picked'))") == [False, False, True]


def test_the_mouse_picks_a_robot(page: Browser) -> None:
    page.js("slide(0)")
    hits = page.js("""(() => {
  const canvas = $(".fp-canvas canvas"), area = canvas.getBoundingClientRect(), hits = [[], [], []];
  const picked = () => all("tbody tr").findIndex((row) => row.classList.contains("picked"));
  for (let x = area.left; x < area.right; x += 10) for (let y = area.top; y < area.bottom; y += 10) {
    slide(0); // a click on a robot's way goes to when it was there
    canvas.dispatchEvent(new MouseEvent("click", { clientX: x, clientY: y }));
    if (picked() < 0) continue;
    hits[picked()].push([x, y]);
    all("tbody tr")[picked()].cells[1].click();
  }
  return hits;
})()""")
    middles = [np.mean(places, axis=0) for places in hits]
    # They start one above the other, 1 m apart, where it says so.
    assert np.ptp([x for x, _ in middles]) < 12
    down = np.diff([y for _, y in middles])
    assert down[0] == pytest.approx(down[1], abs=12)
    assert down.min() > 24
    before = page.js("pixels()")
    page.point(*middles[1])
    assert page.js("pixels()") != before
    page.click(*middles[1])
    assert page.js("all('tbody tr').map((row) => row.classList.contains('picked'))") == [False, True, False]


def test_every_control_has_a_name_and_shows_its_focus(page: Browser) -> None:
    named = "node.ariaLabel || (node.tagName === 'BUTTON' && node.textContent.trim()) || node.closest('label')"
    assert page.js(f"all('button, select, input').filter((node) => !({named})).length") == 0
    assert page.js("all('canvas').every((node) => node.ariaHidden === 'true' || node.ariaLabel.length > 20)")
    reached = set()
    for _ in range(12):
        page.key("Tab")
        reached.add(
            page.js("document.activeElement.tagName + ' ' + getComputedStyle(document.activeElement).outlineStyle")
        )
    assert {"BUTTON solid", "INPUT solid", "SELECT solid"} <= reached


@pytest.mark.parametrize("width", [390, 800, 1600])
def test_the_page_fits_its_window(page: Browser, width: int) -> None:
    page.size(width, 900)
    assert page.js("document.documentElement.scrollWidth") <= width
    assert page.js("Math.max(...all('.fp-root *').map((node) => node.getBoundingClientRect().right))") <= width
    assert (
        page.js("$('.fp-root').className.replace('fp-root', '').trim()")
        == {390: "narrow", 800: "", 1600: "wide"}[width]
    )


def test_a_dark_page_is_dark(page: Browser) -> None:
    paper = "getComputedStyle($('.fleet-player')).backgroundColor"
    assert page.js(paper) == "rgb(255, 255, 255)"
    page.js("window.before = pixels()")
    page.media(prefers_color_scheme="dark")
    page.until(f"{paper} === 'rgb(21, 24, 28)' && pixels() !== before")


def test_less_motion_if_one_asks_for_it(page: Browser) -> None:
    page.media(prefers_reduced_motion="reduce")
    page.key(" ")
    times = page.js(
        "new Promise((done) => { const seen = []; const look = () => { if (clock() !== seen.at(-1)) seen.push(clock());"
        " if (seen.length < 4) requestAnimationFrame(look); else done(seen); }; look(); })"
    )
    page.key(" ")
    assert min(np.diff(times)) > 0.45
    assert "two pictures a second" in page.js("$('.note').textContent")


@pytest.mark.long
def test_two_hundred_robots_and_several_players_on_a_page(run: Run, browser: Browser, tmp_path: Path) -> None:
    many = player_fragment(large(200, 60)) + player_fragment(run, 4)
    head = '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>x</title></head>'
    (tmp_path / "page.html").write_text(f"{head}<body>{many}{player_script()}</body></html>", encoding="utf-8")
    page = visit(browser, tmp_path / "page.html")
    page.until("all('.clock').length === 2")  # they are unpacked
    page.js("slide(25)")
    assert page.js("all('.clock').map((node) => parseFloat(node.textContent))") == [25.0, 0.0]
    assert page.js("all('.fleet-player')[0].querySelectorAll('.robots input').length") == 200
    assert page.js("all('tbody').map((body) => body.rows.length)") == [1, 3]
    page.js("choose('Robot in the table', '41')")
    assert page.js("$('tbody tr').cells[0].textContent") == "42"
    # Nobody hears anything new from robot 2 between 20 and 30 s.
    assert "199 of 39800 links are stale" in page.js("$('.summary').textContent")
    page.key(" ")
    assert page.js("$('.play').textContent") == "Play"  # among other things on a page space scrolls
    page.js("$('.fp-root').querySelector('input[type=range]').focus()")
    page.key(" ")
    assert page.js("$('.play').textContent") == "Pause"
    page.key(" ")
    assert page.js("all('.fp-waiting').length") == 0
    assert browser.problems == []


# Among obstacles ------------------------------------------------------------------------------------------------


@pytest.fixture
def world_page(browser: Browser, world_run: Run, tmp_path: Path) -> Iterator[Browser]:
    write_player(world_run, tmp_path / "world.html", 7)
    browser.media()
    browser.size(1300, 900)
    yield visit(browser, tmp_path / "world.html")
    assert browser.problems == []


def states(page: Browser) -> list[str]:
    return page.js("all('td[data-label=\"state\"]').map((cell) => cell.textContent)")


def test_modes_are_words_and_keys_go_to_hand_overs(world_page: Browser) -> None:
    found = []
    for _ in range(5):
        world_page.key("n")
        found.append(world_page.js("clock()"))
    assert found == [1.0, 2.0, 6.0, 8.5, 8.5]
    assert "robot 3: tracking → following the wall, left behind (" in world_page.js("$('.summary').textContent")
    assert states(world_page)[2] == "following the wall, left behind"
    world_page.key("p")
    assert world_page.js("clock()") == 6.0
    assert states(world_page)[1] == "yielding"
    world_page.js("slide(1.5)")
    assert states(world_page)[0] == "avoiding"
    marks = world_page.js("$('canvas.marks').getBoundingClientRect().toJSON()")
    slider = world_page.js("$('input[type=range]').getBoundingClientRect().toJSON()")
    assert (marks["left"], marks["width"]) == pytest.approx((slider["left"], slider["width"]))
    world_page.click(marks["left"] + 8 + (marks["width"] - 16) / 4, marks["top"] + 4)
    assert world_page.js("clock()") == pytest.approx(3.0, abs=0.05)


def test_sonar_cones_are_toggled(world_page: Browser) -> None:
    world_page.js("slide(1.5)")
    with_cones = world_page.js("pixels()")
    world_page.key("s")
    without = world_page.js("pixels()")
    assert with_cones != without
    label = "all('label').find((node) => node.textContent.includes('Sonar cones')).querySelector('input')"
    assert world_page.js(f"{label}.checked") is False
    world_page.js(f"{label}.click()")
    assert world_page.js("pixels()") == with_cones


def test_patches_of_the_floor_are_hatched_by_their_friction(browser: Browser, run: Run, tmp_path: Path) -> None:
    """Seen in a wide patch: lines across where it is slippery, and lines up where it is rough as well."""
    browser.media()
    browser.size(1300, 900)
    seen = []
    for friction in (None, 0.2, 3.0):
        corners = ((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0))
        patches = () if friction is None else (Patch(friction=friction, corners=corners),)
        write_player(replace(run, about=replace(run.about, patches=patches)), tmp_path / "floor.html", 7)
        page = visit(browser, tmp_path / "floor.html")
        assert ("hatched floor" in page.js("$('.note').textContent")) is (friction is not None)
        ways = """[0, 1].map((up) => {
          const canvas = $('.fp-canvas canvas'), copy = document.createElement('canvas');
          copy.width = canvas.width; copy.height = canvas.height;
          const pen = copy.getContext('2d', { willReadFrequently: true });
          pen.fillStyle = 'white'; pen.fillRect(0, 0, copy.width, copy.height); pen.drawImage(canvas, 0, 0);
          const long = (up ? canvas.height : canvas.width) - 160;
          const dots = pen.getImageData(80, 60, up ? 1 : long, up ? long : 1).data;
          const lights = Array.from({ length: long }, (_, k) => dots[4 * k] + dots[4 * k + 1] + dots[4 * k + 2]);
          return lights.filter((light, k) => k && Math.abs(light - lights[k - 1]) > 40).length;
        })"""
        seen.append(page.js(ways))
    assert browser.problems == []
    (across, up), (across_ice, up_ice), (across_rough, up_rough) = seen
    assert up_ice > up + 20
    assert across_ice < across + 20 < across_rough
    assert up_rough > up + 20


def test_the_moving_obstacle_moves(world_page: Browser) -> None:
    """Of what is drawn above all robots only the box changes: where it is darkest moves to the right by 0.9 m."""
    world_page.key("s")
    world_page.js("choose('Trail', '0')")
    world_page.js("slide(0)")
    middle = """(() => {
      const canvas = $('.fp-canvas canvas'), copy = document.createElement('canvas');
      copy.width = canvas.width; copy.height = canvas.height;
      const pen = copy.getContext('2d', { willReadFrequently: true }), row = Math.round(canvas.height * SHARE);
      pen.fillStyle = 'white'; pen.fillRect(0, 0, copy.width, copy.height); pen.drawImage(canvas, 0, 0);
      const dots = pen.getImageData(0, row, canvas.width, 1).data, dark = [];
      for (let x = 60; x < canvas.width - 20; x++) if (dots[4 * x] < 215 && dots[4 * x] > 190) dark.push(x);
      return dark.reduce((a, b) => a + b, 0) / dark.length;
    })()"""
    share = world_page.js("""(() => {
      const canvas = $('.fp-canvas canvas'), copy = document.createElement('canvas');
      copy.width = canvas.width; copy.height = canvas.height;
      const pen = copy.getContext('2d', { willReadFrequently: true }), inside = canvas.width / 3;
      pen.fillStyle = 'white'; pen.fillRect(0, 0, copy.width, copy.height); pen.drawImage(canvas, 0, 0);
      for (let y = 30; y < canvas.height / 2; y++) {
        const dots = pen.getImageData(45, y, canvas.width - 60, 1).data;
        let n = 0;
        for (let x = 0; x < dots.length; x += 4) n += dots[x] < 215 && dots[x] > 190;
        if (n > 20 && n < inside) return (y + 5) / canvas.height;
      }
      return null;
    })()""")
    assert 0 < share < 0.2  # above all robots
    places = []
    for time in (0, 3, 9):
        world_page.js(f"slide({time})")
        places.append(world_page.js(middle.replace("SHARE", str(share))))
    assert places[1] - places[0] > 10
    assert places[2] - places[0] == pytest.approx(3 * (places[1] - places[0]), abs=4)


def test_a_model_with_another_run_is_shown_anew(browser: Browser, run: Run, world_run: Run, tmp_path: Path) -> None:
    folder = Path(str(resources.files("robotics"))) / "show" / "playback" / "static"
    code = composed(folder / "player.js", "window.render = entry.default.render;")
    given = json.dumps([player_data(run, 7), player_data(world_run, 7, end=6.0), player_data(run, 4, end=8.0)])
    (tmp_path / "widget.html").write_text(
        f'<!doctype html><meta charset="utf-8"><div id="box" class="fleet-player"></div>'
        f'<script type="module">{code}\nwindow.given = {given};</script>',
        encoding="utf-8",
    )
    browser.media()
    browser.size(1300, 900)
    page = visit(browser, tmp_path / "widget.html")
    page.until("window.render !== undefined")
    page.js("""
      window.listeners = new Set();
      window.model = { run: given[0], get: (name) => (name === "run" ? model.run : undefined),
        on: (event, f) => { if (event === "change:run") listeners.add(f); },
        off: (event, f) => listeners.delete(f) };
      window.stop = render({ model, el: $("#box") });
    """)
    assert page.js("all('.fp-root').length") == 1
    assert page.js("all('canvas.marks').length") == 0
    page.js("slide(9)")
    page.js("model.run = given[1]; listeners.forEach((f) => f())")
    assert page.js("all('.fp-root').length") == 1
    assert page.js("all('canvas.marks').length") == 1
    assert page.js("clock()") == 6.0  # the new run ends there
    # A run of the same kind is shown in the same parts, as if they had been made for it.
    page.js("model.run = given[0]; listeners.forEach((f) => f()); slide(3); window.root = $('.fp-root')")
    page.js("$('button.play').click(); model.run = given[2]; listeners.forEach((f) => f())")
    assert page.js("[$('.fp-root') === root, $('button.play').textContent, $('input[type=range]').max]") == [
        True,
        "Play",
        "8",
    ]
    page.js("slide(5)")
    told = "[$('.fp-scene canvas').toDataURL(), $('.fp-side .fp-canvas canvas').toDataURL(), $('tbody').innerText]"
    page.js(f"window.same = {told}; stop(); window.stop = render({{ model, el: $('#box') }}); slide(5)")
    assert page.js("$('.fp-root') !== root")
    assert page.js(f"{told}.map((each, k) => each === same[k])") == [True, True, True]
    page.js("stop()")
    assert page.js("[all('.fp-root').length, listeners.size]") == [0, 0]
    # A model that never changes needs no on().
    page.js("window.stop = render({ model: { get: model.get }, el: $('#box') }); stop()")
    assert page.problems == []


# The rules that decide ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ruled() -> Run:
    """A team under a fuzzy law, whose robot 3 was lost after 5 s; and as if a second rule base had been asked."""
    scenario = parse_scenario(TEAM.replace("virtual-structure-virtual", "cooperation"), "three")
    run = simulate(scenario, make_controller("cooperation"), (4, 7), name="cooperation")
    bases = {**run.about.rule_bases, "lateral": load_rule_base("lateral")}
    inputs = np.concatenate([run.inputs, 0.3 * np.sin(run.time)[:, None, None, None] * np.ones((1, 2, 3))], axis=1)
    inputs[100:, :, 1, 2] = np.nan
    return replace(run, about=replace(run.about, rule_bases=bases)).with_recorded(inputs=inputs.astype(np.float32))


def told(run: Run, k: int, robot: int) -> list[list[tuple[int, float]]]:
    """The rules of each rule base that fire at a sample of the seed 7, by strength, as fuzzy explains them."""
    asked = run.inputs[k, :, 1, robot]
    found, first = [], 0
    for system in run.about.rule_bases.values():
        rows = explain(system, asked[first : first + len(system.inputs)]).rows
        first += len(system.inputs)
        found.append(sorted(((r.number, r.firing) for r in rows if r.firing > 0), key=lambda row: (-row[1], row[0])))
    return found


def test_the_strongest_rules_of_every_frame_are_those_of_explain(ruled: Run) -> None:
    rules = player_data(ruled, 7, start=2.0, end=8.0)["rules"]
    assert [base["task"] for base in rules["bases"]] == ["tracking", "lateral"]
    assert rules["bases"][1]["rules"][0] == str(ruled.about.rule_bases["lateral"].rules[0])
    assert rules["bases"][0]["inputs"][1] == ["alpha", "rad"]
    shape = (2, 3, 121, 3)
    numbers = np.frombuffer(base64.b64decode(rules["numbers"]), dtype="<u2").reshape(shape)
    strengths = np.frombuffer(base64.b64decode(rules["strengths"]), dtype=np.uint8).reshape(shape)
    for frame in (0, 7, 33, 59, 60, 120):
        for robot in range(3):
            if robot == 2 and frame >= 60:  # from 5 s on
                assert (numbers[:, robot, frame] == 65535).all()
                continue
            for b, fires in enumerate(told(ruled, 40 + frame, robot)):
                wanted = [*fires[:3], *[(0, 0.0)] * 3][:3]
                assert numbers[b, robot, frame].tolist() == [number for number, _ in wanted]
                np.testing.assert_allclose(strengths[b, robot, frame] / 255, [s for _, s in wanted], atol=0.5001 / 255)
    alpha = unpacked(rules["values"][1]).reshape(3, 121)
    np.testing.assert_allclose(alpha[:2], ruled.inputs[40:161, 1, 1, :2].T, atol=rules["values"][1]["scale"])


def test_rules_are_packed_only_where_there_are_some_and_small(
    ruled: Run, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert player_data(run)["rules"] is None
    about, inputs = ruled.about, np.zeros((1201, 20, 1, 3), dtype=np.float32)
    five = {str(n): load_rule_base("tracking") for n in range(5)}
    inputs[:, :, 0] = np.random.default_rng(0).normal(size=(1201, 20, 3))
    minute = replace(large(3, 60).with_recorded(inputs=inputs), about=replace(about, rule_bases=five))
    assert len(json.dumps(player_data(minute))) < 800_000
    monkeypatch.setattr(player, "_ANSWERS", 3 * 241 * 2 - 1)
    rules = player_data(ruled)["rules"]
    assert (rules["top"], rules["values"]) == (1, None)


@pytest.fixture
def ruled_page(browser: Browser, ruled: Run, tmp_path: Path) -> Iterator[Browser]:
    write_player(ruled, tmp_path / "rules.html", 7)
    browser.media()
    browser.size(1300, 900)
    page = visit(browser, tmp_path / "rules.html")
    page.js("""
      window.base = (n) => all(".fp-base")[n];
      window.rules = (n) => [...base(n).querySelectorAll("li")].map((row) => row.textContent).filter((text) => text);
      window.title = () => $(".fp-rules > summary").textContent;
    """)
    yield page
    assert browser.problems == []


def test_the_panel_says_which_rules_fire(ruled_page: Browser, ruled: Run) -> None:
    systems = list(ruled.about.rule_bases.values())
    for seconds, robot in ((2.5, 0), (4.0, 1), (4.0, 2)):
        ruled_page.js(f"slide({seconds}); choose('Rules of robot', '{robot}')")
        assert ruled_page.js("title()") == f"Rules that decide now: robot {robot + 1}"
        for b, fires in enumerate(told(ruled, round(seconds / 0.05), robot)):
            found = ruled_page.js(f"rules({b})")
            assert [re.sub(r"^[\d.]+ ", "", text) for text in found] == [
                f"rule {number}: {systems[b].rules[number - 1]}" for number, _ in fires[:3]
            ]
            strengths = [float(text.split()[0]) for text in found]
            assert strengths == pytest.approx([s for _, s in fires[:3]], abs=0.0075)  # two digits of 255ths
            bars = f"[...base({b}).querySelectorAll('.fp-bar')]"
            widths = ruled_page.js(f"{bars}.map((bar) => parseFloat(bar.style.width))")
            assert widths[: len(found)] == pytest.approx([100 * s for _, s in fires[:3]], abs=0.2)
    y_err = float(ruled.inputs[80, 4, 1, 2])
    assert ruled_page.js("base(1).querySelector('.fp-asked').textContent") == f"y_err {y_err:.3f} m".replace("-", "−")
    ruled_page.js("slide(6)")
    assert ruled_page.js("rules(1)") == ["no answer: an input is not a number"]


def test_the_robot_is_chosen_by_key_click_and_cursor(ruled_page: Browser) -> None:
    number = lambda: int(ruled_page.js("title()").split("robot ")[1][0])  # noqa: E731
    assert number() == 1
    found = []
    for _ in range(3):
        ruled_page.key("r")
        found.append(number())
    assert found == [2, 3, 1]
    x, y = ruled_page.js("""(() => {
      choose("Its path shows", "-1");
      slide(0);
      const canvas = $(".fp-canvas canvas"), copy = document.createElement("canvas");
      copy.width = canvas.width; copy.height = canvas.height;
      const pen = copy.getContext("2d");
      pen.drawImage(canvas, 0, 0);
      const dots = pen.getImageData(0, 0, canvas.width, canvas.height).data, xs = [], ys = [];
      for (let n = 0; n < dots.length / 4; n++) {
        if (dots[4 * n] !== 0 || dots[4 * n + 1] !== 158 || dots[4 * n + 2] !== 115) continue;  // robot 3's
        xs.push(n % canvas.width); ys.push(Math.floor(n / canvas.width));
      }
      const middle = (values) => values.reduce((a, b) => a + b) / values.length, at = canvas.getBoundingClientRect();
      return [at.left + middle(xs), at.top + middle(ys)];
    })()""")
    ruled_page.point(x, y)
    assert ruled_page.js("title()") == "Rules that decide now: robot 3 (under the cursor)"
    assert ruled_page.js("$('.fp-rules select').value") == "0"
    ruled_page.click(x, y)
    ruled_page.point(5, 5)
    assert ruled_page.js("title()") == "Rules that decide now: robot 3"
    assert ruled_page.js("$('.fp-rules select').value") == "2"


def test_the_path_shows_the_strongest_rule_until_the_panel_is_closed(ruled_page: Browser) -> None:
    ruled_page.js("slide(4)")
    seen = {}
    for base in ("-1", "0", "1"):
        ruled_page.js(f"choose('Its path shows', '{base}')")
        seen[base] = ruled_page.js("pixels()")
    assert len(set(seen.values())) == 3
    assert ruled_page.js("base(1).querySelector('.fp-dot').style.background") != "transparent"
    assert ruled_page.js("base(0).querySelector('.fp-dot').style.background") == "transparent"
    ruled_page.js("$('.fp-rules').open = false")
    ruled_page.until("pixels() !== " + json.dumps(seen["1"]))
    closed = ruled_page.js("pixels()")
    assert closed not in (seen["0"], seen["1"])
