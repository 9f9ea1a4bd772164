import os
import stat

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy.files.atomic import replacing
from fuzzy.files.header import columns_of, place_of
from fuzzy.files.table import BadRowsError, DataError, parse_table, read_table, table_text, write_table


def written(folder, text: str | bytes, name: str = "data.csv"):
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize(
    ("text", "titles", "values"),
    [
        ("1,2\n3,4\n", None, [[1, 2], [3, 4]]),
        ("a,b\n1,2\n", "a b", [[1, 2]]),
        ("a;b\r\n1.5;-2e3\r\n", "a b", [[1.5, -2000]]),
        ("a\tb\n1\t2\n", "a b", [[1, 2]]),
        ("a,b\r1,2\r", "a b", [[1, 2]]),
        ("\ufeffa, b \n\n 1 , 2 \n\n", "a b", [[1, 2]]),
        ("a;b\n1,5;2\n".encode("utf-16"), "a b", [[1.5, 2]]),  # as Excel saves Unicode text
        (b"\xfe\xff" + "a\tb\n1,5\t2\n".encode("utf-16-be"), "a b", [[1.5, 2]]),
        ("sep=;\na;b\n1;2\n", "a b", [[1, 2]]),
        ("İrtifa\n7", "İrtifa", [[7]]),
        ("5\n", None, [[5]]),
        ("1,5;2,25\n,5;-3,\n", None, [[1.5, 2.25], [0.5, -3]]),
        ("a;b\n1,500;2\n3;4\n", "a b", [[1.5, 2], [3, 4]]),  # semicolons: the comma is the decimal mark
        ('a,b\n"1,5",2\n"1,500",3\n', "a b", [[1.5, 2], [1.5, 3]]),
        ("a\tb\n1,500\t0,5\n", "a b", [[1.5, 0.5]]),
        ("a;b\n1.234;5\n", "a b", [[1.234, 5]]),
    ],
)
def test_reads(tmp_path, text: str, titles, values) -> None:
    got = read_table(written(tmp_path, text))
    assert got.names == (tuple(titles.split()) if titles else tuple(f"column{k + 1}" for k in range(len(values[0]))))
    assert got.headed == (titles is not None)
    assert got.values.dtype == np.float64
    assert got.values.tolist() == values


def test_names_may_hold_separators_and_quotation_marks(tmp_path) -> None:
    assert read_table(written(tmp_path, '"x; y","z, ""q"""\n1,2\n')).names == ("x; y", 'z, "q"')


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "data.csv: the file is empty"),
        ("\n \n,,\n", "data.csv: the file is empty"),
        ("a,b\n", "data.csv: no row of numbers follows the header 'a,b'"),
        ("1,2\n3\n", "data.csv: 1 of 2 rows has other columns .line 2: 1 where the first row has 2.$"),
        ("a,b\n\n1,2,3\n", "data.csv: 1 of 1 rows has other columns .line 3: 3 where the header has 2.$"),
        ("1,2\n3,four\n", "data.csv: 1 of 2 rows has no number in column 2 .line 2: 'four'.$"),
        ("a,b\n1,2\n3,nan\n", "data.csv: 1 of 2 rows has no number in 'b' .line 3: 'nan' is not finite.$"),
        ("1,-inf\n", "no number in column 2 .line 1: '-inf' is not finite"),
        ("1,1e999\n", "no number in column 2 .line 1: '1e999' is not finite"),
        ("1,1_000\n", "no number in column 2 .line 1: '1_000'"),
        ("1,x\n,3\n", "2 of 2 rows have no number in column 1, column 2 .lines 1 and 2; the first: 'x'.$"),
        ("1,\n", "no number in column 2 .line 1: the field is empty"),
        ("x\n" + "y\n" * 9, "9 of 9 rows have no number in 'x' .lines 2, 3, 4, 5, 6 and 4 more; the first: 'y'.$"),
        ("x\n1 2 3\n", "line 2: '1 2 3' holds several numbers; separate the columns with commas, semicolons or tabs"),
        ("x\n" + "1 " * 300, r"line 2: '1 1 .*1 '\.\.\. \(599 characters\) holds several numbers"),
        ("x;y\n1.234,5;2\n", "line 2: '1.234,5' has marks of thousands; write it without them"),
        ("x;y\n1,5;2\n2.5;3\n", "'x' holds '1,5' and '2.5'; write all its numbers with a decimal point, or all with"),
        ("x\ty\n1,500\t2\n", "'x' holds '1,500', of which the comma may mark thousands or decimals"),
        ("x;y\n1,500;2.5\n", "'x' holds '1,500', of which the comma may mark thousands or decimals"),
        ("x;y\n1.500;2,5\n", "'x' holds '1.500', of which the point may mark thousands, as another column has"),
        ("a,,c\n1,2,3\n", "data.csv: the header leaves column 2 without a name"),
        ("a,b,a\n1,2,3\n", "data.csv: columns 1 and 3 are both called 'a'; give each a name of its own"),
        ("T [K],T [°C]\n1,2\n", "data.csv: columns 1 and 2 are both called 'T'"),
        ('a\n"2\n1\n', "data.csv, line 2: a quotation mark is not closed"),
        ('a\n"2"1\n', "data.csv, line 2: after a closing quotation mark a field must end"),
        ('a\n"' + "2\n" * 100_000, "data.csv, line 2: a field of more than 131072 characters; is a quotation mark not"),
        ("a\n" + "1" * 1_000_001, "data.csv, line 2: more than 1000000 characters, the most in a line"),
        ("1," * 10_000 + "1", "data.csv, line 1: 10001 columns; a table has at most 10000"),
        (b"a\xe9\n1\n", "data.csv: not text in UTF-8 .byte 2 is 0xe9.; save it as UTF-8, in Excel as CSV UTF-8"),
        (b"\xff\xfea", "data.csv: not text in UTF-16 .byte 3"),
        (b"1,2\n3,\x004\n", "data.csv, line 2: a zero byte"),
    ],
)
def test_refuses_and_says_where(tmp_path, text, message: str) -> None:
    with pytest.raises(DataError, match=message):
        read_table(written(tmp_path, text))


