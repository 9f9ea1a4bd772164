"""The controllers by name: presets of the laws, with the thesis's gains or the tuned ones, and those of users' files.

The laws in a Python file are its dataclasses derived from Law, and presets of such.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass, replace
from functools import cache
from inspect import get_annotations, isabstract
from pathlib import Path
from types import ModuleType
from typing import Any, Literal, cast, get_args, get_origin

from fuzzy.entrypoints import entry_points
from fuzzy.files.packaged import origin_of
from fuzzy.files.pythonfile import load_python_file, loaded_python_file
from fuzzy.naming import expected
from fuzzy.quantity import accepted
from robotics.laws.equation import KNOWLEDGE_FIELDS
from robotics.laws.foreign import telling_errors
from robotics.laws.law import ControllerError, Law, Preset
from robotics.laws.presets import published_presets, tuned_presets
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.specification import Specification, assignments
from robotics.world.vehicle.robot import Robot

# What users hand in: specifications, laws, and pairs of a name and a law; or laws by name
OwnLaws = Mapping[str, Law[Any] | str] | Sequence[str | Law[Any] | tuple[str, Law[Any] | str]]
LAW_ENTRY_POINTS = "fuzzyfleet.laws"  # the entry points by which plug-ins and other packages add laws
_OWN = "fuzzyfleet"  # the distribution whose laws are the catalogue's


def _loaded(own: bool, taken: Mapping[str, Preset]) -> tuple[dict[str, Preset], dict[str, str]]:
    """The presets that entry points name, and a sentence for each that cannot be used, by their names.

    Args:
        own: Whether those of this distribution are meant, or those of all others.
        taken: Presets whose names no other has.
    """
    good, bad = dict[str, Preset](), dict[str, str]()
    for entry in sorted(entry_points(group=LAW_ENTRY_POINTS), key=lambda e: e.name):
        if (entry.dist is not None and entry.dist.name == _OWN) != own:
            continue
        what = f"the law {entry.name!r} of {origin_of(entry)}"
        if entry.name in taken:
            bad[f"{entry.name} ({origin_of(entry)})"] = f"{what} has the name of one that comes with fuzzyfleet"
            continue
        try:
            thing = entry.load()
        except Exception as error:  # another package's module may raise anything when it is imported
            bad[entry.name] = f"{what} cannot be loaded: {type(error).__name__}: {error}"
            continue
        if isinstance(thing, type) and issubclass(thing, Law) and is_dataclass(thing):
            thing = Preset(thing, {}, entry.name, (thing.__doc__ or "").partition("\n")[0])
        if isinstance(thing, Preset):
            good[entry.name] = thing
        else:
            bad[entry.name] = f"{what} must be a Preset, or a dataclass derived from Law; got {thing!r}"
    return good, bad


_PUBLISHED = published_presets()
_PUBLISHED |= _loaded(True, _PUBLISHED)[0]
CATALOGUE: dict[str, Preset] = _PUBLISHED | tuned_presets(_PUBLISHED)


def presets() -> dict[str, Preset]:
    """All presets by name: the package's own, and after them those that other installed packages add.

    An entry point of the group ``fuzzyfleet.laws`` names a :class:`Preset`, or a dataclass derived from
    :class:`robotics.laws.law.Law`. An entry point that names neither, or cannot be loaded, is left out: see
    :func:`unusable_laws`.
    """
    return CATALOGUE | _installed()[0]


def unusable_laws() -> dict[str, str]:
    """The laws of other packages that cannot be used, by name, each with a sentence that says why."""
    return _installed()[1]


@cache
def _installed() -> tuple[dict[str, Preset], dict[str, str]]:
    return _loaded(False, CATALOGUE)


def preset_of(specification: str) -> Preset:
    """The preset of a specification ``name``, ``file.py:Law`` or ``file.fis``, each with gains behind it or without.

    Raises ControllerError for an unknown name, for a law of another package that cannot be used, and for a file that
    fails or has no such law.
    """
    about = Specification.of(specification)
    if about.file:
        if about.file.endswith(".fis"):
            return Preset(OwnRules, {"rule_base": about.file}, about.short, f"the rule base {about.short}")
        return law_in_file(about.file, about.name)
    known = presets()
    if about.name in unusable_laws():
        raise ControllerError(unusable_laws()[about.name])
    if about.name not in known:
        raise ControllerError(
            f"{expected(about.name, known, 'controller')}; or a file: mylaw.py:MyLaw, or mine.fis for a rule base"
        )
    return known[about.name]


def located(specification: str, folder: str | Path) -> str:
    """A specification whose files are taken from ``folder`` if they are there, else from the current folder, as before.

    >>> located("csm:k=0.3", "studies")
    'csm:k=0.3'
    """
    about = Specification.of(specification)
    there = about.located(folder)
    return specification if there == about else str(there)


def make_controller(specification: str) -> Law[Any]:
    """The controller of a specification ``name:gain=value,gain=value``, or of a law or a rule base in a file.

    ``path/mylaw.py:MyLaw:gain=value`` is the law ``MyLaw`` of a Python file, ``path/mine.fis:gain=value`` the law
    ``fuzzy`` with that rule base. A gain of a part, such as a team law's tracker, is called ``tracker.ky``, or only
    ``ky`` where no other gain is.

    Args:
        specification: The text; names are those of ``robotics.CATALOGUE``.

    Raises:
        ControllerError: An unknown name or gain, a value that the gain cannot take, or a file that fails.
    """
    about = Specification.of(specification)
    preset, name, gains = preset_of(specification), about.law, about.gains
    values = dict(preset.gains)
    known = gain_fields(preset.law)
    safe = ""
    short: dict[str, list[str]] = {}
    for long in known:
        short.setdefault(long.rpartition(".")[2], []).append(long)
    for gain, equals, text in assignments(gains):
        if gain == "safe" and gain not in known and text in ("yes", "no"):
            safe = text  # of any law: it is no gain of its own
            continue
        if gain not in known and len(short.get(gain, [])) == 1:
            gain = short[gain][0]
        if gain not in known or known[gain].name == "mode":
            raise ControllerError(f"controller {name!r}: " + expected(gain, known, "gain"))
        if not equals or not text:
            raise ControllerError(f"controller {name!r}: gain {gain!r} needs a value: {gain}=...")
        values[gain] = _value(name, known[gain], text)
    with telling_errors(preset.law, "the making"):
        try:
            law = _built(preset.law, values)
        except ControllerError as error:
            raise ControllerError(f"controller {name!r}: {error}") from None
    if safe:
        object.__setattr__(law, "safe", safe)
    return cast(Law[Any], law)


def as_law(controller: Law[Any] | str) -> Law[Any]:
    """A law itself, or that of a specification (:func:`make_controller`)."""
    return controller if isinstance(controller, Law) else make_controller(controller)


def named_laws(controllers: OwnLaws) -> list[tuple[str, Law[Any] | str]]:
    """Names and laws, or specifications, in their order; a law without a name has that of its class.

    Raises ControllerError for what is neither.
    """
    found: list[tuple[str, Any]] = []
    given: Any = controllers.items() if isinstance(controllers, Mapping) else controllers
    for item in given:
        pair = (item, item) if isinstance(item, str) else (type(item).__name__, item) if isinstance(item, Law) else item
        if not (isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], str)):
            raise ControllerError(f"a controller is a specification, a law, or a pair (name, law); got {item!r}")
        if not isinstance(pair[1], (str, Law)):
            raise ControllerError(f"the controller {pair[0]!r} must be a law or a specification; got {pair[1]!r}")
        found.append(pair)
    return found


def chosen_laws(controllers: OwnLaws) -> dict[str, Law[Any]]:
    """Laws by name: what ``controllers`` means wherever several are compared.

    Args:
        controllers: A list of specifications, laws, and pairs (name, law or specification); or these by name.

    Raises ControllerError for a specification that no controller has, for what is no law, and for a law that has the
    name of another in the catalogue.
    """
    laws: dict[str, Law[Any]] = {}
    for name, thing in named_laws(controllers):
        laws[name] = as_law(thing)
        if Specification.of(name).name in presets() and laws[name] != make_controller(name):
            raise ControllerError(f"the controller {name!r} is another law than the catalogue's of that name")
    return laws


def files_of(specification: str) -> dict[str, Path]:
    """The files on which a controller depends, by the text that names them: its own, and the .fis files of its gains.

    A gain that names a folder stands for the .fis files in it. Raises ControllerError as :func:`make_controller`.
    """
    about, found = Specification.of(specification), {}
    if about.file:
        found[about.file] = Path(about.file)
    for text in gains_of(make_controller(specification)).values():
        if isinstance(text, str):
            found |= fis_files_named(text)
    return found


def fis_files_named(text: str) -> dict[str, Path]:
    """The .fis file, or those of the folder, that a gain's ``text`` names, by name; empty where it names none."""
    path = Path(text or ".")
    if path.suffix in (".fis", ".json") and path.is_file():
        return {text: path}
    return {f"{text}/{file.name}": file for file in sorted(path.glob("*.fis"))} if text and path.is_dir() else {}


