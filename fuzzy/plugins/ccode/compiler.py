"""The C compiler of this machine: found, asked with all its warnings, and what it made run."""

import os
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from fuzzy.errors import InputError

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wconversion")
SANITIZERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer")
_TIME = 600  # s, after which a compiler or a program is given up


class CompilerError(InputError):
    """The error where no C compiler is there, and for C that it refuses or that fails when it runs."""


@dataclass(frozen=True)
class Compiler:
    """A command that compiles C, and what it calls itself."""

    command: tuple[str, ...]
    version: str

    def compile(self, sources: list[Path], target: Path, *flags: str) -> Path:
        """Compile ``sources`` into ``target`` with all warnings as errors. Raises CompilerError with what it says."""
        line = [*self.command, *STRICT, *flags, *map(str, sources), "-o", str(target), "-lm"]
        done = subprocess.run(line, capture_output=True, text=True, check=False, timeout=_TIME)
        if done.returncode != 0:
            raise CompilerError(f"{self.version} refuses {sources[0].name}: {_first_lines(done.stderr)}")
        return target

    def sanitizes(self, folder: Path) -> bool:
        """Whether it has the address and undefined-behaviour sanitizers, with their libraries."""
        probe = folder / "probe.c"
        probe.write_text("int main(void) { return 0; }\n", encoding="utf-8")
        try:
            return run_program(self.compile([probe], folder / "probe", *SANITIZERS)) == ""
        except CompilerError:
            return False


def run_program(program: Path, *arguments: str) -> str:
    """Run what was compiled, and return what it printed. Raises CompilerError where it fails, with what it says."""
    done = subprocess.run([str(program), *arguments], capture_output=True, text=True, check=False, timeout=_TIME)
    if done.returncode != 0:
        raise CompilerError(f"{program.name} ended with {done.returncode}: {_first_lines(done.stderr)}")
    return done.stdout


def find_compiler() -> Compiler:
    """The compiler that CC names, or else cc, gcc or clang. Raises CompilerError where there is none."""
    named = os.environ.get("CC", "")
    found = _found(named)
    if found is None:
        what = f"CC names {named!r}, which is not there" if named else "there is no cc, gcc or clang"
        raise CompilerError(f"no C compiler: {what}; install one (Debian: apt install gcc), or leave --verify out")
    return found


@cache
def _found(named: str) -> Compiler | None:
    for command in [shlex.split(named)] if named else [["cc"], ["gcc"], ["clang"]]:
        if command and shutil.which(command[0]):
            said = subprocess.run([*command, "--version"], capture_output=True, text=True, check=False, timeout=60)
            return Compiler(tuple(command), said.stdout.partition("\n")[0].strip() or command[0])
    return None


def _first_lines(text: str, count: int = 6) -> str:
    lines = [line for line in text.strip().splitlines() if line.strip()]
    return "\n  ".join(lines[:count]) or "it says nothing"
