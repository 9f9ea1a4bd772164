"""The pages of the reference that are kept, and what those that are made hold; what they say is true of the program."""

import importlib
import json
import re
import tomllib
import warnings
from pathlib import Path
from typing import Any

import pytest
import typer

import fuzzy
from benchmarks.__main__ import BENCHMARKS
from fuzzy.files import fislines
from fuzzy.membershipfunction import MATLAB_NAMES
from robotics.commands.filekinds import FILE_KINDS
from robotics.laws.catalogue import CATALOGUE
from robotics.laws.tracking.fuzzy_tracking import rule_base_files
from robotics.measures.registry import ALL_METRICS
from robotics.plugins.thesis.avoidance import CHAPTER_FIGURES
from robotics.plugins.thesis.avoidance_runs import AVOIDANCE_TESTS
from robotics.plugins.thesis.formations import _EXPERIMENTS, _FITS
from robotics.plugins.thesis.rows import TABLES
from robotics.plugins.thesis.team_runs import TEAM_TESTS
from robotics.show.report.plan import load_study
from robotics.simulation.scenario.reading import parse_scenario, scenario_names
from tests.conftest import module_in

PAGES = Path(__file__).parent.parent / "docs" / "reference"
# What the Fuzzy Logic Toolbox has: each name stands on the page, here or under what is not here.
TOOLBOX = (
    "addInput addMF addOutput addRule anfis anfisOptions anfisedit convertToSugeno convertToStruct convertToType1 "
    "convertToType2 defuzz dsigmf evalfis evalfisOptions evalmf fcm fcmOptions findcluster fismf fisrule fistree "
    "fisvar fuzarith fuzzyLogicDesigner gauss2mf gaussmf gbellmf genfis genfis1 genfis2 genfis3 genfisOptions gensurf "
    "gensurfOptions getFISCodeGenerationData getTunableSettings linsmf linzmf mam2sug mamfis mamfistype2 mfedit newfis "
    "parsrule pimf plotfis plotmf probor psigmf readfis removeInput removeMF removeOutput ruleedit ruleview setTunable "
    "showfis showrule sigmf smf subclust sugfis sugfistype2 surfview trapmf trimf tunefis tunefisOptions writeFIS zmf"
)
BLOCKS = ("Fuzzy Logic Controller", "Fuzzy Logic Controller with Ruleviewer", "FIS Tree")


@pytest.fixture(scope="module")
def pages():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(PAGES)
        yield importlib.import_module("pages")


def test_stable_names_are_few_and_there_and_the_readme_uses_no_other(pages):
    stable = pages.stable_names()
    assert 100 < len(stable) <= 150
    for name in stable:
        package, _, short = name.partition(".")
        assert short in importlib.import_module(package).__all__, name
    root, missing = PAGES.parent.parent, set()
    for page in (root / "README.md", root / "docs" / "start" / "everything.md"):
        text = page.read_text(encoding="utf-8")
        code = "\n".join(re.findall(r"```(?:python|\{code-cell\} python)\n(.*?)```", text, re.DOTALL))
        used = set(re.findall(r"\b(?:fuzzy|anfis|robotics)\.[A-Za-z]\w*", code))
        known = {n for n in used if n.partition(".")[2] in importlib.import_module(n.partition(".")[0]).__all__}
        missing |= known - stable
    assert missing == set()
    for name in ("infer", "search_table"):
        page = pages._page_of("fuzzy", fuzzy, name)
        assert ("Provisional" in page) is (name == "search_table")