def gain_fields(law: type[Any]) -> dict[str, Any]:
    """The dataclass fields of ``law`` that are gains, by name; those of a part are called ``part.gain``.

    Last are the lead and the low-pass, which a part does not have.
    """
    found: dict[str, Any] = {}
    for f in sorted((f for f in fields(law) if f.init), key=lambda f: f.name in KNOWLEDGE_FIELDS):
        part = None if f.default_factory is MISSING else f.default_factory()
        if is_dataclass(part) and hasattr(part, "idle"):  # a law, or what it is made of; a system is a gain
            inner = gain_fields(type(part)).items()
            found |= {f"{f.name}.{name}": own for name, own in inner if name not in KNOWLEDGE_FIELDS}
        else:
            found[f.name] = f
    return found


def _built(law: type[Any], values: dict[str, Any]) -> Any:
    """Make a ``law`` with the gains ``values``, some of which are those of its parts."""
    own = {name: value for name, value in values.items() if "." not in name}
    for f in fields(law):
        changed = {n.partition(".")[2]: v for n, v in values.items() if n.partition(".")[0] == f.name and "." in n}
        if changed:
            assert f.default_factory is not MISSING
            own[f.name] = replace(f.default_factory(), **changed)
    return law(**own)


def _value(name: str, field: Any, text: str) -> Any:
    if "unit" in field.metadata and text != field.metadata.get("word"):
        try:
            return float(text)
        except ValueError:
            raise ControllerError(
                f"controller {name!r}: {field.name} must be {accepted(field.metadata)}; got {text!r}"
            ) from None
    if get_origin(field.type) is Literal and text not in get_args(field.type):
        choices = ", ".join(map(repr, get_args(field.type)))
        raise ControllerError(f"controller {name!r}: {field.name} must be one of {choices}; got {text!r}")
    read = _PLAIN.get(getattr(field.type, "__name__", str(field.type)))  # a name, as the future's annotations have it
    try:
        return text if read is None else read(text)
    except (ValueError, KeyError):
        kind = "true or false" if read is _truth else "a whole number" if read is int else "a number"
        raise ControllerError(f"controller {name!r}: {field.name} must be {kind}; got {text!r}") from None


