"""The .fis files: real ones against Octave, exact round trips, and what is refused and where."""

import pickle
import re
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy.files.fisfile import FisFileError, FisFileWarning, format_fis, parse_fis, read_fis, read_mamdani, write_fis
from fuzzy.inference import InferenceWarning
from fuzzy.membership import FUNCTIONS, Gaussian, LinearZ, Triangle
from fuzzy.membershipfunction import MembershipError
from fuzzy.plugins.mamdani.hedges import without_hedges
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, Linear, Sugeno, Variable
from tests.randomcases import cases

CORPUS = Path(__file__).parents[2] / "data" / "fis-corpus"
SUGENO = sorted(CORPUS.glob("s*.fis"))
MAMDANI = sorted(CORPUS.glob("m*.fis"))

TIP = """\
[System]
Name='tip'
Type='sugeno'
Version=2.0
NumInputs=2
NumOutputs=1
NumRules=2
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'

[Input1]
Name='service'
Range=[0 10]
NumMFs=2
MF1='poor':'trimf',[-5 0 5]
MF2='good':'gaussmf',[2 10]

[Input2]
Name='food'
Range=[0 10]
NumMFs=1
MF1='rancid':'linzmf',[1 3]

[Output1]
Name='tip'
Range=[0 30]
NumMFs=2
MF1='cheap':'constant',[5]
MF2='fair':'linear',[1 0.5 10]

[Rules]
1 1, 1 (1) : 2
2 -1, 2 (0.5) : 1
"""


def tip(old="", new=""):
    assert old in TIP
    return TIP.replace(old, new, 1)


# Reading ------------------------------------------------------------------------------------------------------


def test_the_corpus_is_there():
    assert (len(SUGENO), len(MAMDANI)) == (5, 3)


@pytest.mark.parametrize("reference", ["octave", "ref_numpy"])
@pytest.mark.parametrize("path", SUGENO, ids=lambda path: path.stem)
def test_real_files_give_the_outputs_of_octave_and_of_matlabs_documentation(path, reference):
    fis = read_fis(path)
    x = np.loadtxt(path.with_suffix(".inputs.csv"), delimiter=",", ndmin=2)
    wanted = np.loadtxt(path.with_suffix(f".{reference}.csv"), delimiter=",", ndmin=2)
    defined = ~np.isnan(wanted).any(axis=-1)  # Octave raises an error where no rule fires
    assert defined.mean() > 0.5
    span = np.ptp(wanted[defined], axis=0)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*no rule fires", InferenceWarning)
        got = fis(x)
    assert np.all(np.abs(got - wanted)[defined] <= 1e-12 * span)


@pytest.mark.parametrize("path", MAMDANI, ids=lambda path: path.stem)
def test_a_mamdani_file_is_recognised_and_refused(path):
    with pytest.raises(FisFileError, match=r"Mamdani.*only Sugeno systems") as caught:
        read_fis(path)
    assert caught.value.path == str(path)
    assert caught.value.line == 3


def test_everything_in_a_file_arrives():
    fis = parse_fis(TIP)
    assert fis == Sugeno(
        [
            Variable("service", (0, 10), {"poor": Triangle(-5, 0, 5), "good": Gaussian(2, 10)}),
            Variable("food", (0, 10), {"rancid": LinearZ(1, 3)}),
        ],
        [Variable("tip", (0, 30), {"cheap": Constant(5.0), "fair": Linear((1.0, 0.5), 10.0)})],
        [
            Rule((Clause("service", "poor"), Clause("food", "rancid")), (("tip", "cheap"),), "or"),
            Rule((Clause("service", "good"), Clause("food", "rancid", True)), (("tip", "fair"),), "and", 0.5),
        ],
        name="tip",
    )
    # service 9: poor 0, good exp(-1/8); food 1.5: rancid 3/4; rules 1 and 2 weigh 3/4 and exp(-1/8)/4/2.
    second = np.exp(-1 / 8) / 4 / 2
    np.testing.assert_allclose(fis([9.0, 1.5]), [(0.75 * 5 + second * 19.75) / (0.75 + second)], rtol=1e-14)


