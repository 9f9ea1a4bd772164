"""The command ``fuzzy convert``: a system in another form."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from fuzzy.commands.shared import FisFile, usage
from fuzzy.shell.options import Json, argument, option

if TYPE_CHECKING:
    from fuzzy.system import Sugeno

Fit = Literal["constants", "planes"]  # what the sets of a Mamdani system become


def convert(
    file: FisFile,
    target: Annotated[Path, argument("A .fis, .fll, .txt or .json file.", "OUT")],
    fit: Annotated[
        Fit | None,
        option(
            "Fit the consequents to a Mamdani system's outputs: constants, or planes over the inputs.",
            show_default="constants at the centroids",
        ),
    ] = None,
    without_hedges: Annotated[
        bool, option('Make terms of "very left" and the like, which MATLAB cannot read, where these are exact.')
    ] = False,
    json: Json = False,
) -> None:
    """Write the system in another form, which OUT's suffix chooses.

    .fis is a normalised MATLAB file, .fll one of FuzzyLite, which FILE may be too, .txt the rules as sentences, .json a
    description of everything. A Mamdani system becomes a Sugeno system: each output set is a constant at its centroid,
    or what --fit makes of it by least squares. The command prints what it changed, and how far the two systems are
    apart on a grid over the inputs.

    \b
    Example:
      fuzzy example tipper
      fuzzy convert tipper.fis tipper.json
      fuzzy convert tracking tracking.txt
    """
    writers = {
        ".fis": "a MATLAB file",
        ".fll": "a FuzzyLite file",
        ".txt": "the rules as sentences",
        ".json": "a description",
    }
    suffix = target.suffix.lower()
    if suffix not in writers:
        known = ", ".join(f"{ending} ({what})" for ending, what in writers.items())
        usage(f"cannot tell the form from {str(target)!r}; end it in {known}")
    from fuzzy.files.packaged import find_fis

    source = file if file.suffix.lower() == ".fll" else find_fis(file)
    fis, told = _read(source, target, fit)
    if without_hedges:
        from fuzzy.plugins.mamdani import hedges

        fis = hedges.without_hedges(fis)
    if suffix == ".fis":
        from fuzzy.files.fisfile import write_fis

        write_fis(fis, target)
    elif suffix == ".fll":
        from fuzzy.plugins.mamdani.flltext import write_fll

        write_fll(fis, target)
    else:
        _write_text(fis, target, suffix)
    if json:
        from json import dumps

        typer.echo(dumps({"out": str(target), **told}, ensure_ascii=False, indent=2))
    else:
        _say(fis, told)


def _write_text(fis: "Sugeno", target: Path, suffix: str) -> None:
    from fuzzy.files.atomic import write_whole

    if suffix == ".txt":
        text = "".join(f"{rule}\n" for rule in fis.rules)
    else:
        from json import dumps

        from fuzzy.insight.description import as_dict

        text = dumps(as_dict(fis), ensure_ascii=False, indent=2) + "\n"
    write_whole(target, text)


def _read(source: Path, target: Path, fit: Fit | None) -> "tuple[Sugeno, dict[str, Any]]":
    """The Sugeno system of a file, and what to tell of a Mamdani system: changes and differences."""
    from fuzzy.errors import InputError
    from fuzzy.files.fisfile import read_mamdani

    if source.suffix.lower() == ".fll":
        from fuzzy.plugins.mamdani.fllfile import read_fll

        fis, changes = read_fll(source), tuple[str, ...]()
    else:
        fis, changes = read_mamdani(source)
    told: dict[str, Any] = {"mamdani": bool(changes), "changes": list(changes)}
    if not changes:
        if fit is not None:
            usage(f"--fit is for Mamdani systems; {source} holds a Sugeno system")
        return fis, told
    if target.exists() and target.samefile(source):
        usage(f"{target} holds the Mamdani system, which would be lost; give the Sugeno system another name")
    import warnings

    from fuzzy.plugins.mamdani.likeness import fit_to_mamdani, mamdani_difference, read_mamdani_original

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # said already
        try:
            original = read_mamdani_original(source)
        except InputError as error:
            if fit is not None:
                raise
            told["unmeasured"] = str(error)
            return fis, told
    told["difference"] = [each._asdict() for each in mamdani_difference(original, fis)]
    if fit is not None:
        fis = fit_to_mamdani(original, fis, fit)
        told["fit"] = fit
        told["fitted difference"] = [each._asdict() for each in mamdani_difference(original, fis)]
    return fis, told


def _say(fis: "Sugeno", told: dict[str, Any]) -> None:
    if not told["mamdani"]:
        return
    typer.echo(f"{fis.name} was a Mamdani system. As a Sugeno system it gives other values between its constants.")
    typer.echo("".join(f"- {change}\n" for change in told["changes"]), nl=False)
    if "unmeasured" in told:
        typer.echo(f"How far the two are apart is not measured: {told['unmeasured']}")
        return
    points = told["difference"][0]["points"]
    typer.echo(f"Difference on {points} points over the inputs, in shares of the output's range:")
    fitted = told.get("fitted difference")
    for place, before in enumerate(told["difference"]):
        typer.echo(f"  {before['output']}: {_shares(before)}{' with constants at the centroids' if fitted else ''}")
        if fitted:
            typer.echo(f"  {' ' * len(before['output'])}  {_shares(fitted[place])} with fitted {told['fit']}")
            worse = [
                what
                for key, what in (("greatest", "greatest"), ("mean", "mean"), ("root_mean_square", "root mean square"))
                if fitted[place][key] > before[key]
            ]
            if worse:
                typer.echo(f"  Fitting made the {' and the '.join(worse)} difference of {before['output']} worse.")


def _shares(difference: dict[str, Any]) -> str:
    return (
        f"greatest {difference['greatest']:.2%}, mean {difference['mean']:.2%}, "
        f"root mean square {difference['root_mean_square']:.2%}"
    )
