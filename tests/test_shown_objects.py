"""What objects show of themselves: one line at a prompt, a small table and a drawing in a notebook."""

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import fuzzy
import robotics
from fuzzy.sketch import lines, table, titled


class Strict(HTMLParser):
    """Fails where tags do not match; keeps the text and the attributes that name something outside."""

    def __init__(self, html):
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.outside: list[str] = []
        self.feed(html)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.open.append(tag)
        self.outside += [name for name, _ in attrs if name in ("src", "href", "id", "class", "onclick")]

    def handle_startendtag(self, tag, attrs):
        assert tag == "polyline"

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


@pytest.fixture(scope="module")
def things():
    scenario = replace(robotics.load_scenario("three-cross"), title="<script>alert(1)</script>", duration=2.0)
    run = robotics.simulate(scenario, robotics.make_controller("right-of-way"), [3, 4], name="right-of-way")
    single = replace(robotics.load_scenario("lyapunov-sine"), duration=1.0)
    comparison = robotics.compare([single], ["fuzzy", "lyapunov"], [0])
    system = fuzzy.read_fis(fuzzy.find_fis("tracking"))
    return {"Scenario": scenario, "Run": run, "Comparison": comparison, "Sugeno": system}


def test_a_prompt_shows_one_line(things):
    assert {name: repr(thing) for name, thing in things.items()} == {
        "Scenario": "Scenario('three-cross', '<script>alert(1)</script>': team, 3 robots, 2 s)",
        "Run": "Run('three-cross' under 'right-of-way': 3 robots, 2 seeds, 3 to 4, 2 s in 41 samples)",
        "Comparison": "Comparison(lyapunov-sine: fuzzy, lyapunov; 1 seed)",
        "Sugeno": "Sugeno('tracking': distance, alpha, x_err, heading_err -> v, w; 16 rules)",
    }


def test_a_notebook_shows_a_table_in_its_own_colours(things):
    for name, thing in things.items():
        html = thing._repr_html_()
        assert len(html) < 30_000, name
        shown = Strict(html)
        assert shown.outside == [], name
        assert "script" not in html.replace("&lt;script&gt;", "").replace("&lt;/script&gt;", ""), name
        assert not re.search(r"#[0-9a-f]{3,6}\b|rgb\(|black|white", html), f"{name} has a colour of its own"
    tracking = Strict(things["Sugeno"]._repr_html_()).text
    assert "−11.48 to 11.48" in tracking
    assert "16 rules" in tracking
    comparison = things["Comparison"]
    mean = comparison.table.query("controller == 'lyapunov'")["rms_cross_track_m"].mean()
    assert f"{mean:.4g}" in Strict(comparison._repr_html_()).text


def test_a_drawing_keeps_to_its_size_and_its_points():
    drawn = lines([[(0.0, 0.0), (2.0, 1.0), (float("nan"), 5.0)]], [[(1.0, -1.0)]], size=(106.0, 206.0), equal=True)
    assert 'width="106" height="106"' in drawn  # 2 m by 2 m on a square of 100 pixels, with a margin of 3
    assert re.findall(r'points="([^"]*)"', drawn) == ["53.0,103.0", "3.0,53.0 103.0,3.0"]
    assert lines([[(np.nan, 0.0)]], size=(10.0, 10.0)) == ""
    assert "<td" in table((), [["a<b", drawn]])
    assert "a&lt;b" in table((), [["a<b", drawn]])
    assert "<thead>" not in table((), [["a"]])
    assert titled("<t>", "-1 to 1", "<p>x</p>") == "<div><b>&lt;t&gt;</b> −1 to 1<p>x</p></div>"


@pytest.mark.long  # loads torch
def test_a_system_in_training_is_drawn():
    torch = pytest.importorskip("torch")
    near = fuzzy.Triangle(torch.tensor(0.0, requires_grad=True), 1.0, 2.0)
    system = fuzzy.Sugeno(
        [fuzzy.Variable("d", (0, 2), {"near": near})],
        [fuzzy.Variable("v", (0, 1), {"go": 1.0})],
        ["if d is near then v is go"],
    )
    assert "<polyline" in system._repr_html_()
