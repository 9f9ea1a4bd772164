"""All pictures of a system: their names, their number by closed form, and that each can be read."""

import io
import re
import zipfile
from itertools import combinations
from math import comb
from xml.etree import ElementTree

import pytest

import fuzzy
from fuzzy.figures import figureset
from fuzzy.figures.figureset import pictures_of, readme, write_figures
from fuzzy.files.atomic import TargetError


def system(inputs: int = 2, outputs: int = 1, rules: int = 2) -> fuzzy.Sugeno:
    names = ["distance to the wall", "bearing/rad", "c", "d", "e", "f", "g"][:inputs]
    xs = [
        fuzzy.Variable(n, (0, 2), {"near": fuzzy.trimf(0, 0, 1), "far": fuzzy.trapmf(0.5, 1, 2, 2)}, "m") for n in names
    ]
    ys = [fuzzy.Variable(f"v{j}", (0, 1), {"slow": 0.1, "fast": 0.9}, "m/s") for j in range(outputs)]
    fis = fuzzy.Sugeno(xs, ys, name="wall")
    when = fuzzy.Clause(names[0], "near")
    rule = fuzzy.Rule((when,), tuple((v.name, "slow") for v in ys))
    return fuzzy.Sugeno(fis.inputs, fis.outputs, [rule] * rules, name="wall")


def expected(inputs: int, outputs: int, rules: int) -> int:
    """Terms and consequents, the viewer, the structure, and each output over each pair of inputs, or the only one."""
    surfaces = outputs * (1 if inputs == 1 else comb(inputs, 2))
    return inputs + outputs + (rules > 0) + (0 < rules <= 60) + min(60, surfaces)


@pytest.mark.parametrize("inputs", [1, 2, 3, 7])
@pytest.mark.parametrize(("outputs", "rules"), [(1, 0), (2, 1), (3, 61), (1, 60)])
def test_the_number_of_pictures_and_what_is_left_out(inputs, outputs, rules):
    fis = system(inputs, outputs, rules)
    point = [1.0] * inputs
    pictures = pictures_of(fis, point)
    assert len(pictures) == expected(inputs, outputs, rules)
    stems = [picture.stem for picture in pictures]
    assert len({stem.casefold() for stem in stems}) == len(stems)
    assert stems == sorted(stems)
    assert all(re.fullmatch(r"\d\d-[\w.-]+", stem) for stem in stems)
    shown = {(p.inputs, p.output) for p in pictures if p.kind == "surface"}
    axes = [(0,)] if inputs == 1 else list(combinations(range(inputs), 2))
    every = {(pair, j) for pair in axes for j in range(outputs)}
    assert shown <= every
    assert shown == every or len(shown) == 60
    text = readme(fis, pictures, point, "pdf")
    assert all(f"{picture.stem}.pdf\n    {picture.caption}\n" in text for picture in pictures)
    assert (f"Left out: {len(every) - 60} of {len(every)} surfaces" in text) == (len(every) > 60)
    assert ("Left out: the structure" in text) == (rules > 60)
    assert len(re.findall(r"^ +\d+\. if ", text, re.M)) == rules


AT = {"distance to the wall": 0.25}


def test_a_zip_of_pdf(tmp_path):
    told = []
    names = write_figures(system(1, 1, 0), tmp_path / "a.zip", AT, advance=lambda *done: told.append(done))
    count = expected(1, 1, 0)
    stems = ["01-terms-distance-to-the-wall", "02-consequents-v0", "03-surface-v0-over-distance-to-the-wall"]
    assert names == ["README.txt", *(f"{stem}.pdf" for stem in stems)]
    assert told == [(k, count) for k in range(1, count + 1)]
    with zipfile.ZipFile(tmp_path / "a.zip") as archive:
        assert archive.testzip() is None
        assert archive.namelist() == names
        for name in names[1:]:
            data = archive.read(name)
            assert data.startswith(b"%PDF-1.")
            assert data.rstrip().endswith(b"%%EOF")
            table = int(re.search(rb"startxref\s+(\d+)\s+%%EOF", data)[1])  # where the reader of a PDF begins
            assert data[table:].startswith(b"xref")
            assert len(re.findall(rb"/Type /Page\b", data)) == 1


def test_a_folder_of_svg_and_the_same_one_by_one(tmp_path):
    fis, folder = system(), tmp_path / "set"
    names = write_figures(fis, folder, AT, "svg")
    assert names == [
        "README.txt",
        "01-terms-distance-to-the-wall.svg",
        "02-terms-bearing-rad.svg",
        "03-consequents-v0.svg",
        "04-rules-at-the-point.svg",
        "05-structure.svg",
        "06-surface-v0-over-distance-to-the-wall-bearing-rad.svg",
    ]
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    for name in names[1:]:
        root = ElementTree.parse(folder / name).getroot()
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        assert len(list(root.iter("{http://www.w3.org/2000/svg}path"))) > 5
    text = (folder / "README.txt").read_text()
    assert "The point: distance to the wall = 0.25 m, bearing/rad = 1 m." in text
    assert "Control surface: v0 [m/s] over distance to the wall [m] and bearing/rad [m].\n" in text
    # The same system gives the same bytes, also where a worker draws them one by one.
    pictures = pictures_of(fis, (0.25, 1.0))
    drawn = [(folder / name).read_bytes() for name in names[1:]]
    for k in (0, -1):
        assert figureset.picture_bytes(fis, pictures[k], (0.25, 1.0), "svg") == drawn[k]
    packed = figureset.packed_pictures(fis, pictures, (0.25, 1.0), "svg", drawn)
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert archive.namelist() == names
        assert archive.read("README.txt") == text.encode()


def test_what_is_refused(tmp_path):
    fis = system()
    with pytest.raises(fuzzy.InputError, match="did you mean 'pdf'"):
        write_figures(fis, tmp_path / "a.zip", ending="pfd")
    with pytest.raises(fuzzy.InputError, match=r"a \.zip file or a folder, not into '.*a\.pdf'"):
        write_figures(fis, tmp_path / "a.pdf")
    with pytest.raises(fuzzy.InputError, match="input"):
        write_figures(fis, tmp_path / "a.zip", {"distanc": 1})
    with pytest.raises(TargetError, match="no folder"):
        write_figures(fis, tmp_path / "none" / "a.zip")
    (tmp_path / "file").write_text("")
    with pytest.raises(TargetError, match="is a file, not a folder"):
        write_figures(fis, tmp_path / "file")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file"]
