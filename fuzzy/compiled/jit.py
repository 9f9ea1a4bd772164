"""The decorator of every compiled function, and the cache on disk that its machine code comes from.

Numba's own cache looks at the file of the function that is called, and at no other: with it, a change of a callee,
of a constant or of the order of a named tuple's fields elsewhere leaves yesterday's machine code in use. Here a file
of the cache bears a fingerprint of all that Numba compiles: the code of the function and of every function it
calls, the values of the globals they name, the options and the versions. A change anywhere is another file name.
What a fingerprint cannot see (a dict, a class) is refused at the first call.

The cache lies where Numba puts its own: ``NUMBA_CACHE_DIR``, else ``__pycache__``, else the user's cache folder. What
is not there is looked for among the kernels that a wheel brings, the same files in an archive for each baseline: a CPU
that can do no more than the user's. With ``NUMBA_DISABLE_JIT=1`` functions stay as they are.
"""

import dis
import hashlib
import lzma
import os
import pickle
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import cache
from io import BytesIO
from pathlib import Path
from types import CodeType, EllipsisType, FunctionType, ModuleType
from typing import Any
from uuid import uuid4
from zipfile import ZipFile

import llvmlite
import numba
import numpy as np
from numba import types as types
from numba.core import config
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.core.registry import cpu_target
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs
from numba.np.numpy_support import as_dtype as as_dtype  # for those who declare types

from fuzzy.compiled import notice
from fuzzy.compiled.columns import LOWERING, Columns, check_names

