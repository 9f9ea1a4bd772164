"""The borders of the program: each reader, good files, and what becomes of what it accepts.

At a border only an InputError may come out, with a message of a few lines at most. What is accepted must be usable, and
where a file carries a checksum it must be what was written.
"""

import tempfile
import time
import tomllib
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from anfis import Options, train
from fuzzy import Sugeno, format_fis, identify, parse_fis, parse_rule, read_fis
from fuzzy.errors import InputError
from fuzzy.files.table import read_table, write_table
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.edits import EDITS, apply
from robotics.show.playback.player import player_data
from robotics.show.report.plan import load_study, load_sweep
from robotics.simulation.run import Run, load_run
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.scenario.robots import load_robot
from tests.fuzzing.mutation import DAMAGE, MISTAKES, Mutation, flip_bit, forge_archive, mutated

ROOT = Path(__file__).parents[2]
LONGEST_MESSAGE = 2000  # characters: longer ones bury what they say


class WrongError(AssertionError):
    """What was accepted is not usable, or not what was written."""


@dataclass(frozen=True)
class Border:
    """A reader, good files, and what is done with what it accepts."""

    suffix: str
    corpus: Callable[[], Sequence[bytes]]
    read: Callable[[Path], Any]
    use: Callable[[Any], Any]
    mutations: tuple[Mutation, ...] = (*DAMAGE, *MISTAKES, *MISTAKES)


@dataclass
class Tally:
    """What became of mutated files."""

    accepted: int = 0
    refused: int = 0
    slowest: float = 0.0  # s of processor time
    slowest_number: int = -1
    escaped: list[tuple[int, str]] = field(default_factory=list)  # the number of the mutation, and what came out


def assault(border: Border, seed: int, numbers: Iterator[int] | range) -> Tally:
    """Read mutations ``numbers`` of ``seed``, each the same in every run, and use those that are accepted."""
    tally, corpus = Tally(), border.corpus()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"mutated{border.suffix}")
        for content in corpus:  # what they compile is no part of a mutation's time
            path.write_bytes(content)
            with suppress(InputError):
                border.use(border.read(path))
        for number in numbers:
            path.write_bytes(mutated(np.random.default_rng([seed, number]), corpus, border.mutations))
            begun = time.process_time()
            try:
                with _numbers_stay_numbers():
                    border.use(border.read(path))
                tally.accepted += 1
            except InputError as error:
                tally.refused += 1
                if len(str(error)) > LONGEST_MESSAGE:
                    tally.escaped.append((number, f"a message of {len(str(error))} characters"))
            except Exception as error:  # the question is what else comes out
                where = traceback.extract_tb(error.__traceback__)[-1]
                place = Path(where.filename).name
                tally.escaped.append((number, f"{type(error).__name__}: {str(error)[:200]} ({place}:{where.lineno})"))
            took = time.process_time() - begun
            if took > tally.slowest:
                tally.slowest, tally.slowest_number = took, number
    return tally


def kinds(tally: Tally) -> Counter[str]:
    """The different things that came out, counted."""
    return Counter(what for _, what in tally.escaped)


@contextmanager
def _numbers_stay_numbers() -> Iterator[None]:
    """Warnings for the user pass in silence; a library's warnings are errors, since nobody can act on them."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", UserWarning)
        yield


# Good files ---------------------------------------------------------------------------------------------------------


def _files(*patterns: str) -> Callable[[], Sequence[bytes]]:
    def corpus() -> Sequence[bytes]:
        return [path.read_bytes() for pattern in patterns for path in sorted(ROOT.glob(pattern))]

    return cache(corpus)


@cache
def _tables() -> Sequence[bytes]:
    return [
        b"time [s];Coolant temp [\xc2\xb0C];Oil pressure (bar)\n0,5;81,2;3,1\n1,0;82,5;3,25\n1,5;84,0;3,0\n",
        b'x,"y, across [m]",z\n1,2,3\n4.5,-6e-3,7\n\n8,9,10\n',
        b"\xef\xbb\xbfa\tb\r\n1\t2\r\n3\t4\r\n",
        b"1,2\n3,4\n5,6\n",
    ]


@cache
def saved_runs() -> Sequence[bytes]:
    """Runs as they are saved: of one robot, and of a team among obstacles."""
    from robotics import make_controller, simulate

    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name, law in (("fuzzy-on-path", "fuzzy"), ("obstacles-on-two-paths", "fuzzy-team")):
            path = Path(folder, "run.npz")
            simulate(replace(load_scenario(name), duration=10.0), make_controller(law), seeds=[0]).save(path)
            found.append(path.read_bytes())
    return found


# What is done with what is accepted ---------------------------------------------------------------------------------


def _nothing(value: Any) -> None:
    """Nothing: reading it checks all of it."""


def _evaluate(fis: Any) -> None:
    """The system answers at the middle and at the corners, and is the same when it is written and read again."""
    text = format_fis(fis)
    if parse_fis(text) != fis:
        raise WrongError("written and read again it is another system")
    ends = np.array([v.universe for v in fis.inputs])
    with np.errstate(all="ignore"):  # parameters of 1e308 give what they give
        for point in (ends.mean(axis=1), ends[:, 0], ends[:, 1]):
            fis(point)


def _same_table(table: Any) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "again.csv")
        write_table(path, table.names if table.headed else None, table.values)
        if not np.array_equal(read_table(path).values, table.values):
            raise WrongError("written and read again the numbers differ")


def _set(scenario: Any) -> None:
    """Everything that a simulation needs can be made."""
    assert scenario.setting is not None


def _play(run: Run) -> None:
    """It can be played, moment by moment."""
    player_data(run)


@cache
def _learner() -> tuple[Sugeno, np.ndarray, np.ndarray]:
    """A small problem of learning: a system, inputs (25, 2) and outputs (25,)."""
    grid = np.linspace(-1, 1, 5)
    x = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    return identify(x, x[:, 0] * x[:, 1], "grid", mfs=2), x, x[:, 0] * x[:, 1]


_OPTIONS = Options(epochs=4)


@cache
def _checkpoints() -> Sequence[bytes]:
    """A checkpoint of a training that is half done."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "half.ck")
        train(*_learner(), Options(epochs=2), checkpoint=path)
        return [path.read_bytes()]


