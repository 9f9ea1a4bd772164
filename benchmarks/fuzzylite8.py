"""pyfuzzylite 8 in a Python of its own, because it needs numpy 1: the other end of a pipe.

Started by :mod:`benchmarks.inferencepeers` as ``python fuzzylite8.py SYSTEM.npz``. It answers each line of its standard
input, ``one COUNT``, ``many`` or ``check``, by a line of JSON: seconds, or the outputs at the first points. It imports
nothing of this package.
"""

import json
import sys
import time
from typing import Any

import numpy as np


def engine(center: np.ndarray, sigma: np.ndarray, consequent: np.ndarray) -> Any:
    """The Takagi-Sugeno system of Gaussians ``center`` and ``sigma`` (rules, inputs)."""
    import fuzzylite as fl

    rules, inputs = center.shape
    variables = [
        fl.InputVariable(
            f"x{i}",
            minimum=-1,
            maximum=1,
            terms=[fl.Gaussian(f"t{r}", center[r, i], sigma[r, i]) for r in range(rules)],
        )
        for i in range(inputs)
    ]
    output = fl.OutputVariable("y", minimum=-10, maximum=10, defuzzifier=fl.WeightedAverage("TakagiSugeno"))
    made = fl.Engine("bench", input_variables=variables, output_variables=[output])
    output.terms = [fl.Linear(f"f{r}", consequent[r].tolist(), made) for r in range(rules)]
    texts = ["if " + " and ".join(f"x{i} is t{r}" for i in range(inputs)) + f" then y is f{r}" for r in range(rules)]
    product = fl.AlgebraicProduct()
    block = fl.RuleBlock(
        conjunction=product,
        implication=product,
        activation=fl.General(),
        rules=[fl.Rule.create(text, made) for text in texts],
    )
    made.rule_blocks = [block]
    return made


def main() -> None:
    import fuzzylite as fl

    fl.settings.atol = fl.settings.rtol = 0.0  # by default it drops rules that fire weakly
    data = np.load(sys.argv[1])
    made, x = engine(data["center"], data["sigma"], data["consequent"]), data["x"]
    point = x[0].tolist()

    def evaluate(values: Any) -> np.ndarray:
        for variable, value in zip(made.input_variables, values, strict=True):
            variable.value = value
        made.process()
        return np.ravel(made.output_variables[0].value)

    for line in sys.stdin:
        command, *number = line.split()
        start = time.perf_counter()
        if command == "one":
            for _ in range(int(number[0])):
                evaluate(point)
            answer = time.perf_counter() - start
        elif command == "many":
            evaluate(x.T)
            answer = time.perf_counter() - start
        else:
            answer = evaluate(x[:1000].T).tolist() + evaluate(point).tolist()
        print(json.dumps(answer), flush=True)


if __name__ == "__main__":
    main()