# Whose functions and classes are told by their name: what is in them changes with the versions only.
_LIBRARIES = {"builtins", "cmath", "math", "numba", "numpy", "operator"}
_HASHED = {"fuzzy.compiled.columns", "fuzzy.compiled.vectors"}  # likewise, and whatever changes in their files
_FILES = [Path(__file__).with_name(f"{name.rpartition('.')[2]}.py") for name in sorted(_HASHED)]
# Bytecode is that of a minor version of Python, and Numba asks NumPy for no more than its (major, minor): a patch
# release of either leaves the kernels in use.
_VERSIONS = (
    *(sys.implementation.name, *sys.version_info[:2], *np.__version__.split(".")[:2]),
    *(numba.__version__, llvmlite.__version__, *(hashlib.sha256(file.read_bytes()).hexdigest() for file in _FILES)),
)
_PYTHON = f"py{sys.version_info[0]}{sys.version_info[1]}{getattr(sys, 'abiflags', '')}"  # files of another are its own
_PACKAGED = Path(__file__).with_name("kernels")
_V2 = {"cx16", "crc32", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"}
# What a CPU must have to run the packaged kernels of a baseline, in LLVM's names; the first that it has is taken.
_V3 = _V2 | {"avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"}
BASELINES = {
    "x86-64-v4": _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": _V3,
    "x86-64-v2": _V2,
}
_PLAIN = (bool, int, float, complex, str, bytes, slice, EllipsisType, np.generic, np.dtype)  # told by their repr
_CODE = (
    *("co_code", "co_exceptiontable", "co_flags", "co_names", "co_varnames", "co_freevars", "co_cellvars"),
    *("co_argcount", "co_posonlyargcount", "co_kwonlyargcount"),
)


def kernel(function: Callable[..., Any] | None = None, /, **options: Any) -> Any:
    """Compile a function with Numba when it is first called, and keep its machine code on disk.

    Raises ColumnError, with file and line, where it names a column that the class does not have by which an argument
    is annotated.

    Args:
        function: The function; without it a decorator with these options comes back.
        options: Numba's, beside ``error_model="numpy"`` (a division by zero is infinite and raises nothing).
    """
    if function is None:
        return lambda function: kernel(function, **options)
    said = function.__annotations__.items()
    if known := {name: of for name, of in said if isinstance(of, type) and issubclass(of, Columns)}:
        check_names(function, known)
    # What is put into its callers says so. Without a word of its own a function would take that of the caller for which
    # it is compiled first: the code of a law, twice as large and 3 to 8 % slower, hung on who compiled what before.
    compiled = numba.njit(error_model="numpy", **{"forceinline": False, **options})(function)
    if isinstance(compiled, Dispatcher):
        with suppress(RuntimeError):  # a function that was typed in has no file, and none beside it
            vars(compiled)["_cache"] = KernelCache(compiled)  # as enable_caching() does with Numba's cache
    return compiled


def without_refcounts(function: Callable[..., Any] | None = None, /, **options: Any) -> Any:
    """Compile a function that makes no arrays: it counts no references to those that it is given, and holds no lock.

    Counting the users of some thirty arrays takes several times as long as the inference of a point.

    Args:
        function: The function; without it a decorator with these options comes back.
        options: As of :func:`kernel`.
    """
    return kernel(function, nogil=True, _nrt=False, **options)


def compiled_only(function: Callable[..., Any] | None = None, /, **options: Any) -> Any:
    """Compile as :func:`without_refcounts` a function that only compiled ones call, in a third of the time less.

    It has no entry from Python, where it must not be called.

    Args:
        function: The function; without it a decorator with these options comes back.
        options: As of :func:`kernel`.
    """
    return without_refcounts(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)


class _Nowhere:
    """Where files cannot be kept, as in a container that is read only: what a wheel brings is used there, too."""

    @classmethod
    def from_function(cls, function: Any, file: str) -> "_Nowhere | None":
        return cls() if Path(file).exists() else None

    def get_cache_path(self) -> str:
        return os.devnull

    def get_source_stamp(self) -> int:
        return 0

    def get_disambiguator(self) -> str:
        return ""

    def ensure_cache_path(self) -> None:
        raise OSError


class _Kept(CompileResultCacheImpl):
    _locator_classes = [*CompileResultCacheImpl._locator_classes, _Nowhere]  # type: ignore[list-item]  # noqa: RUF012


class KernelCache(FunctionCache):
    """The machine code of one function on disk: a file for each tuple of argument types, written at once or not at all.

    There is no index: two processes that save at the same time cannot mix up each other's files.
    """

    _impl_class = _Kept

    def __init__(self, compiled: Dispatcher) -> None:
        super().__init__(compiled.py_func)
        self._compiled = compiled
        self._module = Path(self._py_func.__code__.co_filename).stem
        self._function = self._py_func.__qualname__.replace("<", "").replace(">", "")  # no good in a file's name

    def flush(self) -> None:
        """Delete the files of this function."""
        for file, name in self._files():
            if name == self._function:
                file.unlink(missing_ok=True)

    def _load_overload(self, sig: tuple[Any, ...], target_context: Any) -> Any:
        stamp, machine = fingerprint(self._compiled), target_context.codegen().magic_tuple()
        # One's own first: they know all of this CPU, and are what was compiled since.
        packaged = [(archive, _about(stamp, sig, cpu)) for archive, cpu in _packaged(*machine)]
        for about in (_about(stamp, sig, machine), *(about for _, about in packaged)):
            of, reduced = _checked(_content(self._file(stamp, about)), about)
            if of == sig:
                return self._impl.rebuild(target_context, reduced)
        # To unpack takes a while: what was unpacked is a file from then on.
        for archive, about in packaged:
            file = self._file(stamp, about)
            of, reduced = _checked(content := _unpacked(archive).get(file.name, b""), about)
            if of == sig:
                self._write(file, content, stamp)
                return self._impl.rebuild(target_context, reduced)
        notice.compiling()
        return None

    def _save_overload(self, sig: tuple[Any, ...], data: Any) -> None:
        if not self._impl.check_cachable(data):
            return
        stamp = fingerprint(self._compiled)
        about = _about(stamp, sig, data.codegen.magic_tuple())
        # The one text among the parts is the whole source with its types, for people, as long as the machine code.
        reduced = tuple("" if isinstance(part, str) else part for part in self._impl.reduce(data))
        body = dumps((sig, reduced))
        self._write(self._file(stamp, about), with_digest(body, about), stamp)

    def _write(self, file: Path, content: bytes, stamp: str) -> None:
        """Write a file; where that cannot be, the next process compiles anew."""
        part = file.with_name(f"{file.name}.{uuid4().hex}")
        with suppress(OSError):
            self._impl.locator.ensure_cache_path()
            part.write_bytes(content)
            part.replace(file)
            self._delete_old(stamp)

    def _delete_old(self, stamp: str) -> None:
        """Delete the files of other fingerprints, and those of functions that the module no longer has.

        Another process that is still to read one of them compiles anew.
        """
        several = "<locals>" in self._py_func.__qualname__  # a function in a function has many fingerprints at a time
        for file, function in self._files():
            gone = function.partition(".")[0] not in self._py_func.__globals__
            former = function == self._function and not several and stamp[:16] not in file.name
            if gone or former:
                file.unlink(missing_ok=True)

    def _file(self, stamp: str, about: bytes) -> Path:
        kinds = hashlib.sha256(about).hexdigest()[:16]
        return Path(self.cache_path, f"{self._module}.{self._function}-{stamp[:16]}-{kinds}.{_PYTHON}.nbc")

    def _files(self) -> Iterator[tuple[Path, str]]:
        """The files of the functions of this module and their names, Numba's own files of earlier days included."""
        pattern = re.compile(rf"{re.escape(self._module)}\.([^-]+)-[^.]*\.{_PYTHON}(\.\d+)?\.nb[ci]")
        for file in Path(self.cache_path).iterdir():
            if match := pattern.fullmatch(file.name):
                yield file, match[1]


def _about(stamp: str, sig: tuple[Any, ...], cpu: Sequence[str]) -> bytes:
    """What a file is of: fingerprint, types of arguments and CPU. Its digest covers this, too."""
    return repr((stamp, str(sig), [list(_fields(kind)) for kind in sig], *cpu)).encode()


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError:
        return b""


def _checked(content: bytes, about: bytes) -> tuple[Any, Any]:
    """The types and the machine code in a file; None where it is damaged or of something else."""
    body = _intact(content, about)
    return pickle.loads(body) if body else (None, None)


def with_digest(body: bytes, about: bytes = b"") -> bytes:
    """A file's content: a digest of the rest and of what it is ``about``, and the rest."""
    return hashlib.sha256(about + body).digest() + body


def _intact(content: bytes, about: bytes = b"") -> bytes:
    """What follows the digest, or nothing: one flipped bit gives wrong numbers, or ends the process."""
    body = content[hashlib.sha256().digest_size :]
    return body if content == with_digest(body, about) else b""


def _packaged(triple: str, cpu: str, features: str) -> Iterator[tuple[Path, tuple[str, str, str]]]:
    """The archives of kernels that a CPU runs, and what they were compiled for, the best first."""
    for baseline in BASELINES:
        archive = _PACKAGED / f"{baseline}.kernels"
        if _runs(baseline, features) and archive.is_file():
            yield archive, (triple, baseline, "")


def _runs(baseline: str, features: str) -> bool:
    """Whether a CPU of these ``features``, as LLVM lists them, can run the kernels of a baseline."""
    return {f"+{feature}" for feature in BASELINES[baseline]} <= {*features.split(",")}


@cache
def _unpacked(archive: Path) -> dict[str, bytes]:
    """The files in an archive by name; none if it is damaged.

    Compressed as one they take half of what they take one by one: kernels contain what they call.
    """
    if not (body := _intact(_content(archive))):
        return {}
    with ZipFile(BytesIO(lzma.decompress(body))) as files:
        return {name: files.read(name) for name in files.namelist()}


class NotCompiledError(TypeError):
    """Compiled code that calls a function of Python. The message names the file, both functions and what to write."""


def fingerprint(compiled: Dispatcher) -> str:
    """A digest of all that Numba makes a function's machine code of, but the types of its arguments.

    Raises:
        NotCompiledError: The function, or one that it calls, calls a function of Python.
        TypeError: It names something else whose changes cannot be seen.
    """
    number = {compiled: 0}  # the functions in the order in which they are met, which is how they are told apart
    parts: list[Any] = [_VERSIONS, [_value(function.__code__, {}) for function in LOWERING]]
    queue = [compiled]
    for function in queue:
        parts.append(_description(function, number))
        queue += list(number)[len(queue) :]
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def _description(compiled: Dispatcher, number: dict[Dispatcher, int]) -> Any:
    function = compiled.py_func
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    options = sorted(compiled.targetoptions.items())
    try:
        parts = [_value(v, number) for v in (function.__code__, cells, function.__defaults__, options)]
        return [function.__module__, *parts, *_named(function, number)]  # machine code imports the module by its name
    except NotCompiledError:
        raise
    except TypeError as error:
        raise TypeError(f"{function.__module__}.{function.__qualname__} cannot be kept on disk: {error}") from None


def _named(function: Any, number: dict[Dispatcher, int]) -> Iterator[Any]:
    """What stands for the globals that a function names."""
    for name, value in _globals(function.__code__, function.__globals__):
        try:
            yield [name, _value(value, number)]
        except TypeError:
            # A column may bear the name of something that the function does not use.
            if any(s.opname == "LOAD_GLOBAL" and s.argval == name for s in dis.get_instructions(function)):
                if isinstance(value, FunctionType):
                    raise NotCompiledError(
                        f"{function.__code__.co_filename}: {function.__qualname__} calls {name}, a function of Python; "
                        "put @compiled_only of fuzzy.compiled.jit above it, so that it is compiled too"
                    ) from None
                raise


def _globals(code: CodeType, names: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """The globals that a function may read, those of modules included. (A name may be of an attribute only.)"""
    for name in code.co_names:
        if name in names:
            if isinstance(names[name], ModuleType) and not _of_a_library(names[name].__name__):
                inside = vars(names[name])
                yield from ((f"{name}.{inner}", inside[inner]) for inner in code.co_names if inner in inside)
            else:
                yield name, names[name]
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _globals(inner, names)


def _value(value: Any, number: dict[Dispatcher, int]) -> Any:
    """What stands for a value in a fingerprint: equal for values of which Numba makes the same code."""
    if value is None or isinstance(value, _PLAIN):
        return repr(value)
    if isinstance(value, (tuple, list)):
        return [type(value).__qualname__, *getattr(value, "_fields", ()), *(_value(v, number) for v in value)]
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest = hashlib.sha256(value.tobytes()).hexdigest()
        return [repr(value.dtype), value.shape, value.strides, digest]
    if isinstance(value, Dispatcher):
        return number.setdefault(value, len(number))
    if isinstance(value, CodeType):
        return [*(getattr(value, name) for name in _CODE), _value(value.co_consts, number)]
    if isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
        return [value.__qualname__, value._fields, *(_value(v, number) for v in value.__new__.__defaults__ or ())]
    if isinstance(value, type) and hasattr(value, "layout"):  # of fuzzy.compiled.columns
        return repr(value.layout)
    if isinstance(value, np.ufunc):
        return f"numpy.{value.__name__}"
    if isinstance(value, ModuleType) and _of_a_library(value.__name__):
        return value.__name__
    home = str(getattr(value, "__module__", None))
    if _of_a_library(home):
        return f"{home}.{getattr(value, '__qualname__', value)}"
    raise TypeError(f"a change of {value!r} would go unseen")


def _of_a_library(module: str) -> bool:
    return module.partition(".")[0] in _LIBRARIES or module in _HASHED


def _fields(kind: Any) -> Iterator[str]:
    """The fields of the named tuples in a type, and where their classes stand: Numba tells the names of these alone."""
    yield from (str(getattr(kind, "instance_class", "")), *getattr(kind, "fields", ()))
    for inner in (*getattr(kind, "types", ()), getattr(kind, "dtype", None), getattr(kind, "type", None)):
        if inner is not None:
            yield from _fields(inner)


def baselines() -> dict[str, tuple[int, bool]]:
    """The number of kernels that came with this installation, by baseline, and whether this CPU can run them."""
    *_, features = cpu_target.target_context.codegen().magic_tuple()
    counts = {baseline: len(_unpacked(_PACKAGED / f"{baseline}.kernels")) for baseline in BASELINES}
    return {baseline: (count, _runs(baseline, features)) for baseline, count in counts.items()}


def kept(folders: Sequence[Path]) -> dict[str, int]:
    """How many kernels were compiled or unpacked here for this Python, by the folder below which they lie.

    Args:
        folders: The packages with compiled functions, beside whose files caches lie if they can.
    """
    set_by_hand: str = config.CACHE_DIR  # type: ignore[attr-defined]
    chosen = [Path(set_by_hand)] if set_by_hand else [*folders, Path(AppDirs("numba").user_cache_dir)]
    counts = {str(folder): sum(1 for _ in folder.rglob(f"*.{_PYTHON}.nbc")) for folder in chosen if folder.is_dir()}
    return {folder: count for folder, count in counts.items() if count}