@cache
def _learnt() -> str:
    return format_fis(train(*_learner(), _OPTIONS).system)


def _learn_on(path: Path) -> str:
    return format_fis(train(*_learner(), _OPTIONS, resume=path).system)


def _as_learnt(system: str) -> None:
    """What was accepted leads where learning without a stop leads."""
    if system != _learnt():
        raise WrongError("another system is learnt")


def _read_sentence(path: Path) -> Any:
    terms = {"distance": ["near", "far"], "a b": ["low", "high"], "bearing": ["left", "zero", "right"]}
    text = path.read_bytes().decode("utf-8", "surrogateescape")
    return parse_rule(text, terms, {"v": ["slow", "fast"], "w": ["left", "right"]})


def _same_sentence(rule: Any) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "sentence")
        path.write_text(str(rule), encoding="utf-8", errors="surrogateescape")
        if _read_sentence(path) != rule:
            raise WrongError(f"{rule} comes back as another rule")


SENTENCES = (
    b"if distance is near and bearing is not left then v is slow",
    b"if distance is very far or 'a b' is somewhat high then v is fast and w is left (0.5)",
    b"if (distance is near or bearing is zero) and bearing is right then w is right",
)


@cache
def _design() -> Any:
    return design_of(read_fis(ROOT / "robotics/data/rulebases/tracking.fis"))


@cache
def _messages() -> Sequence[bytes]:
    """A message of each kind, as a page sends it, with fields that many of them have."""
    common = (
        b"kind = 'input'\nvariable = 0\nterm = 'near'\nname = 'x'\nrule = 0\nvalue = 0.5\nparameters = [0, 1, 2]\n"
        b"low = -1.0\nhigh = 1.0\nkey = 1\ntext = 'if distance is near then v is slow'\ntype = 'trimf'\nunit = 'm'\n"
        b"weight = 0.5\nenabled = true\nto = 2\npoint = [0.0, 0.0, 0.0, 0.0]\n"
    )
    return [b"edit = '" + name.encode() + b"'\n" + common for name in EDITS] + [b"look = 'point'\npoint = [1.0, 2.0]\n"]


def _read_message(path: Path) -> Any:
    try:
        message = tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        raise InputError("no message") from None
    return apply(_design(), message)


BORDERS: dict[str, Border] = {
    "fis": Border(".fis", _files("tests/data/fis-corpus/*.fis", "robotics/data/rulebases/*.fis"), read_fis, _evaluate),
    "scenario": Border(
        ".toml",
        _files("robotics/**/data/scenarios/*.toml"),
        load_scenario,
        _set,
    ),
    "robot": Border(".toml", _files("robotics/data/robots/*.toml"), load_robot, _nothing),
    "sweep": Border(".toml", _files("robotics/data/sweeps/*.toml"), load_sweep, _nothing),
    "study": Border(
        ".toml",
        _files("robotics/**/data/studies/*.toml", "docs/examples/own-study/*.toml"),
        load_study,
        _nothing,
    ),
    "table": Border(".csv", _tables, read_table, _same_table),
    "run": Border(".npz", saved_runs, load_run, _play, (flip_bit, *(forge_archive,) * 9)),
    "checkpoint": Border(".ck", _checkpoints, _learn_on, _as_learnt, DAMAGE),
    "sentence": Border(".txt", lambda: SENTENCES, _read_sentence, _same_sentence),
    "message": Border(".toml", _messages, _read_message, lambda design: _evaluate(design.system)),
}
