"""The page docs/howto/laws-on-a-robot.md: its commands and its Python run as written."""

import re
import subprocess
from pathlib import Path

import pytest

from fuzzy.plugins.ccode.compiler import STRICT, CompilerError, find_compiler
from robotics import load_scenario, write_c_law
from tests.snippets import run_commands, run_python, snippets

DOCS = Path(__file__).parent.parent / "docs"
ROBOT = (
    "unsigned long odometry_count(void);\n"
    "double odometry_x(void);\ndouble odometry_y(void);\ndouble odometry_heading(void);\nvoid stop(void);\n"
    "void set_wheel_speeds(double right, double left);\nvoid start(void);\nvoid every_period(void);\n"
)


def test_every_snippet_of_the_page_runs(tmp_path, monkeypatch, capsys):
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))
    monkeypatch.chdir(tmp_path)
    kinds = []
    for kind, text in snippets(DOCS / "howto" / "laws-on-a-robot.md", changed=False):
        kinds.append(kind)
        if kind == "sh":
            run_commands(text)
        elif kind == "python":
            run_python(text, "laws-on-a-robot.md")
        else:
            (tmp_path / "task.c").write_text(ROBOT + text, encoding="utf-8")
            line = [*find_compiler().command, *STRICT, "-Iout", "-c", "task.c", "-o", "task.o"]
            done = subprocess.run(line, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
    assert kinds == ["sh", "python", "c", "sh", "sh", "c", "sh"]
    said = capsys.readouterr().out
    assert "0e+00 m apart: the same" in said.splitlines()
    assert "no sensor looks at" in said
    assert (tmp_path / "out" / "fuzzy_rules.c").stat().st_size > 1000


def test_the_states_hold_what_the_page_says(tmp_path):
    page = (DOCS / "howto" / "laws-on-a-robot.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`[^|]+) \| (\d+) \| ([^|]+) \|$", page, re.MULTILINE)
    assert len(rows) == 3
    for laws, size, said in rows:
        for law in re.findall(r"`(\w+)`", laws):
            write_c_law(law, load_scenario("table-2-1"), tmp_path, number="float")
            header = (tmp_path / f"{law}.h").read_text(encoding="utf-8")
            state = header.partition(f"}} {law}_state;")[0].rpartition("typedef struct {")[2]
            fields = re.findall(r"^    (?:float|int) (\w+);", state, re.MULTILINE)
            assert 4 * len(fields) == int(size), law
            assert set(re.findall(r"`(\w+)`", said)) - {"int"} <= set(fields)
