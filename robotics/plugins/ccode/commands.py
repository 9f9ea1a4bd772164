"""The commands ``robotics export``: a law's control step as C99 for a robot, and the proof that it is the same."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fuzzy.shell.options import Json, argument, option
from fuzzy.shell.terminal import application, print_json
from robotics.commands.completion import controllers, scenarios

if TYPE_CHECKING:
    from robotics.plugins.ccode.verification import VerifiedLaw
    from robotics.plugins.ccode.writing import CLawFiles

Number = Literal["double", "float"]  # the types of numbers
export = application("Write a control law for a robot.", "robotics export c fuzzy -o out", commands="")


@export.command()
def c(
    controller: Annotated[
        str, argument("A law, such as fuzzy:rule_base=mine.fis or lyapunov:ky=8.", autocompletion=controllers)
    ],
    out: Annotated[Path, option("Where NAME.h and NAME.c are written.", "--out", "-o", "FOLDER")],
    number: Annotated[Number, option("Numbers of the C: double or float.")] = "double",
    name: Annotated[str, option("The files' name and the functions' prefix; the law's by default.")] = "",
    scenario: Annotated[
        str,
        option(
            "Its first robot and its control period count; --verify drives it.",
            "--scenario",
            "-s",
            autocompletion=scenarios,
        ),
    ] = "table-2-1",
    verify: Annotated[bool, option("Compile it, drive the scenario with it, compare, and watch for errors.")] = False,
    json: Json = False,
) -> None:
    """Write a law's control step as C99: no malloc, no library but math.h, its state in a struct.

    It writes fuzzy (with any rule base of a robot's own motion and its reference), fuzzy-lateral, fuzzy-correcting,
    lyapunov, lqr, pid, csm, assm, qssm and esm. --verify needs a C compiler. It drives a whole run of each of three
    seeds, with encoders that count finely where those of the robot do not tell, and exits with 1 if the robot with the
    C, in double, is not within 1e-9 m of the one with the law here; in float it prints the greatest distance. With
    safe=yes behind the law the monitor of passive safety is below it, in a team of like robots one that hears the
    others'; the command prints what its sensors do not see. Of any other law that commands velocities and says
    safe=yes, it writes the monitor alone, which takes the order.

    \b
    Example:
      robotics export c fuzzy -o out
      robotics export c lyapunov:ky=8 -o out --number float --scenario lyapunov-sine
      robotics export c fuzzy:safe=yes -o out --scenario reference --verify
      robotics export c fuzzy-team:safe=yes -o out --scenario three-cross
    """
    from robotics.plugins.ccode.verification import verify_c_law
    from robotics.plugins.ccode.writing import write_c_law
    from robotics.simulation.scenario.reading import load_scenario

    read = load_scenario(scenario)
    files = write_c_law(controller, read, out, number, name=name)
    proof = verify_c_law(files, [read]) if verify else None
    if json:
        print_json(_report(files, proof))
    else:
        _print(files, proof)
    if proof is not None and proof.holds is False:
        raise typer.Exit(1)


def _report(files: "CLawFiles", proof: "VerifiedLaw | None") -> dict[str, Any]:
    report: dict[str, Any] = {"files": [str(file) for file in files.files], "number": files.number}
    report["blind_spots"] = list(files.sources.blind)
    if proof is not None:
        told = ("scenario", "seeds", "greatest", "fine")
        drives = [{name: getattr(drive, name) for name in told} for drive in proof.drives]
        report |= {"drives": drives, "compiler": proof.compiler, "sanitized": proof.sanitized, "holds": proof.holds}
    return report


def _print(files: "CLawFiles", proof: "VerifiedLaw | None") -> None:
    for line in (*files.files, *files.sources.blind):
        print(line)
    if proof is None:
        return
    verdict = {True: "the same", False: "NOT THE SAME", None: "told, not judged, in float"}[proof.holds]
    for drive in proof.drives:
        seeds = ", ".join(map(str, drive.seeds))
        fine = f" ({drive.fine:.2g} m where the encoders count finely)" if drive.fine != drive.greatest else ""
        print(
            f"{drive.scenario}, seeds {seeds}: {drive.greatest:.2g} m apart at most{fine} in {drive.steps} steps: "
            f"{verdict}"
        )
    watched = "address and undefined-behaviour sanitizers clean" if proof.sanitized else "no sanitizers here"
    print(f"{proof.compiler}, {watched}")
