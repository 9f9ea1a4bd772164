"""What tests share: results that are dear, made once a run, and packages that are installed beside this one.

Three workers share two cores, since one of them often waits for a browser or a process: threads of their own in every
linear algebra call would only wait for each other. A worker that has nothing left to do takes half of what another has
before it, so no list says which files take long.
"""

import fcntl
import gc
import os
import pickle
import signal
import tomllib
from collections.abc import Callable, Iterator
from functools import lru_cache
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before anything imports numpy or torch; commands that are started inherit it

os.environ.setdefault("FUZZYFLEET_CACHE", "")  # what is listed is found anew

# A busy machine is no fault of the code.
settings.register_profile("without a clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("without a clock")

# While tests are collected, nothing becomes garbage, and looking for it took a quarter of the time.
gc.disable()

# A shell ignores Ctrl-C for what it starts in the background; the tests of interruptions send it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that drive a browser, by the fixture that each of them uses; the longest test comes first."""
    items.sort(key=lambda item: item.path.name != "test_readme.py")
    for item in items:
        if "browser" in getattr(item, "fixturenames", ()):
            item.add_marker("browser")


def pytest_collection_finish() -> None:
    """Look for garbage seldom, and not in what has been imported, which stays: it took a tenth of the time."""
    gc.freeze()
    gc.set_threshold(200_000)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def coarse_pictures() -> Iterator[None]:
    """Pictures of reports with few dots: they are drawn as ever, and packed in a fraction of the time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robotics.show.report.plates.DPI", 40)
        yield


@pytest.fixture(scope="session", autouse=True)
def paths_once() -> Iterator[None]:
    """A table for each shape of a path: most scenarios of the tests drive along the same few. (-0.0 equals 0.0.)"""
    from robotics.world.paths import path

    tabulated = path._tabulated
    kept = lru_cache(maxsize=256)(lambda shape, words, spacing: tabulated(shape, spacing))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(path, "_tabulated", lambda shape, spacing: kept(shape, repr(shape), spacing))
        yield


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[], Any]], Any]:
    """A function ``once(name, make)``: what ``make`` returns, made by one worker of this run and read by the others."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # that of the whole run

    def made(name: str, make: Callable[[], Any]) -> Any:
        file = folder / f"{name}.pickle"
        with (folder / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not file.exists():
                content = pickle.dumps(make())
                file.with_suffix(".part").write_bytes(content)
                file.with_suffix(".part").rename(file)
        return pickle.loads(file.read_bytes())

    return made


@pytest.fixture
def site(tmp_path_factory, monkeypatch):
    """A folder of installed packages that is searched first; in it fuzzyfleet, as this tree's pyproject.toml has it."""
    folder = tmp_path_factory.mktemp("site")
    project = tomllib.loads((Path(__file__).parent.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declare(folder, project["name"], project["entry-points"])
    monkeypatch.syspath_prepend(folder)
    return folder


def module_in(file: Path) -> Any:
    """The module in a file that stands in no package."""
    spec = spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def declare(site, name, groups, requires=()):
    """Write the metadata of an installed package ``name`` into ``site``.

    It has entry points, by group and by name, and requires other packages.
    """
    about = site / f"{name.replace('-', '_')}-1.0.dist-info"
    about.mkdir()
    needs = "".join(f"Requires-Dist: {other}\n" for other in requires)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n{needs}", encoding="utf-8")
    lines = [
        line for group, points in groups.items() for line in (f"[{group}]", *(f"{k} = {v}" for k, v in points.items()))
    ]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