def _truth(text: str) -> bool:
    return {"true": True, "false": False}[text.lower()]


_PLAIN: dict[str, Callable[[str], Any]] = {"float": float, "int": int, "bool": _truth}  # gains without unit and range


def gains_of(law: Law[Any]) -> dict[str, Any]:
    """Every gain of ``law`` that has an effect, by name, for a comparison to record beside its numbers.

    The lead and the low-pass are among them where the law itself says them.
    """
    found: dict[str, Any] = {}
    for name in gain_fields(type(law)):
        part, _, gain = name.rpartition(".")
        holder = getattr(law, part) if part else law
        unsaid = name in KNOWLEDGE_FIELDS and getattr(law, name) in (None, "")
        if gain not in holder.idle and name not in law.idle and not unsaid:
            found[name] = getattr(holder, gain)
    return found


def with_gains(law: Law[Any], gains: Mapping[str, Any]) -> Law[Any]:
    """The same law with other values of some gains, by name; one of a part is called ``part.gain``.

    Raises ControllerError for a value that a gain cannot take.
    """
    made: Any = law
    own = {name: value for name, value in gains.items() if "." not in name}
    for part in dict.fromkeys(name.partition(".")[0] for name in gains if "." in name):
        inside = {n.partition(".")[2]: v for n, v in gains.items() if n.startswith(f"{part}.")}
        own[part] = with_gains(getattr(made, part), inside)
    return cast(Law[Any], replace(made, **own))


