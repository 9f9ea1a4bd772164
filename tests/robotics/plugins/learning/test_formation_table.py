"""Formation data from a file: as it is written here, and as a spreadsheet writes it."""

from pathlib import Path

import numpy as np
import pytest

from fuzzy.errors import InputError
from robotics.plugins.learning.formationdata import FormationRecipe, formation_data
from robotics.plugins.learning.formationlearning import UNITS, FormationLearningError, formation_table

TABLE = formation_data(FormationRecipe(kind="well-posed", samples=12))


def written(folder: Path, more: str = "12:00", lacking: int = -1) -> Path:
    """Semicolons, decimal commas, units, a time and a note, other order."""
    places = list(range(len(TABLE.names)))[::-1]
    lines = [";".join(["Time", *(f"{TABLE.names[k]} [{UNITS[TABLE.names[k]]}]" for k in places), "Note 1"])]
    for row, values in enumerate(TABLE.values.tolist()):
        fields = [f"{values[k]:.6f}".replace(".", ",") if k or row != lacking else "" for k in places]
        lines.append(";".join([more, *fields, "x"]))
    path = folder / "own.csv"
    path.write_text("\r\n".join(lines), encoding="utf-8-sig")
    return path


def test_a_spreadsheet_s_table_holds_the_same_columns(tmp_path: Path) -> None:
    table = formation_table(written(tmp_path))
    assert table.names == TABLE.names[::-1]
    assert table.units == tuple(UNITS[name] for name in table.names)
    np.testing.assert_allclose(table.values, TABLE.values[:, ::-1], atol=1e-9)
    check = formation_table(written(tmp_path, lacking=3), TABLE.names, skip_bad=True)
    np.testing.assert_allclose(check.values, np.delete(TABLE.values, 3, axis=0), atol=1e-9)
    assert check.skipped == (5,)
    with pytest.raises(InputError, match=r"1 of 60 rows has no number in 'dx' \(line 5: the field is empty\)"):
        formation_table(written(tmp_path, lacking=3))


def test_robots_columns_and_what_is_no_formation(tmp_path: Path) -> None:
    path = tmp_path / "robots.csv"
    path.write_text("t,x_err_1 [m],v_1,w_1,x_err_9,v_2,w_2\na,1,2,3,b,4,5\n", encoding="utf-8")
    table = formation_table(path)
    assert table.names == ("x_err_1", "v_1", "w_1", "v_2", "w_2")
    assert table.units[0] == "m"
    path.write_text("1,2\n", encoding="utf-8")
    with pytest.raises(FormationLearningError, match=r"robots\.csv: a header line with the columns' names is needed"):
        formation_table(path)
