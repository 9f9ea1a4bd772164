"""The site: what runs in the reader's browser, and, where it has been made, its links and its search.

`make docs` makes the site; the tests marked long look at it, and are skipped where it is not there.
"""

import json
import re
import tomllib
import warnings
from collections import Counter
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urldefrag

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import robotics
from fuzzy.esmodule import composed
from fuzzy.inference import InferenceWarning, infer
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.views import design_data
from tests.browsers import drag, rest, started
from tests.conftest import module_in
from tests.fuzzy.random_systems import systems

DOCS = Path(__file__).parent.parent / "docs"
SITE = DOCS / "_build" / "html"
PATIENCE = 120_000  # ms that a page with many figures may take on a loaded machine


def interactive() -> Any:
    return module_in(DOCS / "interactive" / "interactive.py")


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with started() as found:
        yield found


@pytest.fixture(scope="module")
def evaluate(browser: Any, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """The function of alone.js that says what the rules do at a point: (design, points) to outputs."""
    script = composed(DOCS / "interactive" / "alone.js", "window.evaluated = entry.evaluated; window.ready = true;")
    page_file = tmp_path_factory.mktemp("alone") / "alone.html"
    page_file.write_text(f'<meta charset="utf-8"><script type="module">{script}</script>', encoding="utf-8")
    page = browser.new_page()
    page.goto(page_file.as_uri())
    page.wait_for_function("window.ready")
    return lambda design, points: page.evaluate(
        "([design, points]) => points.map((point) => window.evaluated(design, point).output)", [design, points]
    )


@settings(
    max_examples=25,
    deadline=None,
    phases=(Phase.generate,),
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(fis=systems(), seed=st.integers(0, 99))
def test_rules_in_the_browser_answer_as_the_inference_does(evaluate: Any, fis: Any, seed: int) -> None:
    x = np.random.default_rng(seed).uniform(-3, 4, (12, len(fis.inputs)))
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore", InferenceWarning)
        layers = infer(fis, x)
        strengths = layers.firing @ (fis.structure.consequent >= 0).T.astype(float)
    found = np.array(evaluate(design_data(design_of(fis)), x.tolist()))
    clear = strengths > 1e-6  # of what hardly fires, differences of degrees have few digits
    scale = 1 + np.abs(layers.rule_outputs).max()
    assert (np.abs(found - layers.output)[clear] <= 1e-8 * scale / np.clip(strengths[clear], 1e-6, 1)).all()


def opened(browser: Any, file: Path, **options: Any) -> tuple[Any, list[str]]:
    """A page of a file, and what went wrong on it: errors, warnings, requests that leave the disk."""
    page, problems = browser.new_page(**options), []
    page.on("console", lambda m: problems.append(m.text) if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda r: None if r.url.startswith(("file:", "data:", "blob:")) else problems.append(r.url))
    page.goto(file.as_uri())
    return page, problems


def written(folder: Path, theme: str, part: str) -> Path:
    """A page of a theme that holds only a part of the site's."""
    head = f'<!doctype html><html lang="en" data-theme="{theme}"><meta charset="utf-8"><title>t</title>'
    file = folder / "page.html"
    file.write_text(f"{head}<body>{part}</body></html>", encoding="utf-8")
    return file


def test_a_membership_function_is_dragged_from_a_disk(browser: Any, tmp_path: Path) -> None:
    file = written(tmp_path, "light", interactive().designer())
    page, problems = opened(browser, file, viewport={"width": 900, "height": 1400})
    told = page.locator(".fd-told")
    before = told.inner_text()
    assert re.search(r"v = [\d.]+ m/s, w = [\d.]+ rad/s", before)
    # A slider is another element after each redrawing: each key is pressed on the one that is there
    for _ in range(12):
        page.get_by_role("slider", name="right: shoulder").press("ArrowRight")
    for _ in range(5):
        page.get_by_role("slider", name="bearing", exact=True).press("ArrowRight")
    page.wait_for_function("(text) => document.querySelector('.fd-told').innerText !== text", arg=before)
    # What only the designer does is not offered, in whichever variable is chosen.
    for variable in ("distance", "w"):
        page.get_by_role("button", name=variable, exact=True).click()
        assert page.locator(".fd-row").count() >= 2
        assert not page.get_by_role("button", name=re.compile("Add term|remove")).count()
        assert page.get_by_label(re.compile("^name of")).first.is_disabled()
        assert page.get_by_label(re.compile("^type of")).first.is_disabled()
    assert problems == []


def test_a_curve_and_the_point_are_dragged_by_mouse(browser: Any, tmp_path: Path) -> None:
    file = written(tmp_path, "dark", interactive().designer())
    page, problems = opened(browser, file, viewport={"width": 900, "height": 1400})
    told = page.locator(".fd-told")
    before = told.inner_text()

    def pull(name: str, by: float) -> None:
        drag(page, page.get_by_role("slider", name=name, exact=True), (by, 0), release=True)

    def turn(before: str) -> float:
        page.wait_for_function("(text) => document.querySelector('.fd-told').innerText !== text", arg=before)
        return float(re.sub(r".*w = ([−\d.]+) rad/s", r"\1", told.inner_text()).replace("−", "-"))

    pull("bearing", -40)  # to the right of the robot: it turns right
    turned, before = turn(before), told.inner_text()
    assert turned < 0
    pull("right: shoulder", -80)  # the term begins later: it turns less
    assert turned < turn(before) < 0
    assert problems == []


def test_a_player_follows_the_theme_of_its_page(browser: Any, tmp_path: Path) -> None:
    run = robotics.simulate(robotics.load_scenario("fuzzy-on-path"), "fuzzy", seeds=[1])
    file = written(tmp_path, "dark", interactive().players([("A run", run)]))
    page, problems = opened(browser, file, color_scheme="dark")
    page.get_by_role("button", name="Play").wait_for()
    looks = """() => {
        const player = document.querySelector(".fleet-player"),
          [view, strip] = [player.querySelector("canvas"), player.querySelector("canvas.rs-shares")];
        return [view.toDataURL(), strip.toDataURL(), getComputedStyle(player).colorScheme];
    }"""
    found = []
    for theme in ("dark", "light", "dark"):
        page.evaluate("(theme) => { document.documentElement.dataset.theme = theme; }", theme)
        rest(page)
        found.append(page.evaluate(looks))
    dark, light, again = found
    assert again == dark
    assert all(one != other for one, other in zip(dark, light, strict=True))
    assert problems == []


# The sources ----------------------------------------------------------------------------------------------------

SOURCES = [
    page
    for page in DOCS.rglob("*.md")
    if not {"_build", "examples", "gallery", "made"} & set(page.relative_to(DOCS).parts)
    and page.name not in ("README.md", "paper.md")
]


def test_every_formula_becomes_mathml() -> None:
    """Of a page whose formula does not, and of those beside it, Sphinx writes nothing in parallel, and says nothing."""
    tex2mathml = pytest.importorskip("docutils.utils.math.latex2mathml").tex2mathml
    code, found = re.compile(r"^(```+).*?^\1|`[^`]*`", re.MULTILINE | re.DOTALL), 0
    for page in sorted(DOCS.rglob("*.md")):
        if not {"_build", "made"} & {*page.parts}:
            text = code.sub("", page.read_text(encoding="utf-8"))
            for block, line in re.findall(r"(?s)\$\$(.+?)\$\$|(?<![\\$\w])\$([^$\n](?:[^$]*?[^$\\])?)\$(?!\d)", text):
                assert "<math" in tex2mathml(block or line, as_block=bool(block)), page
                found += 1
    assert found > 300


def test_no_two_pages_have_one_name() -> None:
    names = Counter(page.stem for page in SOURCES)
    assert names["own-law"] == 1
    assert [name for name, count in names.items() if count > 1 and name != "index"] == []


@pytest.mark.parametrize("page", SOURCES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_links_between_sources_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for address in re.findall(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)", text):
        generated = {"gallery", "made"} & set(Path(address).parts)
        if not generated and not re.match(r"(https?|mailto):", address):
            assert (page.parent / address).exists() or (page.parent / f"{address}.md").exists(), address


# The whole site -------------------------------------------------------------------------------------------------

made = pytest.mark.skipif(not (SITE / "index.html").is_file(), reason="the site has not been made: make docs")


class Links(HTMLParser):
    """The addresses of a page, and the places in it that have a name."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.names: set[str] = set()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if value and name in ("href", "src"):
                self.addresses.append(value)
            if value and name in ("id", "name"):
                self.names.add(value)


@made
@pytest.mark.long
def test_every_link_leads_somewhere() -> None:
    pages = {}
    for file in SITE.rglob("*.html"):
        if "_static" in file.relative_to(SITE).parts:  # templates of the theme
            continue
        pages[file] = Links()
        pages[file].feed(file.read_text(encoding="utf-8"))
    assert len(pages) > 200
    broken = []
    for file, links in pages.items():
        for address in links.addresses:
            if re.match(r"(https?|mailto|data|javascript):", address):
                continue
            path, place = urldefrag(address)
            target = (file.parent / unquote(path.partition("?")[0])).resolve() if path else file
            if not target.is_file() or (place and target in pages and unquote(place) not in pages[target].names):
                broken.append(f"{file.relative_to(SITE)}: {address}")
    assert broken == []


@made
@pytest.mark.long
def test_every_example_of_the_gallery_shows_as_many_pictures_as_are_told_in_words() -> None:
    told = tomllib.loads((DOCS.parent / "examples" / "alt.toml").read_text(encoding="utf-8"))
    pages = {file.stem: file.read_text(encoding="utf-8") for file in (SITE / "gallery").rglob("plot_*.html")}
    assert {name: len(words) for name, words in told.items()} == {
        name: text.count('class = "sphx-glr-single-img"') for name, text in pages.items()
    }


@made
@pytest.mark.long
def test_nothing_is_fetched_from_a_network(browser: Any) -> None:
    for name in (
        "index.html",
        "start/index.html",
        "tutorials/steering.html",
        "gallery/index.html",
        "interactive/memberships-and-rules.html",
        "interactive/drive.html",
        "interactive/runs.html",
        "explanation/errata-chapter-2.html",
        "reference/made/fuzzy/Sugeno.html",
    ):
        page, problems = opened(browser, SITE / name)
        page.wait_for_load_state("networkidle", timeout=PATIENCE)
        assert problems == [], name
        page.close()


# What somebody types who asks a question of docs/start/questions.md, and the page that answers it.
SEARCHED = {
    "skfuzzy": "howto/from-scikit-fuzzy",
    "Simulink": "howto/from-matlab",
    "genfis": "reference/matlab",
    "anfisedit": "reference/matlab",
    "Mamdani": "howto/other-formats",
    "ex-fuzzy": "howto/from-ex-fuzzy",
    "PyIT2FLS": "howto/from-pyit2fls",
    "type-2": "howto/type2",
    "type-2 noise": "explanation/type2-under-noise",
    "fistree": "howto/trees",
    "fll": "howto/other-formats",
    "choose membership": "howto/choose-membership-functions",
    "fewer rules": "howto/too-many-rules",
    "NSGA": "howto/rules-from-nothing",
    "transfer function": "howto/own-plant",
    "PID": "howto/own-plant",
    "gain scheduling": "howto/own-plant",
    "Arduino": "howto/rules-on-a-microcontroller",
    "STM32": "howto/rules-on-a-microcontroller",
    "fixed point": "howto/rules-on-a-microcontroller",
    "paper figure": "howto/short-answers",
    "learning method": "howto/choose-learning",
    "cross-validation": "howto/short-answers",
    "categorical": "howto/short-answers",
    "overfitting": "explanation/learning",
    "conformal": "howto/learn-from-a-table",
    "pruning": "howto/learn-from-a-table",
    "formation data": "tutorials/formation",
    "own formation": "howto/own-formation",
    "rosbag": "howto/logs",
    "gymnasium": "howto/environments",
    "fuzzy nonlinear better": "explanation/arena",
    "choose controller": "howto/choose-controller",
    "compare fair": "tutorials/fair-comparison",
    "1000 seeds": "howto/short-answers",
    "metric": "howto/own-metric",
    "data sheet": "howto/own-robot",
    "identify": "howto/your-robot",
    "turtlebot": "howto/turtlebot3",
    "MuJoCo": "howto/mujoco",
    "ranking transfer": "explanation/transfer",
    "friction": "explanation/robot",
    "sensor noise": "howto/sensors",
    "docking": "howto/goals",
    "step by hand": "howto/step-by-step",
    "own study": "howto/own-study",
    "dask": "howto/sweeps-on-dask",
    "stability": "explanation/certificate",
    "safety": "explanation/passive-safety",
    "radio lost": "tutorials/losing-a-robot",
    "ROS": "howto/on-ros-2",
    "Nav2": "howto/from-nav2",
    "Foxglove": "howto/logs",
    "cite": "howto/cite",
}


@made
@pytest.mark.long
def test_one_search_finds_what_answers_a_question(browser: Any) -> None:
    """Among the first eight pages; from the first page of the site it is two clicks by docs/start/questions.md."""
    page, missed = browser.new_page(), []
    for words, answer in SEARCHED.items():
        page.goto(f"{(SITE / 'search.html').as_uri()}?q={words.replace(' ', '+')}")
        page.get_by_text("Search finished").or_(page.get_by_text("did not match any")).wait_for(timeout=20_000)
        links = page.locator("#search-results li > a").evaluate_all("all => all.map(a => a.getAttribute('href'))")
        pages = list(dict.fromkeys(re.split(r"[?#]", link)[0] for link in links))
        if f"{answer}.html" not in pages[:8]:
            missed.append((words, answer, pages[:3]))
    assert missed == []


@made
@pytest.mark.long
@pytest.mark.parametrize("width", [1280, 390])
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_pages_fit_and_have_ink(browser: Any, width: int, theme: str) -> None:
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=theme)
    for name in ("index.html", "start/index.html", "tutorials/losing-a-robot.html", "howto/choose-controller.html"):
        page = context.new_page()
        page.goto((SITE / name).as_uri())
        wide = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        assert wide <= 1, f"{name} is {wide} px too wide"
        ink, paper = page.evaluate(
            "[getComputedStyle(document.body).color, getComputedStyle(document.body).backgroundColor]"
        )
        assert ink != paper
        assert json.dumps(ink)
    context.close()
