"""The command ``fuzzy step``: the step response of a system as controller of one's own plant."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict
from functools import partial
from pathlib import Path
from threading import Event, Thread
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fuzzy.commands.shared import FisFile, check_plot, parsed, read_system, usage
from fuzzy.naming import expected
from fuzzy.shell.options import FieldOptions, Json, option
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    from fuzzy.plugins.loop.controller import PID
    from fuzzy.plugins.loop.plant import FunctionPlant, TransferFunction
    from fuzzy.plugins.loop.response import Loop, StepResponse

_PATIENCE = 10.0  # s after which a plant in Python is said not to answer


def step(
    *,
    file: FisFile,
    plant: Annotated[
        str,
        option(
            "'numerator; denominator; dead time' highest power first, a .toml or .py file, or an example: "
            "lag, oscillating, integrating, unstable, motor.",
            "PLANT",
            show_default=False,
        ),
    ],
    loop: Annotated[
        "partial[Loop]",
        FieldOptions(
            "fuzzy.plugins.loop.response:Loop",
            *("reference", "duration", "sample_time", "noise", "seed", "rate_filter"),
            later=True,
        ),
    ],
    disturbance: Annotated[str | None, option("A step at the plant's input, from a time in s on.", "TIME,SIZE")] = None,
    limits: Annotated[str | None, option("The actuator's limits; LOW alone: no upper one.", "LOW,HIGH")] = None,
    scale: Annotated[
        list[str] | None, option("A scale factor: Ke, Kde, Kie, Ku, Kdu; repeat it. 1 by default.", "FACTOR=VALUE")
    ] = None,
    role: Annotated[
        list[str] | None,
        option(
            "What a variable is whose name does not say it: error, error_rate, error_sum, u, du; repeat it.",
            "VARIABLE=ROLE",
        ),
    ] = None,
    pid: Annotated[str, option("The gains of the PID beside it; rule: by SIMC or Ziegler; none.", "KP,KI,KD")] = "rule",
    plot: Annotated[Path | None, option("Draw output and control: .png, .pdf or .svg.", "PICTURE")] = None,
    json: Json = False,
) -> None:
    """Close the loop of a system with your own plant, and print the figures of its step response.

    Inputs are called error (e), error_rate (de), error_sum (ie); outputs u, which acts directly, or du, which is
    integrated. With --json also the samples are printed. A PID by a published rule stands beside it.

    \b
    Example:
      fuzzy new fuzzy-pd -o pd.fis
      fuzzy step pd.fis --plant '1; 1 1 0' --scale Kde=0.8 --scale Ku=4 --limits -4,4
      fuzzy step pd.fis --plant motor --disturbance 8,0.5 --plot step.png
    """
    from fuzzy.plugins.loop.controller import Scale
    from fuzzy.plugins.loop.response import step_response

    check_plot(plot)
    fis = read_system(file)
    period, settings = loop().period, dict[str, Any](loop.keywords)
    if disturbance is not None:
        settings["disturbance"] = tuple(_numbers(disturbance, "--disturbance", (2,)))
    if limits is not None:
        settings["limits"] = (*_numbers(limits, "--limits", (1, 2)), float("inf"))[:2]
    factors = {name: parsed(float, value, f"{name} takes numbers") for name, value in _named(scale or []).items()}
    known = asdict(Scale())
    for name in factors:
        if name not in known:
            usage(expected(name, known, "scale factor"))
    about: dict[str, Any] = {"scale": Scale(**factors), "roles": _named(role or [])}
    with _listening(plant) as answered:
        chosen = _plant(plant, answered)
        responses = {fis.name: step_response(fis, chosen, **about, **settings)}
        rival = _rival(pid, chosen, period)
        if rival is not None:
            responses["PID" if fis.name != "PID" else "PID, rival"] = step_response(rival, chosen, **settings)
    if plot is not None:
        from fuzzy.figures.plot import save_figure
        from fuzzy.plugins.loop.stepfigure import plot_step_response

        save_figure(plot_step_response(responses), plot)
    if json:
        pid_gains = {} if rival is None else {"pid": asdict(rival)}
        print_json({"plant": str(chosen), **pid_gains, "responses": {n: _data(r) for n, r in responses.items()}})
        return
    _print(responses)
    if rival is not None:
        by = f" ({rival.rule})" if rival.rule else ""
        print(f"PID: Kp {shown(rival.Kp)}, Ki {shown(rival.Ki)}, Kd {shown(rival.Kd)}{by}")
    for name, done in responses.items():
        if done.stopped:
            print(f"{name}: {done.stopped}")


@contextmanager
def _listening(plant: str) -> Iterator[Callable[[], None]]:
    """Say once on stderr that a plant in Python does not answer; what is given is to be called at each answer."""
    last, over = [monotonic()], Event()

    def listen() -> None:
        while not over.wait(last[0] + _PATIENCE - monotonic()):
            if monotonic() - last[0] >= _PATIENCE:
                typer.echo(f"The plant in {plant} has not answered for {_PATIENCE:g} s; Ctrl-C ends.", err=True)
                return

    if plant.casefold().endswith(".py"):
        Thread(target=listen, daemon=True).start()
    try:
        yield lambda: last.__setitem__(0, monotonic())
    finally:
        over.set()


def _plant(text: str, answered: Callable[[], None]) -> "TransferFunction | FunctionPlant":
    from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES, plant_of_text, read_plant

    if text in PLANT_EXAMPLES:
        return PLANT_EXAMPLES[text].plant
    return read_plant(Path(text), "", answered) if text.casefold().endswith((".py", ".toml")) else plant_of_text(text)


def _rival(text: str, plant: Any, sample_time: float) -> "PID | None":
    from fuzzy.plugins.loop.controller import PID, LoopError
    from fuzzy.plugins.loop.plant import TransferFunction
    from fuzzy.plugins.loop.rival import tuned_pid

    if text == "none":
        return None
    if text != "rule":
        return PID(*_numbers(text, "--pid", (1, 2, 3)))
    try:
        return tuned_pid(plant, sample_time) if isinstance(plant, TransferFunction) else None
    except LoopError as error:
        typer.echo(f"No PID: {error}.", err=True)
        return None


def _numbers(text: str, option: str, counts: Sequence[int]) -> list[float]:
    parts = text.split(",")
    if len(parts) not in counts:
        usage(f"{option} takes {' or '.join(map(str, counts))} numbers with commas between, got {text!r}")
    return [parsed(float, part, f"{option} takes numbers") for part in parts]


def _named(texts: Sequence[str]) -> dict[str, str]:
    """NAME=VALUE texts; a name may hold an equals sign."""
    found = {}
    for text in texts:
        name, sign, value = text.rpartition("=")
        if not sign:
            usage(f"expected NAME=VALUE, got {text!r}")
        found[name] = value
    return found


def _data(done: "StepResponse") -> dict[str, Any]:
    arrays = {name: getattr(done, name) for name in ("time", "output", "control", "error", "error_rate", "error_sum")}
    return {"figures": asdict(done.figures), "stopped": done.stopped, **arrays}


def _print(responses: "dict[str, StepResponse]") -> None:
    from fuzzy.plugins.loop.response import AFTER, TITLES

    first = next(iter(responses.values()))
    rows = [
        (title, unit, [getattr(done.figures, name) for done in responses.values()])
        for name, (title, unit) in TITLES.items()
        if name not in AFTER or first.loop.disturbed <= first.loop.steps
    ]
    wide = max(len(f"{title} [{unit}]") for title, unit, _ in rows)
    widths = [max(12, len(name)) for name in responses]
    print(" " * wide, *(name.rjust(width) for name, width in zip(responses, widths, strict=True)), sep="  ")
    for title, unit, values in rows:
        said = ["-" if value is None else shown(value) for value in values]
        cells = (text.rjust(width) for text, width in zip(said, widths, strict=True))
        print((f"{title} [{unit}]" if unit else title).ljust(wide), *cells, sep="  ")
