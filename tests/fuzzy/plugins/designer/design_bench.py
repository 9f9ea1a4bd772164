"""A page with one of the designer's modules and a design behind it, which the module's messages change."""

import itertools
from typing import Any

import fuzzy
from fuzzy.errors import InputError
from fuzzy.plugins.designer.design import design_of
from fuzzy.plugins.designer.edits import apply
from fuzzy.plugins.designer.views import (
    design_data,
    findings_data,
    functions_data,
    refusal_data,
    surface_data,
    viewer_data,
)
from tests.browsers import rest
from tests.fuzzy.plugins.designer.module_page import ModulePage

STATIC = "fuzzy/plugins/designer/static"


def system() -> fuzzy.Sugeno:
    d = {"near": fuzzy.Triangle(0.0, 0.5, 1.2), "far": fuzzy.Gaussian(0.5, 2.0)}
    a = {"left": fuzzy.ZShape(-2.0, 1.0), "right": fuzzy.SShape(-1.0, 2.0)}
    v = {"slow": 0.2, "fast": 0.9, "mixed": fuzzy.Linear((0.1, 0.2), 0.3)}
    rules = [
        "if d is near then v is slow",
        "if d is far and a is not very left then v is fast",
        "if a is right then v is mixed with 0.5",
    ]
    inputs = [fuzzy.Variable("d", (0.0, 2.0), d, "m"), fuzzy.Variable("a", (-3.0, 3.0), a)]
    return fuzzy.Sugeno(inputs, [fuzzy.Variable("v", (0.0, 1.0), v, "m/s")], rules, name="small")


class Bench(ModulePage):
    """A page with one module and a design behind it, changed by what the module sends."""

    def __init__(self, page: Any) -> None:
        page.expose_function("python", self._answer)
        self.numbers = itertools.count(1)
        super().__init__(page, sheet=f"{STATIC}/designer.css")

    def show(self, module: str, fis: fuzzy.Sugeno | None = None, width: int = 900, **traits: Any) -> None:
        self.design = design_of(fis or system())
        self.look: dict[str, Any] = {"inputs": list(range(min(2, len(self.design.system.inputs)))), "output": 0}
        self.selected: dict[str, Any] = {}
        self.checks = module == "check"
        self.problem: dict[str, Any] | None = None
        self.render(f"{STATIC}/{module}.js", {**self.traits(), **traits}, width)

    def traits(self) -> dict[str, Any]:
        return {
            "design": design_data(self.design),
            "functions": functions_data(),
            "point": list(self.design.point),
            "viewer": viewer_data(self.design),
            "surface": surface_data(self.design, self.look["inputs"], self.look["output"]),
            "selected": self.selected,
            "problem": self.problem,
            "compared": None,
            "findings": findings_data(self.design) if self.checks else None,
        }

    def _answer(self, message: dict[str, Any]) -> dict[str, Any]:
        try:
            self.problem = None
            if message.get("look") == "surface":
                self.look = message
            elif message.get("look") == "select":
                self.selected = message
            else:
                self.design = apply(self.design, message)
        except InputError as error:
            self.problem = refusal_data(error, message, next(self.numbers))
        traits = self.traits()
        del traits["compared"]
        return traits

    def settled(self) -> None:
        rest(self.page)

    def parameters(self, term: str) -> list[float]:
        return [
            float(p) for v in self.design.system.inputs for n, t in v.terms.items() if n == term for p in t.parameters
        ]

    def curve(self, term: str) -> str:
        d: str = self.page.locator(f"[data-curve='{term}']").get_attribute("d")
        return d

    def texts(self) -> list[str]:
        return [line.text for line in self.design.lines]
