"""What ``make release`` does beside building.

``python -m release check`` refuses what is not ready, ``try`` installs the wheel into an empty environment and uses it
without compiler and network, ``notes`` writes what people read, and ``oldest`` prints the oldest versions that
``pyproject.toml`` allows.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
import venv
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PLACEHOLDER = ".invalid"  # a domain that there never is: RFC 2606
# Older ones come from the index with CUDA only, some gigabytes: what is tested instead.
NOT_THE_OLDEST = {"torch": "2.13.0"}
TRIED = (
    ("fuzzy", "doctor"),
    ("fuzzy", "example", "tipper"),
    ("fuzzy", "show", "tipper.fis"),
    ("anfis", "--version"),
    ("robotics", "run", "lyapunov-sine", "--plot", "sine.png"),
)


def main() -> int:
    """Do one step; 1 if something is not ready or does not work."""
    asks = argparse.ArgumentParser(prog="python -m release", description="The steps of a release, beside building.")
    asks.add_argument("step", choices=["check", "try", "notes", "oldest"])
    asks.add_argument("--rehearsal", action="store_true", help="check: say what is not ready, and go on")
    asked = asks.parse_args()
    if asked.step == "check":
        found = faults(ROOT) + _uncommitted()
        print("\n".join(found) or "ready")
        return int(bool(found) and not asked.rehearsal)
    if asked.step == "oldest":
        print("\n".join(oldest(project(ROOT)["dependencies"])))
        return 0
    version, dist = project(ROOT)["version"], ROOT / "dist"
    if asked.step == "notes":
        file = dist / f"fuzzyfleet-{version}.md"
        file.write_text(notes((ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), version), encoding="utf-8")
        print(file.relative_to(ROOT))
        return 0
    return _try(version, dist)


def project(root: Path) -> dict[str, Any]:
    """The table ``[project]`` of ``pyproject.toml``."""
    found: dict[str, Any] = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return found


def faults(root: Path) -> list[str]:
    """What must be mended before a release, a sentence each."""
    about, found = project(root), []
    for name, url in about["urls"].items():
        if PLACEHOLDER in url:
            found.append(f"pyproject.toml: {name} is a placeholder, {url}")
    for file in ("SECURITY.md", "CODE_OF_CONDUCT.md", "recipe/recipe.yaml", ".github/ISSUE_TEMPLATE/config.yml"):
        if PLACEHOLDER in (root / file).read_text(encoding="utf-8"):
            found.append(f"{file}: has a placeholder, an address that ends in {PLACEHOLDER}")
    for file, pattern in (("CITATION.cff", r"(?m)^version: (.+)$"), ("recipe/recipe.yaml", r'(?m)^  version: "(.+)"$')):
        (version,) = re.findall(pattern, (root / file).read_text(encoding="utf-8"))
        if version != about["version"]:
            found.append(f"{file}: the version is {version}, that of pyproject.toml {about['version']}")
    newest = re.findall(r"(?m)^## (.+)$", (root / "CHANGELOG.md").read_text(encoding="utf-8"))[0]
    if newest.partition(" ")[0] != about["version"]:
        found.append(f"CHANGELOG.md: begins with {newest}, not with {about['version']} and its date")
    return found


def notes(changelog: str, version: str) -> str:
    """The section of a version, as a page of its own. Raises ValueError if there is none."""
    section = re.search(rf"(?ms)^## ({re.escape(version)}\b[^\n]*)\n(.*?)(?=^## |\Z)", changelog)
    if section is None:
        raise ValueError(f"CHANGELOG.md has no section {version}")
    return f"# Fuzzyfleet {section[1]}\n\n{section[2].strip()}\n"


def oldest(dependencies: list[str]) -> list[str]:
    """The lower bounds as constraints for pip. Raises ValueError for a requirement that has none, or an upper one."""
    lines = []
    for line in dependencies:
        bound = re.fullmatch(r"([\w-]+)>=([\w.]+)", line)
        if bound is None:
            raise ValueError(f"{line}: must be a name, >= and a version; an upper bound needs a reason and a test")
        lines.append(f"{bound[1]}=={NOT_THE_OLDEST.get(bound[1], bound[2])}")
    return lines


def _uncommitted() -> list[str]:
    done = subprocess.run(["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, text=True, check=False)
    return [f"not committed: {line[3:]}" for line in done.stdout.splitlines()]


def _try(version: str, dist: Path) -> int:
    """Install what was built where nothing is, use it, and list what came along."""
    folder = ROOT / "build" / "release"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "empty").mkdir(parents=True)
    pip, wheels = [sys.executable, "-m", "pip", "--disable-pip-version-check", "-q"], folder / "wheels"
    (pure,) = dist.glob(f"fuzzyfleet-{version}-py3-none-any.whl")
    load: list[Any] = [*pip, "download", "-c", ROOT / "constraints.txt", "-d", wheels, pure]
    subprocess.run(load, check=True)
    venv.create(folder / "venv", with_pip=False)
    bin_ = folder / "venv" / "bin"
    apart = _without_network()
    print("with nothing but what was downloaded", "and no network" if apart else "(the network cannot be cut off here)")
    links: list[Any] = ["--no-index", "--find-links", dist, "--find-links", wheels]
    subprocess.run([*apart, *pip, "--python", bin_ / "python", "install", *links, f"fuzzyfleet=={version}"], check=True)
    bare = {"PATH": str(bin_), "HOME": str(folder / "empty"), "CC": "none", "CXX": "none"}  # where no compiler is found
    failed = 0
    for program, *words in TRIED:
        began = time.monotonic()
        command: list[Any] = [*apart, bin_ / program, *words]
        done = subprocess.run(command, cwd=folder / "empty", env=bare, capture_output=True, text=True, check=False)
        failed += done.returncode != 0
        print(f"{time.monotonic() - began:5.1f} s  {program} {' '.join(words)}: {done.returncode}")
        if done.returncode:
            print(done.stdout[-2000:] + done.stderr[-2000:])
    parts = ["environment", "--output-reproducible", "--of", "JSON", "-o", dist / f"fuzzyfleet-{version}.cdx.json"]
    tell: list[Any] = [
        sys.executable,
        "-m",
        "cyclonedx_py",
        *parts,
        "--pyproject",
        ROOT / "pyproject.toml",
        bin_ / "python",
    ]
    subprocess.run(tell, check=True)
    return int(bool(failed))


def _without_network() -> list[str]:
    """What a command begins with so that it has no network; nothing where that is not allowed."""
    words = [shutil.which("unshare") or "", "--map-root-user", "--net", "--"]
    able = (
        words[0] and subprocess.run([*words, "true"], capture_output=True, env=os.environ, check=False).returncode == 0
    )
    return words if able else []


if __name__ == "__main__":
    sys.exit(main())