SAME = {
    "blanks": re.sub("=", " = ", TIP).replace("':'", "' : '").replace("',[", "', [ ").replace("]\n", " ]  \n"),
    "no final newline": TIP.rstrip("\n"),
    "windows": TIP.replace("\n", "\r\n"),
    "old mac": TIP.replace("\n", "\r"),
    "byte order mark": "\ufeff" + TIP,
    "comments": "% a comment\n# another\n// a third\n" + TIP.replace("\n\n", "\n% [Input9]\n\n  # NumMFs=9\n"),
    "sections backwards": "\n".join(reversed(re.split(r"\n(?=\[)", TIP))),
    "letter case": TIP.replace("NumMFs", "nummfs").replace("'prod'", "'Prod'", 1).replace("[Rules]", "[RULES]"),
    "mf types in capitals": tip("'trimf'", "'TriMF'"),
    "commas between numbers": tip("[-5 0 5]", "[-5, 0,5]"),
    "other spellings of numbers": tip("[-5 0 5]", "[-5.000 +0 .5E1]"),
    "fuzzylite": TIP.replace("Range=", "Enabled=1\nLockRange=0\nDefault=nan\nLockPrevious=0\nRange="),
    "no version": tip("Version=2.0\n"),
    "leading zeros": tip("1 1, 1 (1) : 2", "01 1, 1 (1.0) : 2"),
}


@pytest.mark.parametrize("text", SAME.values(), ids=SAME.keys())
def test_the_same_system_in_another_dress(text):
    assert text != TIP
    assert parse_fis(text) == parse_fis(TIP)


def test_names_as_real_files_have_them():
    text = tip("'poor'", "'y=2x1+2x2;'").replace("'good'", "'y=4x1-x2;'").replace("'service'", "'f_0(f27s1)'")
    text = text.replace("'food'", "'theta_{FA}'").replace("'rancid'", "'it's // 50% # '")
    fis = parse_fis(text)
    assert [v.name for v in fis.inputs] == ["f_0(f27s1)", "theta_{FA}"]
    assert list(fis.inputs[0].terms) == ["y=2x1+2x2;", "y=4x1-x2;"]
    assert list(fis.inputs[1].terms) == ["it's // 50% # "]


def test_a_file_without_rules_and_with_unused_terms():
    text = TIP[: TIP.index("[Rules]")].replace("NumRules=2", "NumRules=0")
    fis = parse_fis(text)
    assert fis.rules == ()
    assert len(fis.inputs[0].terms) == 2
    assert parse_fis(format_fis(fis)) == fis


def test_zero_leaves_a_variable_out_and_a_sign_negates():
    fis = parse_fis(tip("1 1, 1 (1) : 2", "-2 0, 1 (0.25) : 1"))
    assert fis.rules[0] == Rule((Clause("service", "good", True),), (("tip", "cheap"),), "and", 0.25)


@pytest.mark.parametrize(
    ("index", "clause"),
    [
        ("1.05", Clause("service", "poor", False, 0.5)),
        ("-1.20", Clause("service", "poor", True, 2.0)),
        ("2.3", Clause("service", "good", False, 3.0)),
        ("2.13", Clause("service", "good", False, 1.3)),
    ],
)
def test_fractions_are_octaves_hedges(index, clause):
    rule = f"{index} 0, 1 (1) : 1"
    said = f"<text>:35: {index} is read as Octave's hedge, '{clause}'; the line: {rule}"
    with pytest.warns(FisFileWarning, match=f"^{re.escape(said)}$"):
        fis = parse_fis(tip("1 1, 1 (1) : 2", rule))
    assert fis.rules[0].when == (clause,)
    assert parse_fis(format_fis(fis)) == fis  # what this program has written is meant


