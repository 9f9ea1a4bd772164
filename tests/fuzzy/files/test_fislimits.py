"""Files made to be slow, large or wordy: read in linear time, within limits, and quoted in part."""

import sys
import warnings
from typing import Any

import pytest

from fuzzy.files import fisfile
from fuzzy.files.fisfile import FisFileError, FisFileWarning, format_fis, parse_fis, read_fis
from fuzzy.inference import infer


def text(inputs=1, terms=1, rules=1, name="t", variable="a", function="gaussmf"):
    """A file of many things; ``name`` and ``variable`` are called with a number where they are functions."""

    def named(what, number):
        return what(number) if callable(what) else what

    lines = ["[System]", "Name='x'", "Type='sugeno'", "Version=2.0", f"NumInputs={inputs}", "NumOutputs=1"]
    lines += [f"NumRules={rules}", "AndMethod='prod'", "OrMethod='probor'", "ImpMethod='prod'", "AggMethod='sum'"]
    lines += ["DefuzzMethod='wtaver'"]
    for i in range(1, inputs + 1):
        lines += [f"[Input{i}]", f"Name='{named(variable, i)}'", "Range=[0 1]", f"NumMFs={terms}"]
        lines += [f"MF{t}='{named(name, t)}':'{function}',[1 {t}]" for t in range(1, terms + 1)]
    lines += ["[Output1]", "Name='y'", "Range=[0 1]", "NumMFs=1", "MF1='c':'constant',[1]", "[Rules]"]
    lines += [" ".join([str(1 + r % terms)] * inputs) + ", 1 (1) : 1" for r in range(rules)]
    return "\n".join(lines) + "\n"


def lines_run(**many):
    """Lines of Python that reading runs: what grows with a file, whatever else the machine does."""
    source = text(**many)
    count = 0

    def trace(frame, event, argument):
        nonlocal count
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FisFileWarning)
            parse_fis(source)
    finally:
        sys.settrace(before)
    return count


@pytest.mark.parametrize("what", ["inputs", "terms"])
def test_variables_of_one_name_take_their_number_at_once(what):
    # 1,500 inputs took 6.6 s and 2,300 took 30 s while numbering counted from 2 again for each.
    lines_run(**{what: 1})  # what is done once, whatever is read
    once, twice, fourfold = (lines_run(**{what: count}) for count in (120, 240, 480))
    assert fourfold - twice == pytest.approx(2 * (twice - once), rel=0.02)


def test_names_that_are_numbered_already_are_numbered_on():
    names = iter(["t", "t_2", "t", "t_3", "t", "t"])
    with pytest.warns(FisFileWarning):
        fis = parse_fis(text(terms=6, name=lambda _: next(names)))
    assert list(fis["a"].terms) == ["t", "t_2", "t_3", "t_3_2", "t_4", "t_5"]


def test_rules_times_terms_need_no_memory_of_that_size():
    """20,000 terms and rules took 3 GB; the matrix is made where it is used, and never above a size."""
    fis = parse_fis(text(terms=4500, rules=4500, name=lambda n: f"t{n}"))
    assert "incidence" not in vars(fis.structure)
    output = infer(fis, [[0.5]])
    assert output.output.shape == (1, 1)
    assert "incidence" not in vars(fis.structure)
    assert parse_fis(format_fis(fis)) == fis


@pytest.mark.parametrize("library", ["numpy", "torch"])
def test_without_the_matrix_the_strengths_are_the_same(library, monkeypatch):
    import numpy as np
    import torch

    from fuzzy import inference

    source = text(inputs=3, terms=4, rules=9).replace("2 2 2, 1", "0 -2 2.20, 1").replace("-", "")
    with pytest.warns(FisFileWarning):
        fis = parse_fis(source)
    x = np.random.default_rng(1).uniform(0, 1, (2, 5, 3))
    points: Any = x if library == "numpy" else torch.tensor(x)
    with_matrix = infer(fis, points)
    monkeypatch.setattr(inference, "_DENSE", 0)
    without = infer(fis, points)
    np.testing.assert_allclose(np.asarray(without.firing), np.asarray(with_matrix.firing), rtol=1e-13)
    np.testing.assert_allclose(np.asarray(without.output), np.asarray(with_matrix.output), rtol=1e-13)


@pytest.mark.parametrize(
    ("key", "value", "most"),
    [("NumInputs", 1001, 1000), ("NumOutputs", 10**9 - 1, 1000), ("NumMFs", 10_001, 10_000), ("NumRules", 100_001, 0)],
)
def test_more_than_anybody_reads_is_refused_with_the_limit(key, value, most):
    source = text().replace(f"{key}=1", f"{key}={value}", 1)
    with pytest.raises(FisFileError, match=rf"<text>:\d+: {key} is {value}, but at most {most or 100_000} are read"):
        parse_fis(source)


LONG = "a" * 200_000


@pytest.mark.parametrize(
    "source",
    [
        LONG,
        f"[{LONG}]",
        "[System]\n" + LONG,
        f"[System]\n{LONG}=1",
        f"[System]\nName='{LONG}'\nType='{LONG}'",
        text().replace("'x'", f"'{LONG}"),
        text().replace("NumRules=1", f"NumRules={LONG}"),
        text().replace("'gaussmf'", f"'{LONG}'"),
        text().replace("'t':", f"'{LONG}':").replace("[1 1]", "[0 1]"),
        text().replace("[1 1]", f"[1 {LONG}]"),
        text().replace("Range=[0 1]", f"Range={LONG}"),
        text().replace("Range=[0 1]", "Range=[1 0]").replace("'a'", f"'{LONG}'"),
        text().replace("(1)", f"({LONG})"),
        text().replace(": 1", f": {LONG}"),
        text().replace("1, 1 ", f"{LONG}, 1 "),
        text().replace("1, 1 ", f"1, {'1' * 100_000} "),
        text().replace("1, 1 ", "2, 1 ").replace("'t'", f"'{LONG}'"),
    ],
    ids=range(17),
)
def test_a_message_quotes_the_beginning_of_what_is_long(source):
    with pytest.raises(FisFileError) as caught:
        parse_fis(source)
    assert len(str(caught.value)) < 3000
    assert "characters)" in str(caught.value)


def test_of_many_warnings_some_are_shown_and_the_rest_is_counted():
    source = text(inputs=100, variable=LONG[:5000])
    with pytest.warns(FisFileWarning) as caught:
        parse_fis(source)
    assert len(caught) == 21
    assert "79 more warnings" in str(caught[-1].message)
    assert sum(len(str(w.message)) for w in caught) < 21 * 800


def test_the_limits_hold_for_a_file_too(tmp_path, monkeypatch):
    monkeypatch.setattr(fisfile, "_MOST_RULES", 2)
    (tmp_path / "a.fis").write_text(text(rules=3))
    with pytest.raises(FisFileError, match="at most 2 are read"):
        read_fis(tmp_path / "a.fis")
