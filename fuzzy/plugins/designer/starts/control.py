"""Rule tables of fuzzy PD, PI and PID controllers on normalised variables.

The table is Mac Vicar-Whelan's: the consequent's place is the sum of the places of the two antecedents, saturated at
the ends (P. J. Mac Vicar-Whelan, "Fuzzy sets for man-machine interaction", International Journal of Man-Machine
Studies 8, 1976, pp. 687-697). With triangles that add up to 1, and the product, the surface is e + de wherever no
corner of a cell is saturated. PID has both outputs (W. Z. Qiao and M. Mizumoto, "PID type fuzzy controller and
parameters adaptive method", Fuzzy Sets and Systems 78, 1996, pp. 23-35).
"""

from itertools import product

from fuzzy.errors import InputError
from fuzzy.membership import Triangle
from fuzzy.naming import check_known
from fuzzy.rule import Clause, Rule
from fuzzy.system import Sugeno, Variable

CONTROL_KINDS = {"pd": ("u",), "pi": ("du",), "pid": ("u", "du")}  # and the outputs of each
CONTROL_TERMS = {  # how many terms a variable has, and their names from the lowest to the highest
    3: ("N", "ZE", "P"),
    5: ("NB", "NS", "ZE", "PS", "PB"),
    7: ("NB", "NM", "NS", "ZE", "PS", "PM", "PB"),
}


class RuleTableError(InputError):
    """A kind or a size of which there is no rule table."""


def rule_table(kind: str = "pd", terms: int = 7) -> Sugeno:
    """The rule base of a fuzzy controller: inputs ``error`` and ``error_rate``, all variables in [-1, 1].

    Inputs outside are clipped: how much an error and its rate weigh is said by the loop's scale factors, see
    :func:`fuzzy.plugins.loop.response.step_response`.

    Args:
        kind: "pd" with the output ``u``, "pi" with its rate ``du``, "pid" with both.
        terms: How many terms each variable has: 3, 5 or 7.

    Raises RuleTableError for another kind or number.
    """
    check_known(kind, CONTROL_KINDS, "kind of rule table", RuleTableError)
    if isinstance(terms, bool) or terms not in CONTROL_TERMS:
        raise RuleTableError(f"a rule table has 3, 5 or 7 terms a variable, got {terms!r}")
    names, middle = CONTROL_TERMS[terms], terms // 2
    # Thirds are made of whole numbers, so that neighbours end exactly where a peak is.
    peaks = [(place - middle) / middle for place in range(-1, terms + 1)]
    curves = {name: Triangle(*peaks[place : place + 3]) for place, name in enumerate(names)}
    values = {name: (place - middle) / middle for place, name in enumerate(names)}
    rules = []
    for i, j in product(range(terms), repeat=2):
        consequent = names[min(max(i + j - middle, 0), terms - 1)]
        when = (Clause("error", names[i]), Clause("error_rate", names[j]))
        rules.append(Rule(when, tuple((output, consequent) for output in CONTROL_KINDS[kind])))
    return Sugeno(
        inputs=[Variable(name, (-1.0, 1.0), curves) for name in ("error", "error_rate")],
        outputs=[Variable(name, (-1.0, 1.0), values) for name in CONTROL_KINDS[kind]],
        rules=rules,
        name=f"fuzzy-{kind}-{terms}x{terms}",
        out_of_range="clip",
    )
