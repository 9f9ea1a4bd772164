"""The command ``fuzzy step``: the step response of a system as controller of one's own plant."""

import math
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from threading import Event, Thread
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fuzzy.commands.shared import FisFile, check_plot, parsed, read_system, usage
from fuzzy.naming import expected
from fuzzy.shell.options import FieldOptions, Json, option
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shell.terminal import print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    from fuzzy.plugins.loop.controller import PID
    from fuzzy.plugins.loop.controllercode import ProvenController
    from fuzzy.plugins.loop.plant import TransferFunction
    from fuzzy.plugins.loop.plantfile import Plant
    from fuzzy.plugins.loop.response import Loop, StepResponse
    from fuzzy.plugins.loop.scheduledplant import ScheduledTransferFunction
    from fuzzy.system import Sugeno

_PATIENCE = 10.0  # s after which a plant in Python is said not to answer


def step(
    *,
    file: FisFile,
    plant: Annotated[
        str | None,
        option(
            "'numerator; denominator; dead time' highest power first, 'value: ... | value: ...' for operating points, "
            "a .toml or .py file, or an example: lag, oscillating, integrating, unstable, motor, mixing. By default "
            "the loop that the designer kept in FILE, with the options that are given in its place.",
            "PLANT",
            show_default=False,
        ),
    ] = None,
    loop: Annotated[
        "partial[Loop]",
        FieldOptions(
            "fuzzy.plugins.loop.response:Loop",
            *("reference", "duration", "sample_time", "noise", "seed", "rate_filter"),
            given=True,
        ),
    ],
    disturbance: Annotated[str | None, option("A step at the plant's input, from a time in s on.", "TIME,SIZE")] = None,
    operating: Annotated[
        str | None,
        option(
            "The variable that changes the plant, a value or its course; by default a ramp over the plant's points.",
            "VALUE|'TIME,VALUE ...'",
            show_default=False,
        ),
    ] = None,
    limits: Annotated[str | None, option("The actuator's limits; LOW alone: no upper one.", "LOW,HIGH")] = None,
    scale: Annotated[
        list[str] | None, option("A scale factor: Ke, Kde, Kie, Ku, Kdu; repeat it. 1 by default.", "FACTOR=VALUE")
    ] = None,
    role: Annotated[
        list[str] | None,
        option(
            "What a variable is whose name does not say it: error, error_rate, error_sum, scheduling (the operating "
            "variable), u, du; repeat it.",
            "VARIABLE=ROLE",
        ),
    ] = None,
    pid: Annotated[str, option("The gains of the PID beside it; rule: by SIMC or Ziegler; none.", "KP,KI,KD")] = "rule",
    from_pid: Annotated[
        bool,
        option(
            "Take the scale factors with which the rules act as the PID does: a start from which to tune. A scheduled "
            "rule base gets rules that are the PID of each operating point."
        ),
    ] = False,
    tune: Annotated[
        int, option("Tune the loop with so many evaluations, on plants that differ by 25 % too; with -o.", min=0)
    ] = 0,
    move: Annotated[
        list[str] | None,
        option(
            "With --tune, what may move: factors, memberships, consequents, weights, choices, rules; repeat it. "
            "By default the first three.",
            "PART",
        ),
    ] = None,
    output_file: Annotated[
        Path | None, option("Write the rule base with its loop, as tuned or begun.", "--output-file", "-o", "FILE.fis")
    ] = None,
    c: Annotated[
        Path | None,
        option(
            "Write the whole controller in C: rules, factors, rate, integral, limits; and prove it.", "--c", "FOLDER"
        ),
    ] = None,
    number: Annotated[Literal["double", "float"], option("With --c, its numbers.")] = "double",
    certify: Annotated[
        bool,
        option("Prove from where, and how fast, the loop converges: over boxes, not from samples. For a linear plant."),
    ] = False,
    plot: Annotated[Path | None, option("Draw output and control: .png, .pdf or .svg.", "PICTURE")] = None,
    json: Json = False,
) -> None:
    """Close the loop of a system with your own plant, and print the figures of its step response.

    Inputs are called error (e), error_rate (de), error_sum (ie); outputs u, which acts directly, or du, which is
    integrated. --json also prints the samples. A PID by a published rule is shown beside it. Without --plant
    the command simulates the loop that the designer kept in the file. It simulates a plant with operating points at
    each, and as its variable moves; an input with the role scheduling takes that variable.

    \b
    Example:
      fuzzy new fuzzy-pd -o pd.fis
      fuzzy step pd.fis --plant '1; 1 1 0' --scale Kde=0.8 --scale Ku=4 --limits -4,4
      fuzzy step pd.fis --plant '1; 1 1 0' --scale Ku=4 --limits -4,4 --certify
      fuzzy step pd.fis --plant motor --disturbance 8,0.5 --plot step.png
      fuzzy new fuzzy-pi terms=5 -o pi.fis
      fuzzy step pi.fis --plant '2; 3 1; 0.8' --limits -1,1 --from-pid --tune 40 -o tuned.fis
      fuzzy step tuned.fis --c controller
      fuzzy example mixing
      fuzzy step mixing.fis
      fuzzy step mixing.fis --operating '10,0.5 30,4' --from-pid -o scheduled.fis
    """
    from fuzzy.files.fisfile import write_fis
    from fuzzy.plugins.loop.controller import Scale, roles_of
    from fuzzy.plugins.loop.keptloop import kept_text, pid_of, settings_of, step_arguments
    from fuzzy.plugins.loop.response import Loop, clipping, respond
    from fuzzy.plugins.loop.scheduledplant import Course, operating_points
    from fuzzy.plugins.loop.scheduledrules import along_points, loop_at, pids_of

    check_plot(plot)
    fis = read_system(file)
    kept = {} if plant is not None else _kept(fis, file)
    settings = {**(step_arguments(kept) if kept else {}), **loop.keywords}
    if disturbance is not None:
        settings["disturbance"] = tuple(_numbers(disturbance, "--disturbance", (2,)))
    if limits is not None:
        settings["limits"] = (*_numbers(limits, "--limits", (1, 2)), float("inf"))[:2]
    factors = {name: parsed(float, value, f"{name} takes numbers") for name, value in _named(scale or []).items()}
    known = asdict(Scale())
    for name in factors:
        if name not in known:
            usage(expected(name, known, "scale factor"))
    scales, roles = settings.pop("scale", Scale()), {**settings.pop("roles", {}), **_named(role or [])}
    when, size = settings.pop("disturbance", (math.inf, 0.0))
    low, high = settings.pop("limits", (-math.inf, math.inf))
    if operating is not None:
        settings["operating"] = Course.of(operating)
    wanted = replace(
        Loop(**settings), disturbance_time=when, disturbance=size, low=low, high=high, scale=replace(scales, **factors)
    )
    told: dict[str, Any] = {}
    with _listening(plant or "") as answered:
        chosen = _plant(plant, answered) if plant is not None else _kept_plant(kept, file)
        points, wanted = operating_points(chosen), along_points(chosen, wanted)
        own = pid_of(kept) if kept and pid == "rule" else None
        rival = own or _rival(pid, chosen, wanted)
        if from_pid:
            fis, wanted = _begun(fis, rival, chosen, wanted, roles, told)
        responses = {fis.name: respond(fis, chosen, wanted, roles_of(fis, roles))}
        if tune:
            fis, wanted = _tuned(fis, chosen, wanted, roles, tune, move, told)
            responses[f"{fis.name}, tuned"] = respond(fis, chosen, wanted, roles_of(fis, roles))
        if rival is not None:
            responses["PID" if fis.name != "PID" else "PID, rival"] = respond(rival, chosen, wanted)
        there = {}
        own_pids = pids_of(chosen, wanted.period) if points and pid == "rule" and rival is not None else {}
        for value in points:
            at = loop_at(wanted, value)
            named = {
                fis.name: (fis, roles_of(fis, roles)),
                "PID": (rival, None),
                "PID of it": (own_pids.get(value), None),
            }
            there[value] = {n: respond(who, chosen, at, r) for n, (who, r) in named.items() if who is not None}
    if output_file is not None:
        fixed = rival if pid not in ("rule", "none") else own
        kept_now = kept_text(settings_of(wanted, _kept_of(chosen, plant, kept), roles, fixed))
        write_fis(replace(fis, loop=kept_now), output_file)
    proof = _written(fis, wanted, roles, c, number, told) if c is not None else None
    if plot is not None:
        from fuzzy.figures.plot import save_figure
        from fuzzy.plugins.loop.stepfigure import plot_step_response

        every = {f"{fis.name} at {value:g}": found[fis.name] for value, found in there.items()}
        save_figure(plot_step_response(responses | every), plot)
    proven = _certified(fis, chosen, wanted, roles, points) if certify else {}
    failed = any("failed" in said for said in proven.values()) or (proof is not None and not proof.holds)
    if json:
        pid_gains = {} if rival is None else {"pid": asdict(rival)}
        print_json(
            {"plant": str(chosen), **pid_gains, **told, "responses": {n: _data(r) for n, r in responses.items()}}
            | ({"points": {v: {n: _data(r) for n, r in rs.items()} for v, rs in there.items()}} if points else {})
            | ({"certificates": proven} if certify else {})
        )
        raise typer.Exit(failed)
    for value, found in there.items():
        print(f"operating variable {value:g}:")
        _print(found)
        print()
    if points:
        print(f"operating variable {_course(wanted)}:")
    _print(responses)
    _tell(told)
    if rival is not None:
        by = f" ({rival.rule})" if rival.rule else ""
        print(f"PID: Kp {shown(rival.Kp)}, Ki {shown(rival.Ki)}, Kd {shown(rival.Kd)}{by}")
    at_points = {f"{name} at {value:g}": done for value, found in there.items() for name, done in found.items()}
    for name, done in (responses | at_points).items():
        if done.stopped:
            print(f"{name}: {done.stopped}")
    for sentence in clipping(fis, responses[[*responses][tune > 0]], roles_of(fis, roles)):
        print(sentence)
    for name, said in proven.items():
        print(f"\n{name}\n" + "\n".join(f"- {line}" for line in said.get("certified") or said["failed"]))
    raise typer.Exit(failed)


