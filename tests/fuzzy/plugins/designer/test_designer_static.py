"""The browser's modules as texts: what they must not contain, and how notebooks get them as one."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import fuzzy
from fuzzy.esmodule import ModuleError, composed

ROOT = Path(fuzzy.__file__).parent.parent
MODULES = sorted(path for package in ("anfis", "fuzzy", "robotics") for path in (ROOT / package).rglob("*.js"))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.name)
def test_modules_need_nothing_but_each_other(path: Path) -> None:
    assert path.parent.name == "static"
    text = path.read_text(encoding="utf-8")
    assert "innerHTML" not in text  # names come from files
    for source in re.findall(r"""\bfrom "([^"]+)";$|\bimport\("([^"]+)"\)""", text, re.MULTILINE):
        name = "".join(source)
        assert name.startswith("."), name
        assert (path.parent / name).is_file(), name
    assert not re.findall(r"(?:https?:)?//(?!www\.w3\.org/2000/svg)\w+\.\w+", text)


def test_composed_modules(tmp_path):
    (tmp_path / "a.js").write_text(
        'import { one as first,\n  two } from "./b/b.js";\nimport thing from "./c.js";\n'
        "export const three = first + two();\nexport default { sum: three + thing };\n"
    )
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "b.js").write_text(
        'import { deep } from "../c.js";\nconst hidden = 1;\nexport { hidden as one };\n'
        "export async function later() {}\nexport function two() { return deep; }\n"
    )
    (tmp_path / "c.js").write_text("export const deep = 20;\nconst value = 300;\nexport default value;\n")
    text = composed(tmp_path / "a.js")
    assert text.count("deep = 20") == 1
    assert not re.search(r"^import", text, re.M)
    assert text.index("c.js") < text.index("b.js") < text.index("a.js")
    (tmp_path / "composed.mjs").write_text(
        text.replace("export default", "const result =") + "console.log(result.sum);"
    )
    node = shutil.which("node")
    if node is not None:
        said = subprocess.run([node, tmp_path / "composed.mjs"], capture_output=True, text=True)
        assert said.stdout == "321\n", said.stderr
    for wrong in (
        'import * as all from "./c.js";',
        'export * from "./c.js";',
        'import "./c.js";',
        'const c = await import("./c.js");',
        'import { a } from "three";',
        'import { a } from "./missing.js";',
        'import { a } from "./wrong.js";',
    ):
        (tmp_path / "wrong.js").write_text(f"{wrong}\nexport default 1;\n")
        with pytest.raises(ModuleError, match=r"\.js"):
            composed(tmp_path / "wrong.js")