def test_writing_says_that_matlab_knows_no_hedges(tmp_path):
    fis = parse_fis(TIP)
    write_fis(fis, tmp_path / "plain.fis")
    hedged = replace(fis, rules=[*fis.rules, "if service is very good then tip is fair"])
    with pytest.warns(FisFileWarning, match=r"MATLAB cannot .*, 1 clause such as 'service is very good'; .*without"):
        write_fis(hedged, tmp_path / "hedged.fis")
    assert read_fis(tmp_path / "hedged.fis") == hedged
    write_fis(without_hedges(hedged), tmp_path / "hedged.fis")
    with pytest.raises(FisFileError, match="unknown Hedges 'matlab'"):
        parse_fis(tip("Version=2.0", "Version=2.0\n%! Hedges='matlab'"))


def test_zeros_behind_the_parameters_are_left_out(tmp_path):
    plain = tip("'trimf',[-5 0 5]", "'gbellmf',[2 4 -4]").replace("'linzmf'", "'zmf'")
    padded = plain.replace("[2 4 -4]", "[2 4 -4 0]").replace("[1 3]", "[1 3 0 0]").replace("[5]", "[5 0 0 0]")
    with pytest.warns(FisFileWarning, match=r"<text>:18: zeros behind .*old files, are left out of 3 terms") as caught:
        assert parse_fis(padded) == parse_fis(plain)
    assert len(caught) == 1
    mamdani = tmp_path / "old.fis"
    mamdani.write_text(re.sub(r"('trimf',\[[^]]*)", r"\1 0", MAMDANI[0].read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.warns(FisFileWarning, match="zeros behind"):
        assert read_mamdani(mamdani) == read_mamdani(MAMDANI[0])


def test_names_that_occur_twice_are_numbered():
    text = tip("'good'", "'poor'").replace("'food'", "'service'").replace("'fair'", "'cheap'")
    with pytest.warns(FisFileWarning) as caught:
        fis = parse_fis(text)
    assert [v.name for v in fis.inputs] == ["service", "service_2"]
    assert list(fis.inputs[0].terms) == ["poor", "poor_2"]
    assert list(fis.outputs[0].terms) == ["cheap", "cheap_2"]
    assert [str(w.message).split(": ")[0] for w in caught] == ["<text>:19", "<text>:22", "<text>:32"]
    np.testing.assert_array_equal(fis([9.0, 1.5]), parse_fis(TIP)([9.0, 1.5]))


def test_a_disabled_variable_is_warned_of():
    with pytest.warns(FisFileWarning, match=r"<text>:16: Enabled .* 'service' takes part"):
        parse_fis(tip("Range=", "Enabled=0\nRange="))


def test_notes_carry_what_the_format_lacks():
    text = tip("DefuzzMethod='wtaver'", "DefuzzMethod='wtaver'\n%! NoRuleFires='nan'\n%! OutOfRange='clip'")
    fis = parse_fis(text.replace("Name='food'", "Name='food'\n%! Unit='°C'"))
    assert (fis.no_rule_fires, fis.out_of_range, fis.inputs[1].unit) == ("nan", "clip", "°C")
    written = format_fis(fis)
    assert "%! NoRuleFires='nan'" in written
    assert "%! Unit='°C'" in written
    assert parse_fis(written) == fis
    assert "%!" not in format_fis(parse_fis(TIP))


def test_an_unknown_note_is_skipped_with_a_warning():
    with pytest.warns(FisFileWarning, match=r"<text>:2: .*'NoRuleFire'"):
        assert parse_fis(tip("[System]", "[System]\n%! NoRuleFire='nan'")) == parse_fis(TIP)


def test_implication_and_aggregation_are_kept_and_mean_nothing():
    fis = parse_fis(tip("AggMethod='sum'", "AggMethod='Max'"))
    assert fis.aggregation == "Max"
    assert "AggMethod='Max'" in format_fis(fis)
    np.testing.assert_array_equal(fis([9.0, 1.5]), parse_fis(TIP)([9.0, 1.5]))


# Refusing -----------------------------------------------------------------------------------------------------

REFUSED = [
    ("Type='sugeno'", "Type='mamdani'", 3, "Mamdani"),
    ("Type='sugeno'", "Type='suegno'", 3, "did you mean 'sugeno'?"),
    ("Type='sugeno'", "Type='sugenotype2'", 3, "MATLAB's own text of a type-2 system"),
    ("Type='sugeno'", "Type=sugeno", 3, "Type must stand in single quotes, got 'sugeno'"),
    ("Type='sugeno'\n", "", 1, "[System] has no Type"),
    ("[System]\n", "", 1, "expected a section, '[System]'"),
    ("[System]", "[Sytem]", 1, "unknown section 'Sytem'; did you mean 'System'?"),
    ("[Input2]", "[Input1]", 21, "a second [Input1]; the first is in line 14"),
    ("[Input2]", "[Input3]", 21, "NumInputs is 2, but the file has [Input3]"),
    ("NumInputs=2", "NumInputs=3", 5, "NumInputs is 3, but the file has no [Input3]"),
    ("NumInputs=2", "NumInputs=0", 5, "at least one input"),
    ("NumInputs=2", "NumInputs=two", 5, "got 'two'"),
    ("NumInputs=2", "NumInput=2", 5, "unknown key 'NumInput'; did you mean 'NumInputs'?"),
    ("NumInputs=2", "NumInputs 2", 5, "expected 'key=value'"),
    ("NumInputs=2", "NumInputs=2\nNumInputs=2", 6, "a second NumInputs; the first is in line 5"),
    ("NumRules=2", "NumRules=3", 7, "NumRules is 3, but the file has 2 rules"),
    ("NumRules=2", "NumRules=99999999999999999999", 7, "NumRules must be a number"),
    ("AndMethod='prod'", "AndMethod='myand'", 8, "; did you mean 'min'? Known: prod, min"),
    ("OrMethod='probor'", "OrMethod='probar'", 9, "did you mean 'probor'? Known: probor, max"),
    ("DefuzzMethod='wtaver'", "DefuzzMethod='centroid'", 12, "Known: wtaver, wtsum"),
    ("DefuzzMethod='wtaver'", "DefuzzMethod='wtaver'\n%! NoRuleFires='never'", 13, "Known: midrange, nan, error"),
    ("DefuzzMethod='wtaver'", "DefuzzMethod='wtaver'\n%! OutOfRange=clip", 13, "must stand in single quotes"),
    ("Range=[0 10]", "Range=[10 0]", 16, "ascending"),
    ("Range=[0 10]", "Range=[0 inf]", 16, "Range: expected a finite number, got 'inf'"),
    ("Range=[0 10]", "Range=[0 1e999]", 16, "Range: expected a finite number, got '1e999'"),
    ("Range=[0 10]", "Range=[0 10 20]", 16, "Range must be two numbers"),
    ("Range=[0 10]", "Range=0 10", 16, "Range must be two numbers"),
    ("Range=[0 10]\n", "", 14, "[Input1] has no Range"),
    ("NumMFs=2", "NumMFs=1", 19, "NumMFs is 1, but [Input1] has MF2"),
    ("NumMFs=2", "NumMFs=3", 17, "NumMFs is 3, but there is no MF3"),
    ("MF2=", "MF1=", 19, "a second MF1; the first is in line 18"),
    ("MF2=", "NF2=", 19, "unknown key 'NF2'"),
    ("'poor':'trimf'", "'poor':'trinf'", 18, "poor: unknown membership function 'trinf'; did you mean 'trimf'?"),
    ("'poor':'trimf'", "'poor':'custommf'", 18, "Known: trimf, trapmf, linsmf, linzmf, gaussmf, gauss2mf, gbellmf"),
    ("'poor':'trimf'", "'poor':'constant'", 18, "unknown membership function 'constant'"),
    ("'poor':'trimf'", "'poor','trimf'", 18, "expected MF1='name':'trimf',[a b c]"),
    ("[-5 0 5]", "[-5 0 5],[1 1]", 18, "expected MF1='name':'trimf',[a b c]"),
    ("[-5 0 5]", "[-5 0 5", 18, "expected MF1='name':'trimf',[a b c]"),
    ("[-5 0 5]", "[-5 0 5 1 0]", 18, "trimf takes 3 parameters [a b c], got 5"),
    ("[-5 0 5]", "[-5 0]", 18, "trimf takes 3 parameters [a b c], got 2"),
    ("[-5 0 5]", "[-5 0 nan]", 18, "poor: trimf: expected a finite number, got 'nan'"),
    ("[-5 0 5]", "[-5 0 1_0]", 18, "expected a finite number, got '1_0'"),
    ("[-5 0 5]", "[5 0 -5]", 18, "a <= b <= c"),
    ("[2 10]", "[0 10]", 19, "sigma must not be 0"),
    ("'constant',[5]", "'constant',[5 6]", 31, "cheap: constant takes 1 parameter [c], got 2"),
    ("'constant',[5]", "'trimf',[1 2 3]", 31, "unknown Sugeno consequent 'trimf'. Known: constant, linear"),
    ("[1 0.5 10]", "[1 10]", 32, "linear takes 3 parameters [p1 ... pn p0], one an input and the constant, got 2"),
    ("1 1, 1 (1) : 2", "1 1 1 (1) : 2", 35, "expected a rule"),
    ("1 1, 1 (1) : 2", "1 1, 1 (1)", 35, "expected a rule"),
    ("1 1, 1 (1) : 2", "1 1, 1 (1) : 3", 35, "expected 1 (and) or 2 (or) after ':', got '3'"),
    ("1 1, 1 (1) : 2", "1 1, 1 (1.5) : 2", 35, "the weight must be a number in [0, 1], got '1.5'"),
    ("1 1, 1 (1) : 2", "1 1, 1 () : 2", 35, "the weight must be a number in [0, 1], got ''"),
    ("1 1, 1 (1) : 2", "1 1, 1 (nan) : 2", 35, "weight: expected a finite number, got 'nan'"),
    ("1 1, 1 (1) : 2", "1, 1 (1) : 2", 35, "expected 2 input terms, one for each input, got 1"),
    ("1 1, 1 (1) : 2", "1 1, 1 1 (1) : 2", 35, "expected 1 output terms"),
    ("1 1, 1 (1) : 2", "1 2, 1 (1) : 2", 35, "'food' has no term number 2; it has 1 'rancid'"),
    ("1 1, 1 (1) : 2", "1 1, 3 (1) : 2", 35, "'tip' has no term number 3; it has 1 'cheap', 2 'fair'"),
    ("1 1, 1 (1) : 2", "0.2 1, 1 (1) : 2", 35, "'service' has no term number 0.2"),
    ("1 1, 1 (1) : 2", "1.001 1, 1 (1) : 2", 35, "the hedge of 1.001"),
    ("1 1, 1 (1) : 2", "x 1, 1 (1) : 2", 35, "expected the number of a term of 'service', got 'x'"),
    ("1 1, 1 (1) : 2", "1 1, -1 (1) : 2", 35, "no 'not' and no hedge"),
    ("1 1, 1 (1) : 2", "0 0, 1 (1) : 2", 35, "a rule needs an input that is not 0"),
    ("1 1, 1 (1) : 2", "1 1, 0 (1) : 2", 35, "a rule needs an output that is not 0"),
]


@pytest.mark.parametrize(("old", "new", "line", "reason"), REFUSED)
def test_a_malformed_file_is_refused_at_its_line(old, new, line, reason):
    text = tip(old, new)
    with pytest.raises(FisFileError) as caught:
        parse_fis(text, "tip.fis")
    error = caught.value
    assert (error.path, error.line) == ("tip.fis", line)
    assert reason in str(error)
    assert str(error).startswith(f"tip.fis:{line}: ")
    assert str(error).endswith("\n  " + text.split("\n")[line - 1])
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"% only a comment\n", "it has no section [System]"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "it holds binary data"),
        (TIP.encode("utf-16"), "it holds binary data"),
    ],
)
def test_a_file_that_is_no_fis_file(tmp_path, content, reason):
    path = tmp_path / "x.fis"
    path.write_bytes(content)
    with pytest.raises(FisFileError, match=re.escape(f"{path}: ") + f".*{re.escape(reason)}"):
        read_fis(path)


