"""The laws in a Python file of the user's own: dataclasses derived from Law, and presets of such."""

from dataclasses import is_dataclass
from inspect import get_annotations, isabstract
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from fuzzy.files.pythonfile import load_python_file, loaded_python_file
from fuzzy.naming import expected
from robotics.laws.law import ControllerError, Law, Preset


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
