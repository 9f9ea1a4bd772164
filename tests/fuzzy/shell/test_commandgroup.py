"""Commands below headings, and those that installed packages add: found, listed, refused."""

import subprocess
import sys

import pytest

import anfis.commands.application
import fuzzy.commands.application
import robotics.commands.application
from fuzzy.shell.commandgroup import COMMAND_GROUP
from tests.conftest import declare

PROGRAMS = {
    "fuzzy": fuzzy.commands.application.main,
    "anfis": anfis.commands.application.main,
    "robotics": robotics.commands.application.main,
}
COMMANDS = '''
"""Commands of a package that is not ours."""

from fuzzy.shell.terminal import application

more = application("Say more.", "robotics more-words twice", commands="")


def hello(name: str = "you") -> None:
    """Greet somebody. And more."""
    print(f"hello, {name}")


@more.command()
def twice() -> None:
    """Say it twice."""
    print("hello, hello")
'''


@pytest.fixture
def greetings(site):
    """An installed package that adds commands to all three programs."""
    (site / "greetings.py").write_text(COMMANDS, encoding="utf-8")
    names = ("fuzzy.look.hello", "anfis.learn.hello", "robotics.deploy.hello", "robotics.greet.hello-2")
    points = dict.fromkeys(names, "greetings:hello") | {"robotics.more.more-words": "greetings:more"}
    declare(site, "good-manners", {COMMAND_GROUP: points})


def sections(text):
    """The lines below each heading of a help."""
    found, heading = dict[str, list[str]](), ""
    for line in text.splitlines():
        if line.endswith(":") and not line.startswith(" "):
            heading = line.removesuffix(":")
            found[heading] = []
        elif line.startswith("  ") and heading:
            found[heading].append(line.strip())
    return found


@pytest.mark.parametrize(
    ("program", "heading"),
    [("fuzzy", "Look"), ("anfis", "Learn"), ("robotics", "Deploy")],
)
def test_a_package_adds_a_command_below_a_heading(program, heading, greetings, capsys):
    main = PROGRAMS[program]
    assert main(["--help"]) == 0
    (line,) = [line for line in sections(capsys.readouterr().out)[heading] if line.startswith("hello ")]
    assert line.endswith("Greet somebody.")
    assert main(["hello", "--name", "all"]) == 0
    assert capsys.readouterr() == ("hello, all\n", "")
    assert main(["hello", "--nam", "all"]) == 2
    assert f"{program} hello" in capsys.readouterr().err


def test_a_heading_of_its_own_and_a_group_of_commands(greetings, capsys):
    main = PROGRAMS["robotics"]
    assert main(["--help"]) == 0
    shown = sections(capsys.readouterr().out)
    assert shown["Greet"] == ["hello-2    Greet somebody."]
    assert "more-words" in " ".join(shown["More (robotics COMMAND --help)"]).split(", ")
    assert main(["more-words", "twice"]) == 0
    assert capsys.readouterr().out == "hello, hello\n"


def test_what_cannot_be_imported_is_one_sentence_and_harms_nobody(site, capsys):
    declare(
        site,
        "bad-manners",
        {
            COMMAND_GROUP: {
                "fuzzy.look.grumble": "no_such_module:grumble",
                "fuzzy.look.mumble": "json:JSONError",
                "fuzzy.look.number": "math:pi",
                "fuzzy.look.show": "json:dumps",
                "anfis.look.grumble": "json:dumps",
            }
        },
    )
    main = PROGRAMS["fuzzy"]
    refusal = "of the package bad-manners cannot be used:"
    reasons = {
        "grumble": f"no_such_module:grumble {refusal} ModuleNotFoundError: No module named 'no_such_module'",
        "mumble": f"json:JSONError {refusal} AttributeError: module 'json' has no attribute 'JSONError'",
        "number": f"math:pi {refusal} TypeError: a command must be a function or an application, not float",
    }
    for name, reason in reasons.items():
        for words in ([name], [name, "some", "words", "--and=options"], [name, "--help"]):
            assert main(words) == 2
            assert capsys.readouterr() == ("", f"fuzzy: {name}: {reason}\n")
    assert main(["--help"]) == 0
    out, err = capsys.readouterr()
    listed = " ".join(" ".join(sections(out)["Look"]).split())
    assert all(f"{name} {reason}" in listed for name, reason in reasons.items())
    assert "show Show the system" in listed
    assert err == "the command fuzzy.look.show of the package bad-manners has the name of another\n"
    assert main(["show", "tracking"]) == 0


def test_at_most_twenty_commands_of_robotics_are_seen_at_first_sight(site, capsys):
    assert PROGRAMS["robotics"](["--help"]) == 0
    shown = sections(capsys.readouterr().out)
    assert list(shown) == [
        "Options", "Look", "Run", "Compare", "Tune", "Learn", "Deploy", "More (robotics COMMAND --help)"
    ]  # fmt: skip
    purposes = [name for name in shown if name != "Options" and not name.startswith("More")]
    assert sum(len(shown[name]) for name in purposes) <= 20


def test_a_command_of_its_own_does_not_ask_who_else_is_there():
    code = (
        "import sys; from fuzzy.commands.application import main; main(['rules', 'nothing.fis']); "
        "print([m for m in ('fuzzy.plugins', 'fuzzy.commands.plot') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"
