"""The command ``fuzzy doctor``: what is installed, what is compiled, and what stands in the way."""

import sys
from typing import Any

import typer

from fuzzy.shell.options import Json
from fuzzy.shell.terminal import FAILED, print_json

_OWN = "fuzzyfleet"
_OURS = ("fuzzy", "anfis", "robotics", "_fuzzyfleet")
# What the extras are for that are not for development
EXTRAS = {
    "certify": "robotics certify: how fast and from where a law provably converges",
    "cluster": "studies, sweeps and stress tests on a cluster: --dask",
    "control": "rule bases in block diagrams of python-control",
    "design": "the designer: fuzzy design",
    "front": "rules from nothing: fuzzy front",
    "gym": "environments of Gymnasium and PettingZoo",
    "logs": "rosbag2 folders, written and read",
    "mujoco": "robotics run --plant mujoco: another physics, with contacts and friction",
    "notebook": "the designer and the player in notebooks",
    "rl": "policies learnt by reinforcement: robotics reinforce",
    "ros": "the nodes for ROS 2 in the folder ros/ of the sources",
    "sklearn": "anfis.ANFISRegressor in pipelines of scikit-learn",
    "video": "films as .mp4: robotics animate",
}


def doctor(json: Json = False) -> None:
    """Tell what is installed and what is compiled, and whether something is wrong with it.

    It shows versions, optional packages and what they are for, threads, compiled kernels, and other distributions that
    install packages of these names. The exit code is 1 if something is wrong.

    \b
    Example:
      fuzzy doctor
      fuzzy doctor --json > installed.json
    """
    found = _examined()
    if json:
        print_json({"ok": not found["faults"], **found})
    else:
        _print(found)
    if found["faults"]:
        raise typer.Exit(FAILED)


def _examined() -> dict[str, Any]:
    import platform
    from importlib.metadata import PackageNotFoundError, requires, version

    import _fuzzyfleet
    from fuzzy.extras import install_command, needed

    read = needed("packaging.requirements", "fuzzy doctor").Requirement
    try:
        own, lines = version(_OWN), requires(_OWN) or []
    except PackageNotFoundError:  # a bare folder of sources
        own, lines = "", []
    asked = [(read(line), line) for line in lines]
    packages = [_package(asks) for asks, line in asked if "extra ==" not in line]
    extras = []
    for extra, purpose in EXTRAS.items():
        of = [_package(asks) for asks, line in asked if "extra ==" in line and asks.marker.evaluate({"extra": extra})]
        if of:
            ready = all(each["fine"] for each in of)
            install = "" if ready else install_command(extra)
            extras.append({"name": extra, "purpose": purpose, "installed": ready, "packages": of, "install": install})
    faults = [sentence for _, sentence in _fuzzyfleet.troubles()]
    faults += [] if own else [f"no distribution {_OWN} is installed: commands of plug-ins are not found"]
    for each in packages:
        if not each["fine"]:
            is_there = f"{each['version']} is too old" if each["version"] else "is not installed"
            faults.append(f"{each['name']} {is_there}: pip install '{each['name']}{each['asked']}'")
    return {
        "version": own,
        "python": platform.python_version(),
        "implementation": platform.python_implementation(),
        "platform": platform.platform(),
        "executable": sys.executable,
        "packages": packages,
        **_compiled(packages),
        "extras": extras,
        "faults": [*faults, *_changed_files()],
    }


def _package(asks: Any) -> dict[str, Any]:
    """What is there of a package that is asked for."""
    from importlib.metadata import distributions

    found = next((each.version for each in distributions(name=asks.name)), "")
    fine = bool(found) and asks.specifier.contains(found, prereleases=True)
    return {"name": asks.name, "asked": str(asks.specifier), "version": found, "fine": fine}


def _compiled(packages: list[dict[str, Any]]) -> dict[str, Any]:
    """Processor, threads and kernels, as far as the packages are there that know them."""
    from importlib.util import find_spec
    from pathlib import Path

    from fuzzy.compiled.threads import processors

    threads: dict[str, Any] = {"processors": processors()}
    if not all(each["fine"] for each in packages if each["name"] in ("numba", "numpy", "threadpoolctl")):
        return {"baseline": "", "threads": threads, "kernels": {}}
    from threadpoolctl import threadpool_info

    from fuzzy.compiled.jit import baselines, kept

    threads |= {each["internal_api"]: each["num_threads"] for each in threadpool_info()}
    shipped = baselines()
    folders = [Path(str(spec.origin)).parent for name in _OURS[:3] if (spec := find_spec(name))]
    return {
        "baseline": next((name for name, (_, runs) in shipped.items() if runs), ""),
        "threads": threads,
        "kernels": {"shipped": {name: count for name, (count, _) in shipped.items()}, "kept": kept(folders)},
    }


def _changed_files() -> list[str]:
    """Files of ours that are no longer as they were installed, or gone, in a sentence."""
    import hashlib
    from base64 import urlsafe_b64encode
    from importlib.metadata import distributions
    from pathlib import Path

    changed = []
    for file in next((each.files or [] for each in distributions(name=_OWN)), []):
        if file.parts[0].partition(".")[0] not in _OURS:  # commands and descriptions are the installer's
            continue
        path = Path(str(file.locate()))
        digest = hashlib.sha256(path.read_bytes()).digest() if path.is_file() else b""
        if file.hash is not None and urlsafe_b64encode(digest).decode().rstrip("=") != file.hash.value:
            changed.append(str(file))
    if not changed:
        return []
    named = ", ".join(changed[:3]) + (" and others" if len(changed) > 3 else "")
    return [f"files are not as they were installed, {named}: pip install --force-reinstall {_OWN} --no-deps"]


def _print(found: dict[str, Any]) -> None:
    print(f"fuzzyfleet {found['version'] or 'of a folder'}, {found['implementation']} {found['python']}")
    print(f"{found['platform']}, {found['executable']}")
    print("threads: " + ", ".join(f"{name} {count}" for name, count in found["threads"].items()))
    if found["kernels"]:
        shipped, kept = found["kernels"]["shipped"], found["kernels"]["kept"]
        print(f"processor: {found['baseline'] or 'none of ' + ', '.join(shipped)}")
        print("kernels that came with it: " + ", ".join(f"{count} for {name}" for name, count in shipped.items()))
        print("kernels unpacked or compiled: " + (", ".join(f"{n} below {f}" for f, n in kept.items()) or "none"))
    print("packages: " + ", ".join(f"{each['name']} {each['version'] or 'missing'}" for each in found["packages"]))
    print("extras:")
    for each in found["extras"]:
        print(f"  {each['name']:<9}{each['purpose']}{': ' if each['install'] else ''}{each['install']}")
    print("\n".join(found["faults"]) or "nothing is wrong")
