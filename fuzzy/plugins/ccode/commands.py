"""The commands ``fuzzy export``: a system as C99 for a microcontroller, and the proof that it is the same."""

import re
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fuzzy.commands.shared import FisOrTree, read_system, read_tree, usage
from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import application, print_json
from fuzzy.shown import shown

if TYPE_CHECKING:
    from fuzzy import Tree
    from fuzzy.plugins.ccode.cortexm import OnBoard
    from fuzzy.plugins.ccode.verification import Verified
    from fuzzy.plugins.ccode.writing import CFiles
    from fuzzy.system import Sugeno

Number = Literal["double", "float", "q16.16"]  # the types of numbers
export = application(
    "Write a system for another machine.", "fuzzy example tipper", "fuzzy export c tipper.fis -o out", commands=""
)


@export.command()
def c(
    file: FisOrTree,
    out: Annotated[Path, option("Where NAME.h and NAME.c are written.", "--out", "-o", "FOLDER")],
    number: Annotated[
        Number, option("double, float, or q16.16: fixed point without floating point at run time.")
    ] = "double",
    name: Annotated[str, option("The files' name and the functions' prefix; the system's by default.")] = "",
    table: Annotated[
        str | None, option("For one or two inputs: a table of so many points in place of the rules.", "N|NxM")
    ] = None,
    verify: Annotated[bool, option("Compile it, run it on a million points, compare, and watch for errors.")] = False,
    points: Annotated[int, option("With --verify: how many points.", min=1)] = 1_000_000,
    board: Annotated[
        bool, option("Run it on a Cortex-M4 that QEMU emulates: flash, RAM, instructions a call.")
    ] = False,
    json: Json = False,
) -> None:
    """Write a system as one header and one source of C99: no malloc, no library but math.h. Of a tree, a pair each too.

    It writes every system that it can read: all membership functions, hedges, "not", weights, both defuzzifications,
    several outputs, and systems learnt by ANFIS. --verify needs a C compiler and exits with 1 if the C is not the same:
    within 4e-15 of an output's range in double, 1e-6 in float and 0.01 in q16.16, whose faint strengths are 0.

    \b
    Example:
      fuzzy example tipper
      fuzzy export c tipper.fis -o out --verify --points 10000
      fuzzy export c tracking -o out --number q16.16
    """
    from fuzzy.plugins.ccode.cortexm import run_on_board
    from fuzzy.plugins.ccode.verification import verify_c
    from fuzzy.plugins.ccode.writing import write_c

    if tree := read_tree(file):
        if table is not None or board:
            usage("--table and --board are for single systems: take the .fis files of the tree")
        _export_tree(tree, out, number, name, points if verify else 0, json)
        return
    fis = read_system(file)
    files = write_c(fis, out, number, name=name, lookup=None if table is None else _shape(table))
    proof = verify_c(fis, files, points) if verify else None
    on_board = run_on_board(fis, files) if board else None
    if json:
        print_json(_report(files, proof, on_board))
    else:
        _print(files, proof, on_board)
    if proof is not None and proof.holds is False:
        warnings.warn(_worst(fis, proof), stacklevel=2)
    if (proof is not None and proof.holds is False) or (on_board is not None and not on_board.equal):
        raise typer.Exit(1)


def _export_tree(tree: "Tree", out: Path, number: str, name: str, points: int, json: bool) -> None:
    """Write a tree, and prove its systems one by one at so many points, if any."""
    import fuzzy

    written = fuzzy.write_c_tree(tree, out, number, name=name)
    pairs = [
        (files, fuzzy.verify_c(tree.systems[system], files, points) if points else None)
        for system, files in zip(tree.order, written.systems, strict=True)
    ]
    if json:
        paths = {"header": str(written.header), "source": str(written.source), "number": number}
        print_json(paths | {"systems": [_report(files, proof, None) for files, proof in pairs]})
    else:
        print(f"{written.header}\n{written.source}")
        for files, proof in pairs:
            _print(files, proof, None)
    if any(proof is not None and proof.holds is False for _, proof in pairs):
        raise typer.Exit(1)


def _shape(text: str) -> tuple[int, ...]:
    found = re.fullmatch(r"(\d{1,6})(?:x(\d{1,6}))?", text.strip())
    if found is None:
        usage(f"--table takes a number of points N, or NxM for two inputs; got {text!r}")
    return tuple(int(part) for part in found.groups() if part is not None)


def _print(files: "CFiles", proof: "Verified | None", on_board: "OnBoard | None") -> None:
    print(files.header)
    print(files.source)
    if files.lookup is not None:
        errors = zip(files.lookup.greatest, files.lookup.mean, strict=True)
        told = "; ".join(f"{shown(g)} at most, {shown(m)} on average" for g, m in errors)
        print(f"the table differs from the rules by {told} (in the outputs' units)")
    if proof is not None:
        for d in proof.differences:
            print(
                f"{d.output}: differs by {d.greatest:.2g} at most, {d.mean:.2g} on average; "
                f"{d.share:.2g} of its range of {shown(d.span)}" + _cancels(d.scale / d.span if d.span > 0 else 1.0)
            )
        watched = "address and undefined-behaviour sanitizers clean" if proof.sanitized else "no sanitizers here"
        print(f"{proof.points} points, {proof.compiler}, {watched}{_verdict(proof)}")
    if on_board is not None:
        print(
            f"on a Cortex-M4 in QEMU: {on_board.flash} bytes of flash, {on_board.ram} of RAM, {on_board.instructions} "
            f"instructions at most ({on_board.median} the median) of 200 points; "
            f"{'the same answers' if on_board.equal else 'OTHER ANSWERS'} ({on_board.compiler})"
        )


def _cancels(ratio: float) -> str:
    return f" (its rules propose up to {shown(ratio)} times that and cancel)" if ratio > 1.5 else ""


def _verdict(proof: "Verified") -> str:
    from fuzzy.plugins.ccode.verification import LIMITS

    if proof.holds is None:
        return ""
    limit = f"{LIMITS[proof.number]:g}"
    if not proof.holds:
        return f": NOT the same within {limit}"
    if all(d.share <= LIMITS[proof.number] for d in proof.differences):
        return f": the same within {limit} of the range"
    return f": the same within {limit} of what its rules propose, and of what fires where they cancel"


def _worst(fis: "Sugeno", proof: "Verified") -> str:
    """Where the C differs most, in a sentence."""
    worst = max(proof.differences, key=lambda d: d.greatest / d.scale if d.scale > 0 else d.greatest)
    point = ", ".join(f"{v.name} = {value:.9g}" for v, value in zip(fis.inputs, worst.at, strict=True))
    why = "; strengths below 1e-9 are 0 in fixed point" if proof.number == "q16.16" else ""
    return f"{worst.output} differs by {worst.share:.2g} of its range of {shown(worst.span)} at {point}{why}"


def _report(files: "CFiles", proof: "Verified | None", on_board: "OnBoard | None") -> dict[str, Any]:
    report: dict[str, Any] = {"header": str(files.header), "source": str(files.source), "number": files.number}
    if files.lookup is not None:
        report["table"] = {"points": files.lookup.points, "greatest": files.lookup.greatest, "mean": files.lookup.mean}
    if proof is not None:
        outputs = [{**vars(d), "share": d.share} for d in proof.differences]
        report["proof"] = {**vars(proof), "differences": outputs}
    if on_board is not None:
        report["board"] = vars(on_board)
    return report
