import os
import stat

import numpy as np
import pytest

from fuzzy.files.atomic import replacing
from fuzzy.files.table import DataError, read_table, table_text, write_table


def written(folder, text: str | bytes, name: str = "data.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    ("text", "names", "values"),
    [
        ("1,2\n3,4\n", None, [[1, 2], [3, 4]]),
        ("a,b\n1,2\n", ("a", "b"), [[1, 2]]),
        ("a;b\r\n1.5;-2e3\r\n", ("a", "b"), [[1.5, -2000]]),
        ("a\tb\n1\t2\n", ("a", "b"), [[1, 2]]),
        ("\ufeffa, b \n\n 1 , 2 \n\n", ("a", "b"), [[1, 2]]),
        ('"x; y","z, ""q"""\n1,2\n', ("x; y", 'z, "q"'), [[1, 2]]),
        ("İrtifa\n7", ("İrtifa",), [[7]]),
        ("5\n", None, [[5]]),
    ],
)
def test_reads(tmp_path, text: str, names, values) -> None:
    got_names, got = read_table(written(tmp_path, text))
    assert got_names == names
    assert got.dtype == np.float64
    assert got.tolist() == values


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "data.csv: the file is empty"),
        ("\n \n,,\n", "data.csv: the file is empty"),
        ("a,b\n", "data.csv: no row of numbers follows the header 'a,b'"),
        ("1,2\n3\n", "data.csv, line 2: 1 columns where the first row has 2: '3'"),
        ("a,b\n\n1,2,3\n", "data.csv, line 3: 3 columns where the header has 2: '1,2,3'"),
        ("1,2\n3,four\n", "data.csv, line 2, column 2: expected a number, got 'four'"),
        ("a,b\n1,2\n3,nan\n", r"data.csv, line 3, column 2 \(b\): expected a finite number, got 'nan'"),
        ("1,-inf\n", "data.csv, line 1, column 2: expected a finite number, got '-inf'"),
        ("1,1e999\n", "data.csv, line 1, column 2: expected a finite number, got '1e999'"),
        ("1,1_000\n", "data.csv, line 1, column 2: expected a number, got '1_000'"),
        ("1,x\n2,3\n", "data.csv, line 1, column 2: expected a number, got 'x'"),
        ("1,\n", "data.csv, line 1, column 2: the field is empty, expected a number"),
        ("a;b\n1,5;2\n", r"data.csv, line 2, column 1 \(a\): '1,5' has a decimal comma; write '1.5'"),
        (
            "x\n1 2 3\n",
            "data.csv, line 2, column 1 .*'1 2 3' holds several numbers; separate .* commas, semicolons, tabs",
        ),
        ("a,,c\n1,2,3\n", "data.csv, line 1, column 2: the header leaves this column without a name"),
        ("a,b,a\n1,2,3\n", "data.csv, line 1, column 3: a second column is named 'a'"),
        ('1,"2\n', "data.csv, line 1: unexpected end of data"),
        (b"a\xe9\n1\n", "data.csv: not text in UTF-8 .byte 2 is 0xe9"),
        (b"1,2\n3,\x004\n", "data.csv, line 2: a zero byte"),
    ],
)
def test_refuses_and_says_where(tmp_path, text, message: str) -> None:
    with pytest.raises(DataError, match=message):
        read_table(written(tmp_path, text))


def test_a_file_that_is_not_there_and_a_folder(tmp_path) -> None:
    with pytest.raises(DataError, match=r"cannot read .*none.csv: No such file"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(DataError, match=r"cannot read .*: Is a directory"):
        read_table(tmp_path)


def test_a_written_table_reads_back_exactly(tmp_path) -> None:
    values = np.array([[0.1, 1 / 3, -1e-300], [1e300, np.pi, 5e-324]])
    names = ("a", "b, c", 'd"e')
    write_table(tmp_path / "t.csv", names, values)
    got_names, got = read_table(tmp_path / "t.csv")
    assert got_names == names
    assert np.array_equal(got, values)
    write_table(tmp_path / "t.csv", None, values)
    assert read_table(tmp_path / "t.csv")[0] is None
    assert [p.name for p in tmp_path.iterdir()] == ["t.csv"]


def test_seventeen_digits() -> None:
    assert table_text(["x"], np.array([[0.1], [2.0]])) == "x\n0.10000000000000001\n2\n"


def test_names_and_columns_must_agree() -> None:
    with pytest.raises(DataError, match="2 names for 1 columns"):
        table_text(["a", "b"], np.ones((2, 1)))


def test_unwritable_targets(tmp_path) -> None:
    with pytest.raises(DataError, match=r"cannot write .*no/t.csv: there is no folder '.*no' to write into"):
        write_table(tmp_path / "no" / "t.csv", None, np.ones((1, 1)))
    with pytest.raises(DataError, match="is a directory, not a file to write"):
        write_table(tmp_path, None, np.ones((1, 1)))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(tmp_path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(DataError, match=r"cannot write .*t.csv: Permission denied"):
        write_table(tmp_path / "t.csv", None, np.ones((1, 1)))
    tmp_path.chmod(0o700)


def test_a_failed_write_leaves_the_old_file(tmp_path) -> None:
    path = written(tmp_path, "old")

    def fail() -> None:
        with replacing(path) as target:
            target.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["data.csv"]


def test_links_and_permissions_survive(tmp_path) -> None:
    path = written(tmp_path, "old")
    path.chmod(0o640)
    link = tmp_path / "link.csv"
    link.symlink_to(path)
    write_table(link, None, np.ones((1, 1)))
    assert link.is_symlink()
    assert path.read_text() == "1\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_devices_are_written_not_replaced() -> None:
    write_table("/dev/null", None, np.ones((1, 1)))
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)  # noqa: PTH116