LOG = "time,T [°C],,note,p (bar),T [K]\n09:00,20.5,x,cold,1.5,293\n09:01,21,x,,,294\n\n09:02,22,y,ok,1.75,295,1\n"


def test_columns_that_are_not_used_may_hold_anything(tmp_path) -> None:
    path = written(tmp_path, LOG)
    with pytest.raises(
        BadRowsError, match=r"2 of 3 rows have no number in 'p' .lines 3 and 5; the first: the field is"
    ):
        read_table(path, ["p", "T [°C]"])
    table = read_table(path, ["p", "T [°C]"], skip_bad=True)
    assert (table.names, table.units) == (("p", "T"), ("bar", "°C"))
    assert table.values.tolist() == [[1.5, 20.5]]
    assert table.lines.tolist() == [2]
    assert table.skipped == (3, 5)
    assert table.omission == f"{path}: 2 of 3 rows were left out, lines 3 and 5"
    assert read_table(path, ["p (bar)", "6"], skip_bad=True).values.tolist() == [[1.5, 293]]
    with pytest.raises(DataError, match=r"data.csv: 2 columns are called 'T': 'T \[°C\]', 'T \[K\]'; say which by its"):
        read_table(path, ["T"])
    with pytest.raises(
        DataError, match=r"data.csv: unknown column 'tume'; did you mean 'time'\? Known: time, T \[°C\], "
    ):
        read_table(path, ["tume"])
    with pytest.raises(DataError, match=r"data\.csv: columns 2 and 6 are both called 'T'"):
        read_table(path, [1, 5])


COLOURS = 'x,colour,y\n1,red,2\n2,"dark, blue",3\n\n3,,4\n4,red\n5,green,6,7,8\n6, green ,7\n'


def test_a_column_of_texts_becomes_one_of_0_and_1_a_text() -> None:
    text = parse_table(COLOURS, "c.csv").coded("colour")
    table = text.numbers(skip_bad=True)
    assert table.names == ("x", "colour=dark, blue", "colour=green", "colour=red", "y")
    assert table.values.tolist() == [[1, 0, 0, 1, 2], [2, 1, 0, 0, 3], [6, 0, 1, 0, 7]]
    assert (table.lines.tolist(), table.skipped) == ([2, 3, 8], (5, 6, 7))
    with pytest.raises(BadRowsError, match=r"3 of 6 rows .*lines 5, 6 and 7; the first: the field is empty"):
        text.numbers()
    assert text.places("colour") == [1, 2, 3]


def test_texts_of_no_category_and_too_many_are_refused() -> None:
    other = parse_table("colour,x\npink,1\nred,2\n", "o.csv")
    with pytest.raises(DataError, match=r"^o\.csv: 'colour' holds 'pink', which is none of green, red$"):
        other.coded("colour", ["green", "red"])
    assert other.coded("colour", ["red", "pink"]).numbers().values.tolist() == [[0, 1, 1], [1, 0, 2]]
    many = parse_table("a,b\n" + "".join(f"t{k},\n" for k in range(51)), "m.csv")
    with pytest.raises(DataError, match=r"^m\.csv: 'a' has 51 different texts; a column that is coded has 1 to 50$"):
        many.coded("a")
    with pytest.raises(DataError, match=r"^m\.csv: 'b' is empty"):
        many.coded("b")


def test_rows_that_all_lack_a_number_are_refused_in_any_case(tmp_path) -> None:
    with pytest.raises(DataError, match=r"2 of 2 rows have no number in 'x' .*: none is left$"):
        read_table(written(tmp_path, "x\na\nb\n"), skip_bad=True)


@pytest.mark.parametrize(
    ("titles", "columns"),
    [
        ("x [m]|y (s)|z", [("x", "m"), ("y", "s"), ("z", "")]),
        ("x[m]|f(x)|()", [("x", "m"), ("f(x)", ""), ("()", "")]),
        ("v (left)|v (right)|v [m/s]", [("v (left)", ""), ("v (right)", ""), ("v", "m/s")]),
        ("a [b] []|w [kg (dry)]|[m]", [("a [b]", ""), ("w", "kg (dry)"), ("[m]", "")]),
        ("|x", [("column1", ""), ("x", "")]),
    ],
)
def test_titles_are_names_and_units(titles, columns) -> None:
    assert [(c.name, c.unit) for c in columns_of(titles.split("|"))] == columns


