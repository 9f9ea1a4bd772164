"""The plugin of `make check-all`: flaky browser tests are named, others still fail, and reasons of skips are told."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.again import told

ROOT = Path(__file__).parent.parent
CONFTEST = """
import pytest
@pytest.fixture
def browser():
    return None
def pytest_collection_modifyitems(items):
    for item in items:
        if "browser" in item.fixturenames:
            item.add_marker("browser")
"""
FLAKY = """
from pathlib import Path
def test_at_the_second_time(browser):
    there, at = Path("there").exists(), Path("there").touch()
    assert there
"""
BROKEN = "def test_never(browser):\n    assert False\n"
PLAIN = "def test_without_a_browser():\n    assert False\n"
ASTRAY = "import nowhere\n"
SKIPPED = "import pytest\ndef test_left_out():\n    pytest.importorskip('nowhere', reason='needs nowhere')\n"


@pytest.mark.long
@pytest.mark.parametrize(
    ("texts", "passes", "flaky"),
    [
        ((FLAKY, SKIPPED), True, "test_it_0.py::test_at_the_second_time"),
        ((SKIPPED,), True, "none"),
        ((FLAKY, BROKEN), False, "test_it_0.py::test_at_the_second_time"),
        ((PLAIN,), False, "none"),
        ((ASTRAY,), False, "none"),
    ],
    ids=["flaky", "nothing", "broken", "no browser", "no file"],
)
def test_a_browser_test_that_passes_by_itself_is_named(tmp_path, texts, passes, flaky):
    (tmp_path / "conftest.py").write_text(CONFTEST, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = browser\n", encoding="utf-8")
    for k, text in enumerate(texts):
        (tmp_path / f"test_it_{k}.py").write_text(text, encoding="utf-8")
    options = ["-q", "-p", "tests.again", "-p", "no:cacheprovider", "-o", f"pythonpath={ROOT}", "--notes", "notes"]
    run = [
        sys.executable,
        "-c",
        f"import sys; sys.path.insert(0, {str(ROOT)!r}); import pytest; sys.exit(pytest.main())",
    ]
    done = subprocess.run([*run, *options], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode == 0) == passes, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    *skipped, last = told((tmp_path / "notes").read_text(encoding="utf-8").splitlines()).splitlines()
    assert last == f"flaky tests: {flaky}"
    assert skipped == (["skipped: 1 × needs nowhere"] if SKIPPED in texts else ["skipped tests: none"])
