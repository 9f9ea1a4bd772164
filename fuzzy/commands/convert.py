"""The command ``fuzzy convert``: a system in another form."""

from pathlib import Path
from typing import Annotated

import typer

from fuzzy.commands.shared import FisFile, usage


def convert(
    file: FisFile,
    target: Annotated[Path, typer.Argument(metavar="OUT", help="A .fis, .txt or .json file.", show_default=False)],
) -> None:
    """Write the system in another form, which OUT's suffix chooses.

    .fis is a normalised MATLAB file, .txt the rules as sentences, .json a description of everything. A Mamdani system
    becomes a Sugeno system: each output set is a constant at its centroid. What was changed is printed.

    \b
    Example:
      fuzzy example tipper
      fuzzy convert tipper.fis tipper.json
      fuzzy convert tracking tracking.txt
    """
    writers = {".fis": "a MATLAB file", ".txt": "the rules as sentences", ".json": "a description"}
    suffix = target.suffix.lower()
    if suffix not in writers:
        known = ", ".join(f"{ending} ({what})" for ending, what in writers.items())
        usage(f"cannot tell the form from {str(target)!r}; end it in {known}")
    from fuzzy.files.fisfile import read_mamdani
    from fuzzy.files.packaged import find_fis

    source = find_fis(file)
    fis, changes = read_mamdani(source)
    if changes:
        if target.exists() and target.samefile(source):
            usage(f"{target} holds the Mamdani system, which would be lost; give the Sugeno system another name")
        typer.echo(f"{fis.name} was a Mamdani system. As a Sugeno system it gives other values between its constants.")
        typer.echo("".join(f"- {change}\n" for change in changes), nl=False)
    if suffix == ".fis":
        from fuzzy.files.fisfile import write_fis

        write_fis(fis, target)
        return
    from fuzzy.files.atomic import replacing

    if suffix == ".txt":
        text = "".join(f"{rule}\n" for rule in fis.rules)
    else:
        from json import dumps

        from fuzzy.insight.description import as_dict

        text = dumps(as_dict(fis), ensure_ascii=False, indent=2) + "\n"
    with replacing(target) as path:
        path.write_text(text, encoding="utf-8")
