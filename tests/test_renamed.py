"""Earlier names of modules: the same module, and a warning that says what it is called now."""

import subprocess
import sys
from importlib import import_module

import pytest

import fuzzy
from fuzzy.renamed import name_now

EARLIER = {
    "fuzzy.ccode.source": "fuzzy.plugins.ccode.source",
    "fuzzy.designer.panel": "fuzzy.plugins.designer.panel",
    "fuzzy.designer.steppanel": "fuzzy.plugins.loop.panel",
    "fuzzy.figures.step": "fuzzy.plugins.loop.stepfigure",
    "fuzzy.files.fllfile": "fuzzy.plugins.mamdani.fllfile",
    "fuzzy.loop": "fuzzy.plugins.loop",
    "fuzzy.loop.plant": "fuzzy.plugins.loop.plant",
    "fuzzy.mamdani.likeness": "fuzzy.plugins.mamdani.likeness",
    "fuzzy.starts.start": "fuzzy.plugins.designer.starts.start",
}


@pytest.mark.parametrize("earlier", EARLIER)
def test_an_earlier_name_is_the_same_module(earlier, monkeypatch):
    parts = earlier.split(".")
    for end in range(2, len(parts) + 1):
        if name_now(".".join(parts[:end])):
            monkeypatch.delitem(sys.modules, ".".join(parts[:end]), raising=False)
    now = import_module(EARLIER[earlier])
    with pytest.warns(DeprecationWarning, match="is now called") as said:
        assert import_module(earlier) is now
    assert str(said[-1].message) == f"{earlier} is now called {EARLIER[earlier]}; the old name goes in the next release"
    assert (now.__name__, now.__spec__.name) == (EARLIER[earlier], EARLIER[earlier])


def test_each_way_of_importing_and_who_is_warned():
    code = (
        "import fuzzy, pickle, warnings\n"
        "warnings.simplefilter('error', DeprecationWarning)\n"
        "try:\n    import fuzzy.loop.plant\nexcept DeprecationWarning as error:\n    print('refused', error)\n"
        "warnings.simplefilter('default', DeprecationWarning)\n"
        "from fuzzy.loop.plant import TransferFunction\n"
        "import fuzzy.loop.plant as plant\n"
        "assert plant.TransferFunction is fuzzy.loop.plant.TransferFunction is fuzzy.TransferFunction\n"
        "assert pickle.loads(b'cfuzzy.mamdani.system\\nMamdani\\n.') is fuzzy.Mamdani\n"
        "assert fuzzy.ccode.__name__ == 'fuzzy.plugins.ccode'\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("refused fuzzy.loop is now called fuzzy.plugins.loop;")
    assert "<string>:8: DeprecationWarning: fuzzy.loop.plant is now called fuzzy.plugins.loop.plant" in done.stderr


def test_what_never_was_is_no_name():
    assert name_now("fuzzy.looping") is None
    assert name_now("fuzzy") is None
    with pytest.raises(ModuleNotFoundError, match=r"No module named 'fuzzy\.plugins\.loop\.nothing'"):
        import_module("fuzzy.plugins.loop.nothing")
    with pytest.raises(AttributeError, match="has no attribute 'looping'"):
        getattr(fuzzy, "".join(("loop", "ing")))
