"""The ways in: every question of docs/start/questions.md has its answer, and pages for who comes from elsewhere run."""

import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fuzzy
import robotics
from tests.helpexamples import parse
from tests.snippets import cells, run_python, snippets

DOCS = Path(__file__).parent.parent / "docs"
HOWTO = DOCS / "howto"
QUESTIONS = DOCS / "start" / "questions.md"
ROWS = [
    row
    for row in re.findall(r"^\| (.+?) \| (.+) \|$", QUESTIONS.read_text(encoding="utf-8"), re.MULTILINE)
    if row[0] != "---"
]


def anchors(page: Path) -> set[str]:
    """What a link may name behind the # of a page: its headings, as MyST spells them."""
    text = re.sub(r"^(```+).*?^\1", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#{1,3} (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_forty_questions_have_one_answer_each():
    assert len(ROWS) >= 40
    assert len({question for question, _ in ROWS}) == len(ROWS)
    for question, answer in ROWS:
        command = re.fullmatch(r"`([^`]+)`", answer)
        link = re.fullmatch(r"\[[^\]]+\]\(([^)#]+)(?:#([^)]+))?\)", answer)
        assert command or link, f"{question}: {answer} is neither a link nor a command"
        if command:
            parse(command[1])
        else:
            page = QUESTIONS.parent / link[1]
            assert page.is_file(), f"{question}: {link[1]}"
            assert link[2] is None or link[2] in anchors(page), f"{question}: {link[2]}, there are {anchors(page)}"


@pytest.mark.parametrize("page", ["docs/index.md", "docs/start/index.md", "README.md"])
def test_the_questions_are_found_from_the_first_pages(page):
    assert "questions.md)" in (DOCS.parent / page).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["ex-fuzzy", "pyit2fls", "nav2"])
def test_headings_that_a_page_for_strangers_links_to_are_there(name):
    for target, place in re.findall(
        r"\]\(([\w./-]+\.md)#([\w-]+)\)", (HOWTO / f"from-{name}.md").read_text(encoding="utf-8")
    ):
        assert place in anchors(HOWTO / target), f"{target}#{place}"


def test_the_first_page_says_what_its_program_prints(capsys):
    ((_, text),) = snippets(DOCS / "index.md")
    run_python(text, "index.md")
    assert f"# {capsys.readouterr().out.strip()}:" in text


def run(name):
    """The cells of a page, one after the other: the names that they leave."""
    space: dict[str, Any] = {}
    for cell in cells(HOWTO / f"from-{name}.md"):
        exec(compile(cell, f"from-{name}.md", "exec"), space)
    return space


def test_the_interval_of_type_2_is_the_extreme_of_all_choices_within_the_bounds(capsys):
    space = run("pyit2fls")
    capsys.readouterr()
    upper = np.exp(-0.5 * ((0.3 - np.array([-1, 0, 1])) / np.array([0.4, 0.3, 0.4])) ** 2)
    proposed = [-2, 0, 0.5 * 0.3 + 1]
    choices = [np.average(proposed, weights=w) for w in itertools.product(*zip(0.8 * upper, upper, strict=True))]
    found = space["found"]
    assert (found.low[0], found.high[0]) == pytest.approx((min(choices), max(choices)), rel=1e-12)
    assert space["system"](0.0)([0.3])[0] == pytest.approx(np.average([-2, 0, 1.15], weights=upper), rel=1e-12)


def test_what_scikit_fuzzy_says_is_farther_off_with_wider_sets(capsys):
    space = run("scikit-fuzzy")
    capsys.readouterr()
    wide = fuzzy.from_skfuzzy(space["control"].ControlSystem(space["changed"])).difference[0]
    assert wide.greatest > 2 * space["found"].difference[0].greatest


def test_rules_by_number_become_sentences_and_classes_are_told_apart(capsys):
    space = run("ex-fuzzy")
    assert "if distance is far and load is light then v is fast\n" in capsys.readouterr().out
    assert space["rules"][0] == "if distance is near then v is slow"
    assert space["right"].mean() > 0.9


def test_the_numbers_of_nav2_are_those_of_the_law():
    law = robotics.make_controller("pursuit")
    text = (HOWTO / "from-nav2.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[a-z_]+` [\d.]+.*?) \| (.+) \|$", text, re.MULTILINE)
    assert len(rows) == 4
    for theirs, ours in rows:
        values = [float(number) for number in re.findall(r"` ([\d.]+)", theirs)]
        assert values == [getattr(law, name) for name in re.findall(r"`(\w+)`", ours)]


@pytest.mark.long
def test_beside_nav2_rules_follow_more_closely_and_take_bends_more_slowly(capsys):
    space = run("nav2")
    capsys.readouterr()
    nav2, shorter, rules = space["behind"].values()
    assert nav2 > 2 * shorter > 4 * rules
    assert space["push"]["careful"] < 0.75 * space["push"]["as timed"]
