"""Files of interval type-2 systems: a .fis file of the upper system, with the lower functions in comments.

    write_fis(to_type2(read_fis("tip.fis"), lag=0.2), "tip2.fis")
    read_type2("tip2.fis")

``%! TypeReduction='karnikmendel'`` in [System] says that it is one. ``%! Lower=[0.9 0.2 0.2; 1 0 0]`` in an input says
of each term the scale and the lag to the left and to the right. MATLAB and Octave skip comments, and read the upper
system; :func:`matlab_type2` makes of that MATLAB's own type-2 system, by its documented properties. No file that
MATLAB wrote of such a system was found, and its format is not documented: it is neither read nor written.
"""

import os

from fuzzy.errors import quoted
from fuzzy.files.fisfile import FisFileError, FisText, file_bytes, parse_bytes, warned
from fuzzy.files.fislines import LOWER_NOTE, SectionLine
from fuzzy.membershipfunction import MembershipError, as_number
from fuzzy.plugins.type2.system import Lower, Type2Sugeno
from fuzzy.system import FuzzySystemError, Sugeno, Variable

_FORM = "[scale left-lag right-lag; ...], three numbers for each term"


def read_type2(path: str | os.PathLike[str]) -> Type2Sugeno:
    """Read the interval type-2 system in a .fis file, as :func:`fuzzy.write_fis` writes it.

    Args:
        path: The file.

    Returns:
        The system.

    Raises:
        FisFileError: A text that is no such system, with the file and the line.
    """
    name = os.fsdecode(path)
    return type2_of(file_bytes(name), name)


def type2_of(data: bytes, name: str) -> Type2Sugeno:
    """Read the bytes of a .fis file called ``name``; raises as :func:`read_type2` does."""
    fis = system_of(warned(parse_bytes(data, name, type2=True)), name)
    if isinstance(fis, Sugeno):
        raise FisFileError(
            name,
            None,
            "this is a type-1 system; `fuzzy type2`, or fuzzy.to_type2 in Python, makes a type-2 system of it",
        )
    return fis


def system_of(read: FisText, name: str) -> Sugeno | Type2Sugeno:
    """The system in a text called ``name``, of the type that it says; raises as :func:`read_type2` does."""
    if read.reduction is None:
        return read.system
    lower = {v.name: _lower(v, at, name) for v, at in zip(read.system.inputs, read.lower, strict=True) if at}
    try:
        return Type2Sugeno(read.system, lower, read.reduction.value.strip("'").casefold())  # type: ignore[arg-type]
    except FuzzySystemError as error:
        raise FisFileError(name, read.reduction.line, f"{error}\n  {quoted(read.reduction.text)}") from None


def _lower(variable: Variable, at: SectionLine, path: str) -> dict[str, Lower]:
    """The lower functions of one input's terms, by name, from the line of its note."""
    rows = [row.replace(",", " ").split() for row in at.value.strip("[]").split(";")] if variable.terms else []
    if len(rows) != len(variable.terms) or any(len(row) != 3 for row in rows):
        raise FisFileError(path, at.line, f"{variable.name}: {LOWER_NOTE} must be {_FORM}, got {quoted(at.value)}")
    try:
        values = [[float(word) for word in row] for row in rows]
        return {term: Lower(row[0], (row[1], row[2])) for term, row in zip(variable.terms, values, strict=True)}
    except (ValueError, MembershipError) as error:
        raise FisFileError(path, at.line, f"{variable.name}: {LOWER_NOTE}: {error}") from None


def _number(value: object) -> str:
    return repr(as_number(value)).removesuffix(".0")


def matlab_type2(fis: Type2Sugeno, file: str) -> str:
    """A MATLAB script that makes MATLAB's own type-2 system of a .fis file of :func:`fuzzy.write_fis`.

    Args:
        fis: The system.
        file: The name of its file, as MATLAB's ``readfis`` is to find it.

    Raises:
        FuzzySystemError: "nietan", a type reduction that MATLAB does not have.
    """
    if fis.reduction == "nietan":
        raise FuzzySystemError(f"{fis.name}: MATLAB has no type reduction 'nietan'")
    lines = [f"fis = convertToType2(readfis('{file}'));", f"fis.TypeReductionMethod = '{fis.reduction}';"]
    for i, variable in enumerate(fis.inputs, start=1):
        for t, each in enumerate(fis.lower[variable.name].values(), start=1):
            mf = f"fis.Inputs({i}).MembershipFunctions({t})"
            lags = " ".join(_number(lag) for lag in each.lag)
            lines += [f"{mf}.LowerScale = {_number(each.scale)};", f"{mf}.LowerLag = [{lags}];"]
    return "\n".join(lines) + "\n"
