"""The command ``robotics dataset regenerate``: all computed files of ``datasets/``."""

from pathlib import Path
from typing import Annotated

from fuzzy.shell.options import Json, option
from fuzzy.shell.terminal import print_json


def regenerate(
    out: Annotated[Path, option("The folder datasets to fill.", "--out", "-o", "FOLDER")] = Path("datasets"),
    json: Json = False,
) -> None:
    """Make all computed files of datasets/ again, byte for byte: formation data with cards, the thesis's systems.

    The tables in FOLDER/thesis, which are transcribed and stay as they are, give the systems, .fis files; without them
    the command makes only the formation data.

    \b
    Example:
      robotics dataset regenerate --out datasets
    """
    from fuzzy.files.fisfile import write_fis
    from robotics.plugins.learning.datacard import thesis_facts, write_set
    from robotics.plugins.learning.formationdata import FILES, formation_data
    from robotics.plugins.thesis.printed_systems import NETWORKS, thesis_comment, thesis_system

    out.mkdir(parents=True, exist_ok=True)
    written = []
    for name, recipe in FILES.items():
        table = formation_data(recipe)
        kind, check = f" --kind {recipe.kind}", " --check" * recipe.stream
        facts = thesis_facts(recipe, f"robotics dataset formation{kind}{check} -o {name}")
        written += [out / name, write_set(out / name, facts, table.columns, table.values)]
    thesis = out / "thesis"
    if thesis.is_dir():
        for number in NETWORKS:
            fis = thesis_system(number, thesis)
            write_fis(fis, thesis / f"{fis.name}.fis", thesis_comment(number))
            written.append(thesis / f"{fis.name}.fis")
    if json:
        print_json({"files": [str(path) for path in written]})
    else:
        print(*written, sep="\n")