def test_a_folder_and_a_missing_file(tmp_path):
    with pytest.raises(FisFileError, match="cannot be read"):
        read_fis(tmp_path)
    with pytest.raises(FisFileError, match="cannot be read"):
        read_fis(tmp_path / "missing.fis")
    with pytest.raises(FisFileError, match="cannot be read"):
        read_fis("nul\0.fis")


@settings(max_examples=cases(200))
@given(st.integers(0, len(TIP)), st.integers(0, 6), st.text("[]()'=:,%! \n0123456789.-eMFx", max_size=4))
def test_any_damage_is_read_or_refused(place, length, new):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FisFileWarning)
        try:
            fis = parse_fis(TIP[:place] + new + TIP[place + length :])
        except FisFileError:
            return
        assert parse_fis(format_fis(fis)) == fis


def test_an_old_file_in_a_windows_encoding(tmp_path):
    path = tmp_path / "old.fis"
    path.write_bytes(tip("'food'", "'größe'").encode("cp1252"))
    with pytest.warns(FisFileWarning, match=r"old.fis:22: .*cp1252"):
        assert read_fis(path).inputs[1].name == "größe"


# Writing ------------------------------------------------------------------------------------------------------

NAMES = st.one_of(
    st.text(st.characters(exclude_characters="\n\r\0", exclude_categories=["Cs"]), max_size=8),
    st.sampled_from(
        ["a", "it's", "'", "''", "':'", "a':'trimf',[1 2 3]", "y=2x1+2x2;", "[Rules]", "% a", "%! Unit='m'"]
    ),
    st.sampled_from(
        ["f_0(f27s1)", "theta_{FA}", " a ", "a'", "'a", "//", "#", ",", "\x85", "\u2028", "\x1c", "\ufeff"]
    ),
)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False)
POWERS = st.one_of(st.just(1.0), st.integers(1, 99).map(lambda tenths: tenths / 10))