def _begun(
    fis: "Sugeno", rival: "PID | None", plant: Any, loop: "Loop", roles: dict[str, str], told: dict[str, Any]
) -> "tuple[Sugeno, Loop]":
    """The rule base and the loop that act as a PID does: with its scale factors, or rules for each operating point."""
    from fuzzy.plugins.loop.controller import Scale, roles_of
    from fuzzy.plugins.loop.equivalent import scale_from_pid
    from fuzzy.plugins.loop.scheduledrules import schedule_from_pids

    if "scheduling" in roles_of(fis, roles).inputs:
        return schedule_from_pids(fis, plant, loop, roles), replace(loop, scale=Scale())
    if rival is None:
        usage("--from-pid needs a PID: one by rule, for a transfer function, or its gains by --pid KP,KI,KD")
    scale, told["deviation"] = scale_from_pid(fis, rival, plant, loop, roles)
    told["scale"] = asdict(scale)
    return fis, replace(loop, scale=scale)


def _course(loop: "Loop") -> str:
    """The operating variable over time, in words."""
    course = loop.operating
    assert course is not None
    return ", ".join(f"{shown(value)} at {shown(time)} s" for time, value in course.places)


def _tuned(
    fis: "Sugeno",
    plant: Any,
    loop: "Loop",
    roles: dict[str, str],
    evaluations: int,
    move: list[str] | None,
    told: dict[str, Any],
) -> "tuple[Sugeno, Loop]":
    """The rule base and the loop as a search leaves them."""
    from fuzzy.plugins.loop.scheduledplant import operating_points
    from fuzzy.plugins.loop.tuning import DEFAULT_MOVE, tune_loop

    with progress_bar(not sys.stderr.isatty()) as begin:
        moved = Mover(begin("tuning", evaluations))
        found = tune_loop(
            fis,
            plant,
            loop,
            roles=roles,
            move=move or DEFAULT_MOVE,
            evaluations=evaluations,
            progress=lambda e: moved(len(e)),
        )
    costs = found.evaluations.costs
    told["tuned"] = {"cost": float(costs.min()), "before": float(costs[0]), "evaluations": len(costs)}
    told["where"] = ", at each operating point" if operating_points(plant) else ""
    told["scale"] = asdict(found.scale)
    return found.fis, replace(loop, scale=found.scale)


