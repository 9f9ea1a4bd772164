"""A plugin of pytest for `make check-all`: browser tests that fail are run once more, each by itself.

`-p tests.again --notes FILE` appends a line for each reason for which tests were skipped, and for each flaky test: one
that failed, and passed by itself. `python -m tests.again FILE` prints all lines.
"""

import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

SKIPPED, FLAKY = "skipped", "flaky"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--notes", type=Path, help="the file to which skipped and flaky tests are appended")


def _run_alone(config: pytest.Config, test: str) -> bool:
    """Run a test by itself; return whether it passes."""
    options = ["-n", "0", "-m", "", "-p", "no:cacheprovider", "--rootdir", str(config.rootpath)]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, test], cwd=config.invocation_params.dir, check=False
    )
    return done.returncode == 0


@pytest.hookimpl(wrapper=True)
def pytest_sessionfinish(session: pytest.Session) -> Any:
    """Run each browser test that failed once more; a run in which all others passed has passed."""
    yield
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    notes = session.config.getoption("notes")
    if notes is None or reporter is None or hasattr(session.config, "workerinput"):
        return
    stats = reporter.stats
    failed = [*stats.get("failed", ()), *stats.get("error", ())]
    # A file that cannot be imported has no keywords.
    browsers = {report.nodeid: "browser" in getattr(report, "keywords", ()) for report in failed}
    flaky = {test for test, drives in browsers.items() if drives and _run_alone(session.config, test)}
    if session.exitstatus == pytest.ExitCode.TESTS_FAILED and flaky == set(browsers):
        session.exitstatus = pytest.ExitCode.OK
    reasons = Counter(str(report.longrepr[2]).removeprefix("Skipped: ") for report in stats.get("skipped", ()))
    with notes.open("a", encoding="utf-8") as file:
        for reason, count in sorted(reasons.items()):
            print(f"{SKIPPED}: {count} × {reason}", file=file)
        for test in sorted(flaky):
            print(f"{FLAKY}: {test}", file=file)


def told(lines: Iterable[str]) -> str:
    """Put the notes in order: the reasons for which tests were skipped, then the flaky tests."""
    lines = list(dict.fromkeys(lines))
    skipped = [line for line in lines if line.startswith(SKIPPED)]
    flaky = [line.removeprefix(f"{FLAKY}: ") for line in lines if line.startswith(FLAKY)]
    return "\n".join([*(skipped or ["skipped tests: none"]), f"flaky tests: {', '.join(flaky) or 'none'}"])


if __name__ == "__main__":
    print(told(Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()))
