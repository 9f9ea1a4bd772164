"""A figure at the end of a notebook's cell is a picture, without pyplot; a chosen format stays."""

import subprocess
import sys

import pytest

pytest.importorskip("IPython")

START = "from IPython.core.interactiveshell import InteractiveShell\nshell = InteractiveShell.instance()\n"
SHOWN = """
from matplotlib.figure import Figure
figure = Figure()
figure.subplots()
shown, _ = shell.display_formatter.format(figure)
print(sorted(set(shown) - {"text/plain"}), shown.get("image/png", b"")[1:4])
"""


def said(program, tmp_path):
    env = {"IPYTHONDIR": str(tmp_path), "HOME": str(tmp_path), "PATH": ""}
    run = [sys.executable, "-c", START + program + SHOWN]
    done = subprocess.run(run, env=env, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout.strip()


@pytest.mark.parametrize(
    ("program", "expected"),
    [
        ("", "[] b''"),
        ("import fuzzy", "['image/png'] b'PNG'"),
        ("import robotics", "['image/png'] b'PNG'"),
        (
            "from matplotlib.figure import Figure\n"
            "shell.display_formatter.formatters['image/svg+xml'].for_type(Figure, lambda f: '<svg/>')\nimport fuzzy",
            "['image/svg+xml'] b''",
        ),
    ],
    ids=["without us", "fuzzy", "robotics", "chosen"],
)
def test_a_figure_is_a_picture(program, expected, tmp_path):
    assert said(program, tmp_path) == expected