@st.composite
def membership_functions(draw):
    function = draw(st.sampled_from(FUNCTIONS))
    parameters = draw(st.lists(NUMBERS, min_size=len(function.__match_args__), max_size=len(function.__match_args__)))
    try:
        return function(*parameters)
    except MembershipError:
        return draw(st.just(Triangle(*sorted(parameters)[:1] * 3)))


def variables(terms):
    ranges = st.tuples(NUMBERS, NUMBERS).map(lambda ends: tuple(sorted(ends)))
    variable = st.builds(Variable, NAMES, ranges, st.dictionaries(NAMES, terms, max_size=3), NAMES)
    return st.lists(variable, min_size=1, max_size=3, unique_by=lambda v: v.name)


@st.composite
def systems(draw):
    inputs = draw(variables(membership_functions()))
    constant = st.builds(Constant, NUMBERS)
    linear = st.builds(Linear, st.lists(NUMBERS, min_size=len(inputs), max_size=len(inputs)), NUMBERS)
    outputs = draw(variables(st.one_of(constant, linear)))
    rules = []
    for _ in range(draw(st.integers(0, 4))):
        when = [
            Clause(v.name, draw(st.sampled_from(list(v.terms))), draw(st.booleans()), draw(POWERS))
            for v in inputs
            if v.terms and draw(st.booleans())
        ]
        then = [(v.name, draw(st.sampled_from(list(v.terms)))) for v in outputs if v.terms and draw(st.booleans())]
        if when and then:
            rules.append(Rule(tuple(when), tuple(then), draw(st.sampled_from(["and", "or"])), draw(st.floats(0, 1))))
    return Sugeno(
        inputs,
        outputs,
        rules,
        draw(NAMES),
        draw(st.sampled_from(["prod", "min"])),
        draw(st.sampled_from(["probor", "max"])),
        draw(st.sampled_from(["wtaver", "wtsum"])),
        draw(st.sampled_from(["midrange", "nan", "error"])),
        draw(st.sampled_from(["warn", "ignore", "clip", "error"])),
        draw(NAMES),
        draw(NAMES),
    )


