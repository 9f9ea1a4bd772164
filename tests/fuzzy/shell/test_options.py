"""Options of commands that are fields of a dataclass: what the help says, what the command gets, what is refused."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Annotated, Literal

import pytest
import typer

from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, described, quantity, whole
from fuzzy.shell.options import FieldOptions, Shown, renamed_options
from fuzzy.shell.terminal import application, run


@dataclass(frozen=True, kw_only=True)
class Kettle:
    volume: float = quantity(1.5, "l", above=0, doc="Volume of the kettle. A mug holds a third.")
    power: float = quantity(2.0, "kW", least=0.5, most=3, doc="Power.")
    cups: int = whole(4, least=1, doc="Number of cups.")
    tea: Literal["black", "green"] = described("Sort of tea.", "black")
    guests: tuple[str, ...] = described("Who comes.", ("Ada", "Alan"))
    whistle: bool = described("Whistle at the end.", False)
    label: Annotated[Path | None, typer.Option("--name-tag", metavar="FILE", help="Print a label.")] = None
    owner: str = field(default="nobody")  # no option

    def __post_init__(self) -> None:
        check_quantities(self, InputError)
        if self.volume < self.cups / 4:
            raise InputError(f"volume must be enough for {self.cups} cups").about("volume")


OF = f"{__name__}:Kettle"
ALL = ("volume", "power", "cups", "tea", "guests", "whistle", "label")
seen: list[object] = []


def brew(
    *,
    where: Annotated[str, typer.Argument(help="The place.")] = "here",
    kettle: Annotated[Kettle, FieldOptions(OF, *ALL, cups=Shown(default=5), volume=Shown("--size"))],
) -> None:
    """Brew tea."""
    seen.append((where, kettle))


def given(
    *, kettle: Annotated["partial[Kettle]", FieldOptions(OF, "volume", "guests", "whistle", given=True, of="tea")]
) -> None:
    """Say what was given."""
    seen.append(kettle)


@renamed_options(mugs="--cups", places="")
def old(
    places: Annotated[list[str], typer.Argument(help="The places.")],
    cups: Annotated[int, typer.Option(help="Number of cups.")] = 1,
) -> None:
    """Know earlier names."""
    seen.append((places, cups))


app = application("Make tea.")
for command in (brew, given, old):
    app.command()(command)


def call(line: str) -> int:
    seen.clear()
    return run(app, "tea", line.split())


def test_a_command_gets_the_finished_dataclass():
    assert call("brew kitchen --size 2 --tea green --guests Grace,,Edsger --whistle --name-tag x.pdf") == 0
    kettle = Kettle(volume=2, tea="green", cups=5, guests=("Grace", "Edsger"), whistle=True, label=Path("x.pdf"))
    assert seen == [("kitchen", kettle)]
    assert call("brew --size 1.25") == 0
    assert seen == [("here", Kettle(volume=1.25, cups=5))]


def test_every_command_takes_quiet_and_only_shows_it_where_there_is_a_bar(capsys):
    assert call("brew -q") == 0
    assert call("given --quiet --guests Ada") == 0
    assert call("brew --help") == 0
    assert "--quiet" not in capsys.readouterr().out


def test_the_help_says_sentence_unit_range_and_default(capsys):
    assert call("brew --help") == 0
    said = " ".join(capsys.readouterr().out.split())
    for part in (
        "Volume of the kettle, l, > 0. A mug holds a third. [default: 1.5]",
        "Power, kW. [default: 2.0; 0.5<=x<=3]",
        "Number of cups. [default: 5; x>=1]",
        "black|green",
        "Who comes. [default: Ada,Alan]",
        "--name-tag FILE Print a label.",
    ):
        assert part in said
    assert "--owner" not in said
    assert call("given --help") == 0
    assert "tea: volume of the kettle, l, > 0. A mug holds a third. Default: 1.5." in " ".join(
        capsys.readouterr().out.split()
    )


def test_only_what_was_given_is_given():
    assert call("given --guests Ada") == 0
    [kettle] = seen
    assert isinstance(kettle, partial)
    assert kettle.keywords == {"guests": ("Ada",)}
    assert kettle(cups=2) == Kettle(guests=("Ada",), cups=2)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("brew --size 0", "tea: --size must be a finite number in l, > 0; got 0.0"),
        ("brew --size 1", "tea: --size must be enough for 5 cups"),
        ("brew --power 4", "tea brew: --power: must be <= 3"),
        ("brew --power much", "tea brew: --power: must be a number"),
        ("brew --cups 0", "tea brew: --cups: must be >= 1"),
        ("brew --tea oolong", "tea brew: --tea: 'oolong' is not one of 'black', 'green'."),
        ("brew --tea gren", "tea brew: --tea: 'gren' is not one of 'black', 'green'; did you mean 'green'?"),
        ("brew --milk", "tea brew: No such option: --milk"),
    ],
)
def test_what_is_refused_names_the_option_and_what_is_accepted(line, message, capsys):
    assert call(line) == 2
    assert capsys.readouterr().err.splitlines()[0] == message
    assert not seen


def test_earlier_names_go_on_working_and_are_noted(capsys):
    for line in ("old --mugs 3 --places here,there", "old --mugs=3 --places=here,there"):
        assert call(line) == 0
        assert seen == [(["here", "there"], 3)]
        assert capsys.readouterr().err == (
            "tea old: --mugs is now called --cups; the old name goes in the next release\n"
            "tea old: --places is no longer needed, its names stand by themselves; the old name goes in the next "
            "release\n"
        )
    assert call("old here there --cups 3") == 0
    assert capsys.readouterr().err == ""
    assert call("old --help") == 0
    assert "--mugs" not in capsys.readouterr().out


@pytest.mark.parametrize(("line", "names"), [("tea brew --tea g", ["green"]), ("tea old --mu", [])])
def test_a_shell_completes_options(line, names, monkeypatch, capsys):
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(line.split()) - 1))
    monkeypatch.setenv("_TEA_COMPLETE", "complete_bash")
    run(app, "tea", [])
    assert capsys.readouterr().out.split() == names
