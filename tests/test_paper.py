"""The article: what it cites, shows and says of the arena is there."""

import re
from pathlib import Path
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

import fuzzy
import robotics
from tests.conftest import module_in

PAPER = Path(__file__).parent.parent / "docs" / "paper"
RANKED = pd.read_csv(PAPER.parent / "reference" / "arena.csv")
TEXT = (PAPER / "paper.md").read_text(encoding="utf-8")


def test_it_cites_what_its_bibliography_has_and_all_of_it():
    cited = {*re.findall(r"@(\w+)", TEXT.partition("# Summary")[2])}
    listed = {*re.findall(r"^@\w+\{(\w+),", (PAPER / "paper.bib").read_text(encoding="utf-8"), re.MULTILINE)}
    assert cited == listed
    assert len(listed) > 8


def test_its_figures_are_made_by_its_code():
    figures = module_in(PAPER / "figures.py")
    shown = re.findall(r"\]\((\w+\.png)\)", TEXT)
    assert sorted(shown) == sorted(figures.FIGURES)
    named = re.findall(r"\\label\{(fig:\w+)\}", TEXT)
    assert sorted(named) == sorted({*re.findall(r"\\autoref\{(fig:\w+)\}", TEXT)})
    for draw in (lambda: figures.crossings(4), lambda: figures.noise(1), figures.ranking):
        figure = draw()
        assert isinstance(figure, Figure)
        assert all(ax.get_xlabel() for ax in figure.axes)


def test_its_numbers_of_the_arena_are_those_of_the_last_one():
    arena = " ".join(TEXT.partition("# The arena")[2].partition("# Use")[0].split())
    rows: Any = RANKED.set_index(RANKED["law"].str.replace("mppi:samples=500,steps=28,step=0.1", "mppi"))
    given = ":lead=auto,smooth=0.2"
    tuned, distance = rows["tuned_ratio"], 1000 * rows["rms_distance_late_m"]
    published = [rows.loc["fuzzy-correcting", f"published_ratio{end}"] for end in ("", "_low", "_high")]
    for said in (
        f"sliding mode costs {tuned['esm']:.2f}, Lyapunov's law {tuned['lyapunov']:.2f} and the thesis's rule base "
        f"{tuned['fuzzy']:.2f}",
        f"Lyapunov's law costs {tuned['lyapunov' + given]:.2f}, LQR {tuned['lqr' + given]:.2f}, and a Takagi-Sugeno "
        f"system that blends linear controllers {tuned['pdc' + given]:.2f}",
        f"predictive control costs {tuned['mppi']:.2f}",
        "cost {:.2f} ({:.2f} to {:.2f}) as written".format(*published),
        f"keeps {distance['fuzzy']:.1f} mm from its reference where the exponential sliding mode keeps "
        f"{distance['esm']:.1f} mm",
    ):
        assert said in arena
    assert not RANKED["failed"].any()


def test_its_program_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    fuzzy.write_fis(fuzzy.read_fis(Path(robotics.__file__).parent / "data" / "rulebases" / "tracking.fis"), "mine.fis")
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    done: dict[str, object] = {}
    exec(code.replace("range(20)", "range(2)"), done)
    assert isinstance(done["study"], robotics.Comparison)
    assert [*done["study"].controllers] == ["mine.fis", "lyapunov", "esm"]
    assert (tmp_path / "firmware" / "tracking.c").is_file()


def test_its_conditions_of_the_arena_are_those_of_the_packaged_one():
    arena = robotics.load_arena("default")
    words = {2: "two", 13: "thirteen"}
    said = " ".join(TEXT.partition("# The arena")[2].partition("# Use")[0].split()).lower()
    assert f"{words[len({law.partition(':')[0] for law in arena.laws})]} laws" in said
    assert f"{words[len(arena.engines)]} engines" in said
    assert f"{len(arena.scenarios('test'))} random scenarios" in said
    given = arena.conditions
    noise = (
        f"({1000 * given.position_noise:g} mm, {1000 * given.heading_noise:g} mrad, {1000 * given.latency:g} ms latency"
    )
    assert f"with {arena.testing_runs} noisy runs each {noise}" in said
    assert [(t.metric, round(t.scale, 4)) for t in arena.cost] == [
        ("rms_distance_late_m", 0.01),
        ("rms_heading_late_rad", 0.0873),
        ("w_variation_late_radps2", 1.0),
    ]
    assert (
        "rms distance over 1 cm, the rms heading error over 5° and the variation of the turn rate over 1 rad/s²" in said
    )


def test_it_has_the_parts_of_an_article_of_software():
    for part in (
        "Summary",
        "Statement of need",
        "State of the field",
        "Design",
        "Quality",
        "The arena",
        "Use",
        "Limits",
    ):
        assert f"\n# {part}\n" in TEXT
    assert 800 < len(TEXT.split()) < 2000
