"""A bounded assault on every border, with seeds fixed; ``python -m benchmarks.fuzzing`` goes on for longer."""

from pathlib import Path

import pytest

from tests.fuzzing.borders import BORDERS, assault, kinds

SEED = 20261122
# As many as a second or two allows; runs and sweeps take longer than a line of text.
COUNTS = {
    "fis": 250,
    "scenario": 80,
    "robot": 70,
    "sweep": 60,
    "study": 80,
    "table": 300,
    "run": 80,
    "checkpoint": 120,
}


@pytest.mark.parametrize("name", BORDERS)
def test_only_sentences_come_out(name: str) -> None:
    count = COUNTS.get(name, 250)
    tally = assault(BORDERS[name], SEED, range(count))
    assert not tally.escaped, kinds(tally)
    assert tally.accepted + tally.refused == count
    assert tally.refused > count // 10  # the damage is damage
    if name == "checkpoint":  # its checksum is that of the whole file: no damage passes
        assert tally.accepted == 0
    else:
        assert tally.accepted > count // 100  # and the border lets good files through
    assert tally.slowest < 20.0  # s of processor time: nothing there is quadratic


@pytest.mark.parametrize("name", ["run", "checkpoint"])
def test_what_is_not_damaged_is_accepted(name: str, tmp_path: Path) -> None:
    border = BORDERS[name]
    for number, content in enumerate(border.corpus()):
        path = tmp_path / f"{number}{border.suffix}"
        path.write_bytes(content)
        border.use(border.read(path))
