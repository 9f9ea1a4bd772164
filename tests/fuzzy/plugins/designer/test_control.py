"""The rule tables of fuzzy PD, PI and PID controllers."""

import numpy as np
import pytest

from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.insight.diagnosis import check
from fuzzy.plugins.designer.starts.control import CONTROL_KINDS, CONTROL_TERMS, RuleTableError, rule_table

# The 7 x 7 table as textbooks print it, rows error NB ... PB, columns its rate NB ... PB.
PRINTED = """
    NB NB NB NB NM NS ZE
    NB NB NB NM NS ZE PS
    NB NB NM NS ZE PS PM
    NB NM NS ZE PS PM PB
    NM NS ZE PS PM PB PB
    NS ZE PS PM PB PB PB
    ZE PS PM PB PB PB PB
"""


def test_the_table_of_seven_is_the_printed_one():
    fis = rule_table("pd", 7)
    at = {(r.when[0].term, r.when[1].term): r.then[0][1] for r in fis.rules}
    names = CONTROL_TERMS[7]
    assert [[at[a, b] for b in names] for a in names] == [row.split() for row in PRINTED.strip().splitlines()]


@pytest.mark.parametrize("kind", CONTROL_KINDS)
@pytest.mark.parametrize("terms", CONTROL_TERMS)
def test_it_is_monotone_antisymmetric_complete_and_survives_its_file(kind, terms):
    fis = rule_table(kind, terms)
    assert (len(fis.rules), tuple(v.name for v in fis.outputs)) == (terms**2, CONTROL_KINDS[kind])
    axis = np.linspace(-1.2, 1.2, 49)  # clipped outside the universe
    x = np.stack(np.meshgrid(axis, axis, indexing="ij"), -1)
    z = fis(x)
    assert (np.diff(z, axis=0) >= -1e-12).all()
    assert (np.diff(z, axis=1) >= -1e-12).all()
    np.testing.assert_allclose(z, -fis(-x), atol=1e-12)
    near = np.abs(x).sum(-1) <= 1 - 1 / (terms // 2) + 1e-12  # no cell that touches a saturated corner
    np.testing.assert_allclose(z[near], np.repeat(x[near].sum(-1)[:, None], z.shape[-1], 1), atol=1e-12)
    assert [f for f in check(fis) if f.severity == "error"] == []
    np.testing.assert_allclose(parse_fis(format_fis(fis))(x), z, atol=1e-12)


def test_other_kinds_and_sizes_are_refused_in_a_sentence():
    with pytest.raises(RuleTableError, match="kind of rule table"):
        rule_table("pdd")
    with pytest.raises(RuleTableError, match="3, 5 or 7 terms a variable, got 4"):
        rule_table("pd", 4)