@settings(max_examples=cases(150))
@given(systems())
def test_every_system_reads_back_to_the_last_bit(fis):
    text = format_fis(fis)
    again = parse_fis(text)
    assert again == fis
    assert format_fis(again) == text  # tells 0.0 from -0.0


@pytest.mark.parametrize("path", SUGENO, ids=lambda path: path.stem)
def test_real_files_survive_reading_and_writing(path, tmp_path):
    fis = read_fis(path)
    write_fis(fis, tmp_path / "copy.fis")
    assert read_fis(tmp_path / "copy.fis") == fis
    # The files' own numbers come back as they were: nothing is added to 15 digits.
    numbers = re.compile(r"\[([^\]]*)\]")
    original = numbers.findall(path.read_text(encoding="utf-8"))
    assert numbers.findall((tmp_path / "copy.fis").read_text(encoding="utf-8")) == [
        re.sub(r"(\d)\.0+(?=\s|$)", r"\1", words) for words in original
    ]


def test_matlabs_own_layout_is_reproduced():
    assert format_fis(parse_fis(TIP)) == TIP


def test_parameters_in_training_are_written_as_numbers():
    number = torch.tensor(0.1, dtype=torch.float64, requires_grad=True)
    fis = Sugeno(
        [Variable("x", (0, 1), {"a": Gaussian(number, number)})],
        [Variable("y", (0, 1), {"a": Constant(number), "b": Linear(torch.stack([number]), number)})],
        ["if x is a then y is b"],
    )
    text = format_fis(fis)
    assert "MF1='a':'gaussmf',[0.1 0.1]" in text
    assert "MF1='a':'constant',[0.1]\nMF2='b':'linear',[0.1 0.1]" in text


