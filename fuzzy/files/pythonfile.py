"""Python files of a user's own, loaded as modules by their paths: laws, metrics.

A file is read and run once for each content: an edited file is a new module, under another name, and what came from the
one before stays what it was. Modules that the file imports from its own folder are found, but not watched for changes.
"""

import hashlib
import sys
import threading
import traceback
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from fuzzy.errors import InputError

_PREFIX = "fuzzyfleet_file_"  # of the names of such modules
_LOADED: dict[Path, ModuleType] = {}  # by resolved path: the module of the content that was there last
_LOCK = threading.RLock()


def load_python_file(path: str | Path, fault: type[InputError]) -> ModuleType:
    """The module that a Python file makes; the file runs only if this content of it has not run before.

    Raises ``fault``, in one sentence with file and line, where it cannot be read or fails.
    """
    path = Path(path)
    try:
        source = path.read_bytes()
    except (OSError, ValueError) as error:
        raise fault(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    place = path.resolve()
    digest = hashlib.sha256(bytes(place) + b"\0" + source).hexdigest()
    name = f"{_PREFIX}{place.stem}_{digest[:16]}"
    with _LOCK:
        if name not in sys.modules:
            _run(name, path, place, source, fault)
        _LOADED[place] = sys.modules[name]
        return sys.modules[name]


def loaded_python_file(path: str | Path) -> ModuleType | None:
    """The module that :func:`load_python_file` made of a file last; None if it has not, and nothing runs."""
    return _LOADED.get(Path(path).resolve())


def _run(name: str, path: Path, place: Path, source: bytes, fault: type[InputError]) -> None:
    """Make the module ``name`` of a file and put it among the imported ones, where pickle finds it."""
    spec = spec_from_file_location(name, place)
    if spec is None:
        raise fault(f"{path}: the name of a Python file must end in .py")
    module = module_from_spec(spec)
    sys.modules[name] = module
    sys.path.append(str(place.parent))  # behind what is installed, which a neighbour of the file cannot hide
    try:
        # Compiled here, from what was read: compiled files on disk may be of an older content.
        exec(compile(source, str(place), "exec"), module.__dict__)
    except (Exception, SystemExit) as error:  # a file of the user's may raise anything
        del sys.modules[name]
        raise fault(told(error, place, str(path))) from error
    finally:
        sys.path.remove(str(place.parent))


def told(error: BaseException, place: str | Path, name: str) -> str:
    """What went wrong in a Python file, in one sentence with the last line of the file that was at work.

    Args:
        error: What was raised.
        place: The file, as its code was compiled.
        name: The name of the file in the sentence.
    """
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename == str(place):
        return f"{name}:{error.lineno}: {type(error).__name__}: {error.msg}"
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(place)]
    return f"{name}:{lines[-1]}: {what}" if lines else f"{name}: {what}"
