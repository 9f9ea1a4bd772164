"""The page docs/howto/own-law.md and the templates: every snippet and every file runs as written."""

import re
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzzy.errors import InputError
from robotics.commands.application import main
from robotics.commands.filekinds import TEMPLATES, template_text, write_template
from robotics.laws.catalogue import make_controller
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from tests.snippets import run_commands, run_python, snippets

SNIPPETS = snippets(Path(__file__).parent.parent / "docs" / "howto" / "own-law.md", changed=False)
SHORT = """
duration = 1.0
[[robots]]
start = [0.0, 0.1, 0.0]
timing = { speed = 0.2 }
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
"""


@pytest.mark.long
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    assert [kind for kind, _ in SNIPPETS] == ["sh", "sh", "toml", "sh", "python", "python", "text", "toml", "python"]
    for kind, text in SNIPPETS:
        if kind == "sh":
            run_commands(text)
        elif (kind == "toml" and (file := re.match(r"# ([\w-]+\.toml)", text))) or (
            kind == "python" and (file := re.match(r"# (\w+\.py)\n", text))
        ):
            (tmp_path / file[1]).write_text(text, encoding="utf-8")
        elif kind == "text":
            _steers_as_it_says()
            _is_said_of_a_misspelt_column(text)
        elif kind == "toml":
            groups = tomllib.loads(text)["project"]["entry-points"]
            assert {*groups} == {f"fuzzyfleet.{name}" for name in ("laws", "metrics", "rulebases")}
        else:
            run_python(text, "own-law.md")
    said = capsys.readouterr().out
    for words in ("RMS acceleration", "MyLaw", "mine.fis", "comfort", "top_speed"):
        assert words in said
    sys.modules.pop("mylaw", None)


def _steers_as_it_says():
    """Both forms of the page's law drive the same run, and with the integral as numpy has it."""
    scenario = replace(load_scenario("lyapunov-sine"), duration=1.0)
    plain, fast, none, steady = (
        simulate(scenario, make_controller(law), (1, 2))
        for law in ("plain.py:Plain:ky=2", "fast.py:Fast:ky=2", "fast.py:Steady:ky=2,iy=0", "fast.py:Steady:ky=2,iy=3")
    )
    assert plain.samples.tobytes() == fast.samples.tobytes() == none.samples.tobytes()
    target = steady.reference[:, :, 0]
    aside = target[1] - steady["y_measured"][:, 0]
    wish = target[4] + 2 * aside + 3 * scenario.period * np.cumsum(aside, axis=-1)
    np.testing.assert_allclose(steady["command_2"][:, 0], wish, atol=1e-12)
    np.testing.assert_array_equal(steady["command_1"][0, 0], target[3])


def _is_said_of_a_misspelt_column(said):
    """The page's error is that of its own law, misspelt."""
    Path("misspelt").mkdir()
    Path("misspelt/fast.py").write_text(Path("fast.py").read_text(encoding="utf-8").replace("gain.ky", "gain.kz", 1))
    with pytest.raises(InputError) as error:
        make_controller("misspelt/fast.py:Fast")
    assert said.strip() in str(error.value)


@pytest.mark.parametrize(("kind", "own"), [("law", "own.py:MyLaw"), ("rule-base", "own.fis"), ("metric", "own.py")])
def test_a_template_runs_as_it_is_written_under_any_name(kind, own, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("short.toml").write_text(SHORT, encoding="utf-8")
    file = own.partition(":")[0]
    assert main(["new", kind, "-o", file]) == 0
    assert file in capsys.readouterr().out.splitlines()[1]
    if kind != "rule-base":
        assert f"--{kind} {file}:" in Path(file).read_text(encoding="utf-8")
    chosen = ["--metric", own] if kind == "metric" else ["--law", own]
    assert main(["run", "short.toml", *chosen, "-q"]) == 0
    assert main(["compare", "short.toml", "--controllers", "csm", *chosen, "--seeds", "1", "--no-report", "-q"]) == 0
    assert {"law": "MyLaw", "rule-base": "own.fis", "metric": "RMS accel."}[kind] in capsys.readouterr().out
    assert main(["new", kind, "-o", file]) == 2
    assert "exists already" in capsys.readouterr().err


def test_the_template_of_a_law_and_of_a_rule_base_drive_to_their_paths(tmp_path):
    import robotics

    for kind, file in (("law", "mylaw.py"), ("rule-base", "mine.fis")):
        write_template(kind, tmp_path / file)
        run = robotics.simulate(robotics.load_scenario("lyapunov-sine"), robotics.make_controller(str(tmp_path / file)))
        assert not run.diverged.any()
        assert np.abs(robotics.cross_track_error(run)[..., -200:]).max() < 0.1


def test_the_metric_of_the_template_is_the_root_mean_square_of_a_known_acceleration():
    from types import SimpleNamespace

    space: dict[str, object] = {}
    exec(template_text("metric"), space)
    time = np.arange(5) * 0.5
    run = SimpleNamespace(time=time)
    speeds = np.array([[0.0, 1.0, 3.0, 3.0, np.nan]])  # m/s: 2, 4, 0 m/s², then nothing
    measure: object = space["comfort"]
    found = measure(type("R", (), {"time": run.time, "__getitem__": lambda self, name: speeds})())  # type: ignore[operator]
    np.testing.assert_allclose(found, [np.sqrt((4 + 16) / 3)], rtol=1e-12)


def test_what_is_no_kind_or_ends_wrongly_is_refused(tmp_path):
    with pytest.raises(InputError, match="unknown kind of file 'lav'; did you mean 'law'"):
        template_text("lav")
    with pytest.raises(InputError, match=r"a law file must end in \.py"):
        write_template("law", tmp_path / "law.txt")
    assert {*TEMPLATES} == {"law", "metric", "rule-base"}
