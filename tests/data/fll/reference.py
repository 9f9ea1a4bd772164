"""Makes the reference outputs beside it: pyfuzzylite 8.0.6 (pip install --no-deps) evaluates our .fll texts.

``python tests/data/fll/reference.py`` from the root of the repository. pyfuzzylite asks for numpy below 2 and runs
with numpy 2; no extra of ours can ask for both.
"""

from pathlib import Path

import fuzzylite as fl
import numpy as np

import fuzzy

HERE = Path(__file__).parent
SYSTEMS = {
    "tracking": fuzzy.find_fis("tracking"),
    "supervisor": fuzzy.find_fis("supervisor"),
    **{f.stem: f for f in sorted((HERE.parent / "fis-corpus").glob("s*.fis"))},
}

for name, file in SYSTEMS.items():
    fis = fuzzy.read_fis(file)
    text = fuzzy.format_fll(fis)
    engine = fl.FllImporter().from_string(text)
    low, high = np.array([v.universe for v in fis.inputs]).T
    x = np.random.default_rng(0).uniform(low, high, (40, len(low)))
    for variable, values in zip(engine.input_variables, x.T, strict=True):
        variable.value = values
    engine.process()
    y = np.stack([np.broadcast_to(o.value, 40) for o in engine.output_variables], axis=1)
    (HERE / f"{name}.fll").write_text(text, encoding="utf-8")
    np.savetxt(HERE / f"{name}.csv", np.hstack([x, y]), fmt="%.17g", delimiter=",")
