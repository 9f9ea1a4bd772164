"""Rule bases made by hand, as the text of a .fis file, and scenarios for them."""

from collections.abc import Mapping
from pathlib import Path

HEAD = """[System]
Name='handmade'
Type='sugeno'
Version=2.0
NumInputs={inputs}
NumOutputs={outputs}
NumRules={rules}
AndMethod='prod'
OrMethod='probor'
ImpMethod='prod'
AggMethod='sum'
DefuzzMethod='wtaver'
"""


def linear_base(
    path: Path, inputs: Mapping[str, tuple[float, float]], outputs: Mapping[str, list[float]], rules: int = 1
) -> Path:
    """Write a rule base whose outputs are linear in its inputs to ``path``.

    ``inputs`` have their universes; ``outputs`` a coefficient for each input, and a constant. With no ``rules`` it is
    empty.
    """
    parts = [HEAD.format(inputs=len(inputs), outputs=len(outputs), rules=rules)]
    for k, (name, (low, high)) in enumerate(inputs.items(), start=1):
        parts.append(
            f"[Input{k}]\nName='{name}'\nRange=[{low} {high}]\nNumMFs=1\nMF1='Any':'trapmf',[-900 -800 800 900]\n"
        )
    for k, (name, numbers) in enumerate(outputs.items(), start=1):
        terms = " ".join(map(str, numbers))
        parts.append(f"[Output{k}]\nName='{name}'\nRange=[-5 5]\nNumMFs=1\nMF1='Sum':'linear',[{terms}]\n")
    parts.append("[Rules]\n" + f"{'1 ' * len(inputs)}, {'1 ' * len(outputs)}(1) : 1\n" * rules)
    path.write_text("\n".join(parts), encoding="utf-8")
    return path


def lines(*starts: tuple[float, float], length: float = 6.0, duration: float = 20.0, more: str = "") -> str:
    """A scenario of robots that start at ``starts`` [m], each on a path straight ahead along x."""
    robots = "".join(
        f"""
[[robots]]
start = [{x}, {y}, 0.0]
path = {{ shape = "line", start = [{x}, {y}], end = [{x + length}, {y}] }}
timing = {{ duration = {duration} }}
"""
        for x, y in starts
    )
    kind = "team" if len(starts) > 1 else "tracking"
    return f'kind = "{kind}"\nduration = {duration}\n\n[radio]\ngraph = "complete"\nperiod = 0.05\n{robots}{more}'
