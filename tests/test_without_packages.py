"""Without large packages only what needs them is refused, in one sentence that names them."""

import json
import subprocess
import sys

import pytest

# Sees to it that packages cannot be imported: what is blocked, and then a program's text, on the command line.
BLOCKED = """
import sys

class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in sys.argv[1].split(","):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocker())
import contextlib, io, json
import numpy as np
import anfis, fuzzy
from anfis.commands.application import main

x = np.random.default_rng(0).uniform(-1, 1, (60, 2))
y = x[:, 0] * x[:, 1]
start = fuzzy.identify(x, y, method="grid", mfs=2)
results = {}

def learn(**options):
    return float(anfis.train(start, x, y, anfis.Options(epochs=2, **options)).rmse)

def note(name, function):
    try:
        results[name] = function()
    except fuzzy.InputError as error:
        results[name] = str(error)
"""
TORCH = """
note("hybrid", lambda: learn(method="hybrid"))
note("second-order", lambda: learn(method="second-order"))
note("keep order", lambda: learn(keep_order=True))
note("backprop", lambda: learn(method="backprop"))
note("float32", lambda: learn(dtype="float32"))
note("optimiser", lambda: learn(method="backprop", optimiser="SGD"))
note("device", lambda: learn(device="cuda"))
note("checkpoint", lambda: anfis.train(start, x, y, anfis.Options(epochs=1), checkpoint="run.checkpoint"))
fuzzy.write_fis(start, "start.fis")
np.savetxt("xy.csv", np.column_stack([x, y]), delimiter=",", header="in1,in2,out1", comments="")
for name, rest in {"command": [], "command backprop": ["--method", "backprop"]}.items():
    with contextlib.redirect_stderr(io.StringIO()) as said, contextlib.redirect_stdout(io.StringIO()):
        code = main(["train", "xy.csv", "--start", "start.fis", "--epochs", "1", "-o", "net.fis", "-q", *rest])
    results[name] = [code, said.getvalue()]
"""
SCIKIT_FUZZY = """
note("subtractive", lambda: len(fuzzy.identify(x, y, method="subtractive").rules) > 1)
note("fcm", lambda: fuzzy.identify(x, y, method="fcm", clusters=3))
note("from_skfuzzy", lambda: fuzzy.from_skfuzzy(None))
"""


def results(blocked, text, folder):
    """What the program noted while ``blocked`` packages could not be imported."""
    code = f"{BLOCKED}\n{text}\nprint(json.dumps(results))"
    done = subprocess.run(
        [sys.executable, "-c", code, blocked], cwd=folder, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_without_torch(tmp_path):
    found = results("torch", TORCH, tmp_path)
    for name in ("hybrid", "second-order", "keep order"):
        assert 0 < found[name] < 0.2, name
    what = "learning by back-propagation, in float32, on another device or of functions of one's own"
    sentence = f"{what} needs torch: pip install torch"
    assert found["backprop"] == found["float32"] == sentence
    assert found["optimiser"] == "the optimiser 'SGD' needs torch: pip install torch"
    assert found["device"] == "the device 'cuda' needs torch: pip install torch"
    assert found["checkpoint"] == "a checkpoint needs torch: pip install torch"
    assert found["command"] == [0, ""]
    assert found["command backprop"] == [2, f"anfis: {sentence}\n"]


def test_without_scikit_fuzzy(tmp_path):
    found = results("skfuzzy,networkx", SCIKIT_FUZZY, tmp_path)
    assert found == {
        "subtractive": True,
        "fcm": "fuzzy c-means needs scikit-fuzzy: pip install scikit-fuzzy",
        "from_skfuzzy": "from_skfuzzy needs scikit-fuzzy: pip install scikit-fuzzy",
    }


def test_a_package_that_fails_for_another_reason_is_no_missing_one(tmp_path, monkeypatch):
    from fuzzy.extras import needed

    (tmp_path / "halfthere.py").write_text("import no_such_package\n", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="No module named 'no_such_package'") as caught:
        needed("halfthere", "this")
    assert not isinstance(caught.value, ValueError)