def test_a_name_finds_its_column_by_its_unit() -> None:
    columns = columns_of(["T [K]", "T [°C]", "v (left)", "v (right)"])
    assert place_of(columns, "T", "°C") == 1
    assert place_of(columns, "v", "right") == 3  # of a file in which it was the only one
    assert place_of(columns_of(["v (left)"]), "v (left)") == 0
    assert place_of(columns, "3") == 2


NAME = st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1, max_size=12).map(str.strip).filter(bool)
UNIT = st.text("abm/s²°C()·,; ", max_size=6).map(str.strip).filter(lambda u: u.count("(") == u.count(")") == 0)


@settings(max_examples=150)
@given(data=st.data())
def test_what_is_written_is_read_back(data) -> None:
    """Names of any characters, with units, quotation marks and separators."""
    pairs = data.draw(st.lists(st.tuples(NAME, UNIT), min_size=1, max_size=5, unique_by=lambda pair: pair[0]))
    names, units = zip(*pairs, strict=True)
    finite = st.floats(allow_nan=False, allow_infinity=False)
    values = np.array(data.draw(st.lists(st.tuples(*[finite] * len(names)), min_size=1, max_size=4)))
    table = parse_table(table_text(names, values, units), "t.csv").numbers()
    assert (table.names, table.units) == (names, units)
    assert np.array_equal(table.values, values)


def test_a_name_may_begin_with_a_byte_order_mark() -> None:
    assert parse_table(table_text(["\ufeffx"], np.array([[1.0]])), "t.csv").numbers().names == ("\ufeffx",)


@settings(max_examples=150)
@given(data=st.data())
def test_one_table_however_it_is_written(data) -> None:
    """Separator, decimal mark, line ends, quotation marks and encoding do not matter."""
    rows = data.draw(st.lists(st.tuples(*[st.integers(-99_999, 99_999)] * 3), min_size=1, max_size=6))
    rows = [(1, 2, 3), *rows]  # 0.01 leaves no doubt about the mark
    values = np.array(rows) / 100
    mark, end = data.draw(st.sampled_from(".,")), data.draw(st.sampled_from(["\n", "\r\n", "\r"]))
    separator = data.draw(st.sampled_from(";\t" if mark == "," else ",;\t"))
    quote, blank = data.draw(st.sampled_from(["", '"'])), data.draw(st.sampled_from(["", end]))
    encoding = data.draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]))
    fields = [["x [m]", "y (s)", "z"], *[[f"{v:.2f}".replace(".", mark) for v in row] for row in values.tolist()]]
    text = "".join(separator.join(f"{quote}{f}{quote}" for f in row) + end + blank for row in fields)
    table = parse_table(text.encode(encoding), "t.csv").numbers()
    assert (table.names, table.units) == (("x", "y", "z"), ("m", "s", ""))
    assert np.array_equal(table.values, values)
    lines = 1 + np.arange(1, len(values) + 1) * (2 if blank else 1)
    assert table.lines.tolist() == lines.tolist()


def test_a_file_that_is_not_there_and_a_folder(tmp_path) -> None:
    with pytest.raises(DataError, match=r"cannot read .*none.csv: No such file"):
        read_table(tmp_path / "none.csv")
    with pytest.raises(DataError, match=r"cannot read .*: Is a directory$"):
        read_table(tmp_path)
    (tmp_path / "plant.csv").write_text("1,2\n")
    with pytest.raises(DataError, match=r"No such file or directory; did you mean '.*plant\.csv'\?$"):
        read_table(tmp_path / "plnt.csv")
    with pytest.raises(DataError, match=r"No such file or directory$"):
        read_table(tmp_path / "plant.txt")


def test_a_written_table_reads_back_exactly(tmp_path) -> None:
    values = np.array([[0.1, 1 / 3, -1e-300], [1e300, np.pi, 5e-324]])
    names = ("a", "b, c", 'd"e')
    write_table(tmp_path / "t.csv", names, values)
    got = read_table(tmp_path / "t.csv")
    assert got.names == names
    assert np.array_equal(got.values, values)
    write_table(tmp_path / "t.csv", None, values)
    assert not read_table(tmp_path / "t.csv").headed
    assert [p.name for p in tmp_path.iterdir()] == ["t.csv"]


def test_seventeen_digits() -> None:
    assert table_text(["x"], np.array([[0.1], [2.0]])) == "x\n0.10000000000000001\n2\n"


def test_names_and_columns_must_agree() -> None:
    with pytest.raises(DataError, match="2 names for 1 columns"):
        table_text(["a", "b"], np.ones((2, 1)))
    with pytest.raises(DataError, match="2 units for 1 columns"):
        table_text(["a"], np.ones((2, 1)), ["m", "s"])


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