def _kept_of(
    plant: Any, text: str | None, kept: dict[str, Any]
) -> "TransferFunction | ScheduledTransferFunction | str":
    """What of a plant is written beside a rule base: transfer functions themselves, else its file."""
    from fuzzy.plugins.loop.plant import FunctionPlant

    return plant if not isinstance(plant, FunctionPlant) else Path(text).name if text else str(kept["source"])


def _written(
    fis: "Sugeno", loop: "Loop", roles: dict[str, str], folder: Path, number: str, told: dict[str, Any]
) -> "ProvenController | None":
    """Write the controller in C, and prove it where there is a compiler."""
    from fuzzy.plugins.ccode.compiler import CompilerError, find_compiler
    from fuzzy.plugins.loop.controller import roles_of
    from fuzzy.plugins.loop.controllercode import controller_code, prove_controller, write_controller

    known = roles_of(fis, roles)
    files = controller_code(fis, loop, known, number=number)
    told["files"] = [str(path) for path in write_controller(files, folder)]
    try:
        find_compiler()
    except CompilerError as error:
        typer.echo(f"The C is not proven: {error}.", err=True)
        return None
    proof = prove_controller(files, fis, loop, known)
    told["proof"] = asdict(proof)
    return proof


def _certified(
    fis: "Sugeno", plant: Any, loop: "Loop", roles: dict[str, str], points: tuple[float, ...]
) -> dict[str, dict[str, Any]]:
    """What is proven of the loop, at each operating point, and why not: by what a reader is told."""
    from fuzzy.plugins.loop.certificate import NotCertified, certify_step, sentences
    from fuzzy.plugins.loop.scheduledrules import loop_at

    proven: dict[str, dict[str, Any]] = {}
    for value in points or (None,):
        found = certify_step(fis, plant, loop if value is None else loop_at(loop, value), roles)
        where = "" if value is None else f" at {value:g}"
        if isinstance(found, NotCertified):
            said = {"failed": sentences(found), "box": dict(found.box), "direction": dict(found.direction)}
        else:
            names = ("P", "rest", "fall", "rate", "fastest", "end", "start", "widths", "boxes")
            said = {"certified": sentences(found), "states": found.system.states}
            said |= {name: getattr(found, name) for name in names}
        proven[f"{'Not certified' if isinstance(found, NotCertified) else 'Certified'}{where}"] = said
    return proven