def shown_gain(value: Any) -> str:
    """A gain's value in a table or a file: a number in short, a rule base by its name."""
    return f"{value:g}" if isinstance(value, float) else str(getattr(value, "name", value))


def label(specification: str) -> str:
    """A controller's name for figures and tables: the preset's title, with the gains that were changed.

    A law in a file is called as that file calls it, without its folder. Nothing of a Python file is run for its name.
    """
    about = Specification.of(specification)
    if about.file.endswith(".py"):
        preset = loaded_law(about.file, about.name)
        title = preset.title if preset is not None else about.short
    else:
        title = preset_of(specification).title
    return title + (f" ({about.gains})" if about.gains else "")


def law_title(controller: str) -> str:
    """The :func:`label` of a run's controller, or the name itself where there is no such preset (a run from a file)."""
    about = Specification.of(controller)
    if not about.file and about.name not in presets():
        return controller
    try:
        return label(controller)
    except ControllerError:
        return controller


def safety_distance(controller: str, robots: Sequence[Robot]) -> float | None:
    """The distance [m] between the centers of ``robots`` that a law keeps, by its specification.

    None if it keeps none, or is unknown. A Python file that has not run yet is not run for it: a run from a file may
    name any.
    """
    about = Specification.of(controller)
    if about.file.endswith(".py") and loaded_law(about.file, about.name) is None:
        return None
    try:
        return make_controller(controller).distance_between(robots)
    except ControllerError:  # of a run from a file, or of a law without a preset
        return None


def law_in_file(file: str, name: str = "") -> Preset:
    """The law ``name`` of a Python file, or its only one. Raises ControllerError, in one sentence, if there is none."""
    return _law_of(load_python_file(file, ControllerError), file, name)


def loaded_law(file: str, name: str = "") -> Preset | None:
    """The law of :func:`law_in_file` if the file has run already and has such a law; nothing runs."""
    module = loaded_python_file(file)
    try:
        return None if module is None else _law_of(module, file, name)
    except ControllerError:
        return None


def _law_of(module: ModuleType, file: str, name: str) -> Preset:
    short = Path(file).name
    own = laws_of(module)
    if not name:
        if len(own) != 1:
            have = f"it has {', '.join(own)}: say which, as in {short}:{next(iter(own))}" if own else "it has none"
            raise ControllerError(f"{file}: one law is needed, a frozen dataclass derived from robotics.Law; {have}")
        name = next(iter(own))
    if name not in vars(module):
        raise ControllerError(f"{file}: {expected(name, own, 'law')}")
    thing = vars(module)[name]
    if isinstance(thing, Preset):
        return thing
    if fault := _fault(thing):
        have = f"; it has: {', '.join(own)}" if own else ""
        raise ControllerError(f"{short}: {name} must be a frozen dataclass derived from robotics.Law: {fault}{have}")
    return Preset(thing, {}, name, (thing.__doc__ or "").partition("\n")[0])


def laws_of(module: ModuleType) -> dict[str, Any]:
    """The laws that a module defines, by name: presets, and the dataclasses that can be made."""
    return {
        name: thing
        for name, thing in vars(module).items()
        if isinstance(thing, Preset)
        or (getattr(thing, "__module__", None) == module.__name__ and _fault(thing) == "" and not name.startswith("_"))
    }


def _undeclared(law: type[Law[Any]]) -> bool:
    """Whether a class below a dataclass has fields of its own that it does not declare: they would be no gains."""
    return "__dataclass_params__" not in vars(law) and bool(get_annotations(law))


def _fault(thing: Any) -> str:
    """Why a thing is no law that can be made; "" if it is one."""
    if isinstance(thing, Law):
        return "it is a law already made; name its class, or a Preset of it"
    if not isinstance(thing, type):
        return f"it is {thing!r}"
    if not issubclass(thing, Law):
        return "it does not derive from robotics.Law"
    if isabstract(thing):
        return f"it does not define {' and '.join(sorted(thing.__abstractmethods__))}"
    if not is_dataclass(thing) or not cast(Any, thing).__dataclass_params__.frozen or _undeclared(thing):
        return "write @dataclass(frozen=True, kw_only=True) above the class"
    return ""
