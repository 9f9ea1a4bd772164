"""What a command line says of a value that it does not accept: our words, the option and what is accepted."""

import pytest

from anfis.commands.application import main as anfis
from fuzzy.commands.application import main as fuzzy
from robotics.commands.application import main as robotics


@pytest.mark.parametrize(
    ("main", "line", "said"),
    [
        (fuzzy, "surface lateral --points 1", "fuzzy surface: --points: must be >= 2"),
        (fuzzy, "surface lateral --points many", "fuzzy surface: --points: must be a whole number"),
        (fuzzy, "plot lateral --kind pie", "--kind: 'pie' is not one of 'memberships', 'rules', 'structure'"),
        (fuzzy, "explain lateral y_err", "fuzzy explain: expected INPUT=VALUE, got 'y_err'"),
        (fuzzy, "explain lateral y_er=1", "fuzzy explain: unknown input 'y_er'; did you mean 'y_err'?"),
        (anfis, "train x.csv -o x.fis --rules 3 --step x", "anfis train: --step: must be a number"),
        (robotics, "run lyapunov-sine --seeds 0", "robotics run: --seeds: must be >= 1"),
        (robotics, "stress crossing --class C", "--class: 'C' is not one of 'A', 'B'"),
        (robotics, "list foo", "SECTION: 'foo' is not one of 'scenarios', 'robots'"),
        (robotics, "certify --form 2.33", "robotics certify: --form: '2.33' is not one of '2.31', '2.32'"),
        (robotics, "certify --speed 0.4 0.2", "--speed: LOW must be at most HIGH; got 0.4 and 0.2 m/s"),
        (
            robotics,
            "run lyapunov-sine --save nowhere/r.npz",
            "nowhere/r.npz: there is no folder 'nowhere' to write into",
        ),
        (robotics, "robot etsroo", "unknown robot 'etsroo'; did you mean 'etsro'?"),
    ],
)
def test_a_refusal_is_in_our_words(main, line, said, capsys):
    assert main(line.split()) == 2
    out, error = capsys.readouterr()
    assert said in error
    assert out == ""
    for theirs in ("Input should", "Value error", "Invalid value", "0 %"):
        assert theirs not in error