def _tell(told: dict[str, Any]) -> None:
    """What was found beside the responses."""
    if "scale" in told:
        print("scale factors: " + ", ".join(f"{name} {shown(value)}" for name, value in told["scale"].items()))
    if told.get("deviation", 0.0) > 1e-3:
        print(f"The rules are not linear: they differ from the PID by up to {100 * told['deviation']:.2g} % there.")
    if "tuned" in told:
        before, cost = told["tuned"]["before"], told["tuned"]["cost"]
        print(
            f"tuned: cost {shown(before)} before, {shown(cost)} after, over plants that differ by 25 %{told['where']}"
        )
    for path in told.get("files", ()):
        print(path)
    if "proof" in told:
        proof = told["proof"]
        print(
            f"{proof['samples']} samples, {100 * proof['limited']:.0f} % at a limit: the C differs by "
            f"{proof['greatest']:.2g} at most, {'the same' if proof['holds'] else 'NOT the same'} ({proof['compiler']})"
        )


def _kept(fis: "Sugeno", file: Path) -> dict[str, Any]:
    """The loop that is kept in ``file``, where there is one whose plant is safe to take."""
    from fuzzy.plugins.loop.keptloop import kept_settings

    if not fis.loop:
        usage(
            f"--plant is missing, such as --plant '1; 1 1 0', and {file} keeps no loop: the designer's "
            "tab Step response writes one into it"
        )
    kept = kept_settings(fis.loop)
    if (source := kept["source"]).endswith(".py"):
        usage(f"the plant that {file} names is {source}, a Python file: --plant {source} runs it")
    return kept


def _kept_plant(kept: dict[str, Any], file: Path) -> "Plant":
    from fuzzy.plugins.loop.keptloop import transfer_of
    from fuzzy.plugins.loop.plantfile import read_plant

    return read_plant(file.parent / kept["source"], "") if kept["source"] else transfer_of(kept)


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


def _plant(text: str, answered: Callable[[], None]) -> "Plant":
    from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES, plant_of_text, read_plant

    if text in PLANT_EXAMPLES:
        return PLANT_EXAMPLES[text].whole
    return read_plant(Path(text), "", answered) if text.casefold().endswith((".py", ".toml")) else plant_of_text(text)


def _rival(text: str, plant: Any, loop: "Loop") -> "PID | None":
    from fuzzy.plugins.loop.controller import PID, LoopError
    from fuzzy.plugins.loop.plant import FunctionPlant
    from fuzzy.plugins.loop.scheduledrules import ruled_pid

    if text not in ("none", "rule"):
        return PID(*_numbers(text, "--pid", (1, 2, 3)))
    if text == "none" or (isinstance(plant, FunctionPlant) and not plant.operating):
        return None
    try:
        return ruled_pid(plant, loop)
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
    from fuzzy.plugins.loop.response import figure_rows

    rows = figure_rows(responses)
    wide = max(len(title) for title, _ in rows)
    widths = [max(12, len(name)) for name in responses]
    print(" " * wide, *(name.rjust(width) for name, width in zip(responses, widths, strict=True)), sep="  ")
    for title, values in rows:
        said = ["-" if value is None else shown(value) for value in values]
        cells = (text.rjust(width) for text, width in zip(said, widths, strict=True))
        print(title.ljust(wide), *cells, sep="  ")
