"""ANFIS as what a new rule base begins with."""

import numpy as np

from anfis.plugins.designer.starts import starts
from fuzzy.files.table import read_table
from fuzzy.insight.diagnosis import check
from fuzzy.plugins.designer.starts.own import starts as own
from fuzzy.plugins.designer.starts.samples import example_table


def test_anfis_from_a_table_learns_and_tells_how_far_it_is():
    (start,) = starts()
    told = []
    given = {"file": example_table(), "epochs": "4"}
    fis = start.made(given, "net", lambda share, said: told.append((share, said)))
    assert fis.name == "net"
    assert [share for share, _ in told] == sorted(share for share, _ in told)
    assert told[-1][0] == 1
    assert "RMSE" in told[-1][1]
    values = read_table(example_table()).values
    clusters = next(s for s in own() if s.name == "clusters").made({"file": example_table()}, "first")
    errors = [np.sqrt(np.mean((made(values[:, :-1])[:, 0] - values[:, -1]) ** 2)) for made in (clusters, fis)]
    assert errors[1] < errors[0]  # it learnt something that its first clusters did not know
    assert not [f for f in check(fis) if f.severity == "error"]