def one_rule(rule, name="x", value=1.0):
    inputs = [Variable(name, (0, 1), {"a": Triangle(0, 0, 1)})]
    return Sugeno(inputs, [Variable("y", (0, 1), {"b": Constant(value)})], [rule])


@pytest.mark.parametrize(
    ("fis", "reason"),
    [
        (one_rule("if 'two\nlines' is a then y is b", "two\nlines"), "no room for a line end in a name: 'two\\nlines'"),
        (one_rule("if x is a then y is b", value=float("nan")), "y is b: a parameter must be finite, got nan"),
        (one_rule("if x is a then y is b", value=torch.zeros(2)), "y is b: a parameter is one number"),
        (one_rule("if x is a^1.25 then y is b"), "no room for the power 1.25"),
        (one_rule("if x is a^10 then y is b"), "no room for the power 10.0"),
        (one_rule("if x is a^0.01 then y is b"), "no room for the power 0.01"),
        (replace(one_rule("if x is a then y is b"), name="\ud800"), "no valid text"),
    ],
)
def test_what_the_format_cannot_hold_is_refused_and_the_old_file_stays(fis, reason, tmp_path):
    path = tmp_path / "out.fis"
    path.write_text("old")
    with pytest.raises(FisFileError, match=re.escape(reason)) as caught:
        write_fis(fis, path)
    assert str(caught.value).startswith(f"{path}: ")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_writing_replaces_a_file_and_leaves_nothing_beside_it(tmp_path):
    path = tmp_path / "tip.fis"
    path.write_text("old")
    write_fis(parse_fis(TIP), path)
    assert path.read_bytes() == TIP.encode()
    assert list(tmp_path.iterdir()) == [path]


def test_writing_where_nothing_can_be_written(tmp_path):
    for path in (tmp_path, tmp_path / "missing" / "tip.fis"):
        with pytest.raises(FisFileError, match="cannot be written"):
            write_fis(parse_fis(TIP), path)


def test_a_file_is_read_by_a_process_that_has_used_nothing_else(tmp_path):
    write_fis(parse_fis(SHOULDERS), tmp_path / "own.fis")
    code = "import fuzzy; print(fuzzy.read_fis('own.fis').name)"
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (0, "shoulders\n"), done.stderr


SHOULDERS = """
[System]
Name='shoulders'
Type='sugeno'
NumInputs=1
NumOutputs=1
NumRules=1
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'
[Input1]
Name='x'
Range=[0 1]
NumMFs=1
MF1='near':'linzmf',[0.1 0.6]
[Output1]
Name='y'
Range=[0 1]
NumMFs=1
MF1='one':'constant',[1]
[Rules]
1, 1 (1) : 1
"""
