"""The page docs/microcontroller.md: its snippets run as written, and its loop compiles."""

import subprocess
from pathlib import Path

from fuzzy.ccode.compiler import STRICT, find_compiler
from tests.fuzzy.ccode.inc import needs_compiler
from tests.snippets import run_commands, run_python, snippets

PAGE = Path(__file__).parent.parent / "docs" / "microcontroller.md"
PLANT = "double reference(void);\ndouble measured(void);\nvoid drive(double force);\nvoid every_10_ms(void);\n"


@needs_compiler
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    kinds = []
    for kind, text in snippets(PAGE):
        kinds.append(kind)
        if kind == "sh":
            run_commands(text)
            assert "the same within 4e-15" in capsys.readouterr().out
        elif kind == "python":
            run_python(text, PAGE.name)
        else:
            (tmp_path / "loop.c").write_text(PLANT + text, encoding="utf-8")
            line = [*find_compiler().command, *STRICT, "-Ifirmware", "-c", "loop.c", "-o", "loop.o"]
            done = subprocess.run(line, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
    assert kinds == ["sh", "c", "python"]
    assert "int32_t" in (tmp_path / "firmware" / "fuzzy_pd.c").read_text(encoding="utf-8")