def test_every_claim_has_a_command_that_there_is():
    rows = re.findall(r"^\| .*\|$", (PAGES / "claims.md").read_text(encoding="utf-8"), re.M)[2:]
    assert len(rows) > 12
    for row in rows:
        commands = re.findall(r"`((?:fuzzy|anfis|robotics|python) [^`]*)`", row.split("|")[3])
        assert commands, row
        for program, *words in (command.split() for command in commands):
            if program == "python":
                file = words[0] if words[0] != "-m" else words[1].replace(".", "/") + ".py"
                assert (PAGES.parent.parent / file).is_file(), file
                continue
            command: Any = typer.main.get_command(importlib.import_module(f"{program}.commands.application").app)
            while (name := words[0] if words else "") in getattr(command, "commands", {}):
                command, words = command.commands[name], words[1:]
            known = {option for each in command.params for option in each.opts}
            assert not hasattr(command, "commands")
            assert {word for word in words if re.fullmatch(r"--?[a-z][\w-]*", word)} <= known, row


def test_every_name_of_the_toolbox_has_a_line_and_leads_to_names_that_there_are():
    text = (PAGES / "matlab.md").read_text(encoding="utf-8")
    named = set(re.findall(r"\w+", " ".join(re.findall(r"`[^`]*`", text))))
    assert set(TOOLBOX.split()) - named == set()
    assert [block for block in BLOCKS if f"*{block}*" not in text] == []
    for package, name in re.findall(r"\(made/(\w+)/(\w+)\)", text):
        assert name in importlib.import_module(package).__all__, name
    for program, command in re.findall(r"`(fuzzy|anfis|robotics) ([a-z]\w*)", text):
        app = importlib.import_module(f"{program}.commands.application").app
        assert command in typer.main.get_command(app).commands, f"{program} {command}"  # type: ignore[attr-defined]


def test_the_page_of_the_dialect_runs_and_knows_every_key(capsys):
    text = (PAGES / "fis.md").read_text(encoding="utf-8")
    space: dict[str, Any] = {}
    for cell in re.findall(r"```\{code-cell\} python\n(.*?)```", text, re.DOTALL):
        exec(compile(cell, "fis.md", "exec"), space)
    said = capsys.readouterr().out
    assert "mine.fis:8: NumRules is 4, but the file has 3 rules" in said
    assert "%! Unit='m'" in said
    for key in (*fislines._SYSTEM_KEYS, *fislines._VARIABLE_KEYS, *fislines.SYSTEM_NOTES, *MATLAB_NAMES):
        assert re.search(rf"`[^`]*\b{key}\b[^`]*`", text), key
    hedged = re.findall(r"\| (bearing is .*?left) \| `([-\d.]+)`", text)
    assert len(hedged) == 6
    for sentence, index in hedged:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", fuzzy.FisFileWarning)
            read = fuzzy.parse_fis(space["text"].replace("2 1, 2 (1)", f"2 {index}, 2 (1)")).rules[0]
        assert str(read).startswith(f"if distance is far and {sentence} then")


def test_every_metric_is_defined(pages):
    assert set(pages.FORMULAS) == set(ALL_METRICS)
    table = pages._tables()["metrics.md"]
    rows = [line.replace(r"\|", "") for line in table.splitlines() if line.startswith("| `")]
    assert {row.count("|") for row in rows} == {7}


def test_fields_that_a_file_sets_stand_on_the_page_of_their_class(pages):
    page = pages._page_of("robotics", importlib.import_module("robotics"), "Timing")
    assert "      * - ``ramp``\n        - The time in which the speed rises" in page
    assert "a finite number in s, >= 0; default ``0.0``" in page
    bell = pages._page_of("fuzzy", fuzzy, "Bell")
    assert "* - ``a``\n        - half-width a\n        - a length ≠ 0, in the unit of x" in bell


