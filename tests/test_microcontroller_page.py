"""The page docs/howto/rules-on-a-microcontroller.md: its snippets run; its loop and its two projects compile."""

import shutil
import subprocess
from pathlib import Path

from fuzzy import read_fis, write_c
from fuzzy.plugins.ccode.compiler import STRICT, find_compiler
from tests.fuzzy.plugins.ccode.inc import needs_compiler
from tests.snippets import run_commands, run_python, snippets

PAGE = Path(__file__).parent.parent / "docs" / "howto" / "rules-on-a-microcontroller.md"
STUBS = Path(__file__).parent / "data" / "firmware"
PLANT = "double reference(void);\ndouble measured(void);\nvoid drive(double force);\nvoid every_10_ms(void);\n"


@needs_compiler
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    kinds = []
    for kind, text in snippets(PAGE, changed=False):
        kinds.append(kind)
        if kind == "sh":
            run_commands(text)
            assert "the same within 4e-15" in capsys.readouterr().out
        elif kind == "python":
            run_python(text, PAGE.name)
        elif kind == "cpp":
            if any(map(shutil.which, ("c++", "g++", "clang++"))):
                _compiled(text, "sketch.cpp", "q16.16", tmp_path, ("-x", "c++", "-std=c++11"))
        elif "TIM6" in text:
            _compiled(text, "callback.c", "float", tmp_path, STRICT)
        else:
            (tmp_path / "loop.c").write_text(PLANT + text, encoding="utf-8")
            _compile([*STRICT, "-Ifirmware", "-c", "loop.c", "-o", "loop.o"])
    assert kinds == ["sh", "c", "cpp", "c", "python"]
    assert "int32_t" in (tmp_path / "firmware" / "fuzzy_pd.c").read_text(encoding="utf-8")


def _compiled(text, file, number, folder, flags):
    """Compile a project of the page against stand-ins for the board's library."""
    write_c(read_fis(folder / "pd.fis"), folder / number, number, name="fuzzy_pd")
    (folder / file).write_text(text, encoding="utf-8")
    _compile([*flags, "-Wall", "-Wextra", "-Werror", f"-I{number}", f"-I{STUBS}", "-c", file, "-o", f"{file}.o"])


def _compile(arguments):
    done = subprocess.run([*find_compiler().command, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