def test_the_benchmarks_that_there_are_have_a_page_and_figures_say_where_they_are_from(pages, tmp_path):
    names = pages.benchmark_names(PAGES.parent.parent / "benchmarks")
    assert names == list(BENCHMARKS)
    machine = {"processor": "a processor", "processors": 2, "python": "3.13.0", "load": [0.1, 1.9], "seconds": 61.5}
    entry = {"date": "2026-01-31", **machine, "quick": True, "report": ["engine  us", "ours     3"]}
    (tmp_path / "benchmarks.json").write_text(json.dumps({"learning": entry}), encoding="utf-8")
    page = pages.benchmarks(tmp_path / "benchmarks.json")
    assert "2026-01-31, a processor, 2 processors, Python 3.13.0, load 0.1 before and 1.9 after" in page
    assert page.count("### Measured") == 1
    assert page.index("benchmarks.learning`") < page.index("ours     3") < page.index("benchmarks.predictive`")
    assert all(f"## `python -m benchmarks.{name}`" in page for name in names)


def test_a_schema_of_each_kind_of_file_is_named_and_made():
    text = (PAGES / "editors.md").read_text(encoding="utf-8")
    kinds = re.search(r"names the kind of file: (.*?)\.", text)
    assert kinds
    assert re.findall(r"scenario|robot|sweep|tuning|study", kinds[1]) == list(FILE_KINDS)
    (example,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    assert len(parse_scenario(example, "page").robots) == 1


def test_every_figure_of_the_thesis_stands_once_with_pictures_and_commands_that_exist(pages):
    """Chapters 2 to 6, and Tables 2.1 and 5.1 to 5.8; the pictures are those that the report draws."""
    told = tomllib.loads((PAGES / "thesisfigures.toml").read_text("utf-8"))["rows"]
    numbers = []
    for row in told:
        figures = row["thesis"].partition("Table")[0]
        for chapter, first, end in re.findall(r"\b([2-6])\.(\d+)(?:-[2-6]\.(\d+))?", figures):
            numbers += [f"{chapter}.{n}" for n in range(int(first), int(end or first) + 1)]
    last = {2: 32, 3: 7, 4: 17, 5: 31, 6: 43}
    assert sorted(numbers) == sorted(f"{chapter}.{n}" for chapter, end in last.items() for n in range(1, end + 1))
    tables = re.findall(r"(\d\.\d)(?:-(\d\.\d))?", " ".join(row["thesis"].partition("Table")[2] for row in told))
    assert {"2.1", "5.1", "5.6", "5.7", "5.8"} < {first for first, _ in tables}
    texts = tomllib.loads((PAGES.parents[1] / "robotics" / "plugins" / "thesis" / "texts.toml").read_text("utf-8"))
    drawn = {*texts, *(name for name, _ in (row[:2] for row in _FITS)), *(f"{name}-1" for name in _EXPERIMENTS)}
    drawn |= {f"avoidance-meetings-{name}" for name in AVOIDANCE_TESTS}
    drawn |= {f"avoidance-{name}{end}" for name in CHAPTER_FIGURES for end in ("", "-speeds")}
    drawn |= {f"team-{name}" for name in TABLES.table("figures")} | {f"team-errors-{name}" for name in TEAM_TESTS}
    compared = load_study("thesis").scenarios
    drawn |= {f"{name}-{kind}" for name in compared for kind in ("paths", "errors", "speeds", "metrics")}
    for row in told:
        assert set(row.get("pictures", [])) <= drawn, row
        words = row.get("redraw", "").split()
        known = {*scenario_names(), *CATALOGUE, *rule_base_files()}
        if words and words[1] in ("run", "compare", "plot"):
            given = [w for w in words[2:] if not w.startswith("-") and "." not in w and w != words[-1]]
            assert set(given) <= known, row
    assert "| Fig 2.3: the push K/Q(S) over S | `law-switching` |" in pages.thesis_figures(PAGES / "thesisfigures.toml")


def test_the_page_of_scenario_files_is_what_the_descriptions_say(monkeypatch):
    monkeypatch.syspath_prepend(PAGES)
    text = (PAGES / "file-scenario.md").read_text(encoding="utf-8")
    made = module_in(PAGES / "scenariopage.py").page()
    assert text == made, "python docs/reference/scenariopage.py > docs/reference/file-scenario.md"
    ((example),) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    assert len(parse_scenario(example, "page").robots) == 1
