"""A hook of hatchling: with ``FUZZYFLEET_KERNELS=<folder>`` the wheel is a platform's, and brings the kernels in it.

Without, it is the pure wheel, whose kernels are compiled where they run.
"""

import os
import platform
import sys
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Kernels(BuildHookInterface):  # type: ignore[type-arg]
    """Puts compiled kernels into a wheel, and names the Python and the platform that they run on."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the kernels, and the tag of the wheel."""
        folder = os.environ.get("FUZZYFLEET_KERNELS")
        if not folder or version != "standard":
            return
        machine = platform.machine()
        if (sys.platform, machine, sys.implementation.name) != ("linux", "x86_64", "cpython"):
            raise RuntimeError(f"no kernels are shipped for {sys.platform} {machine}")
        # Their entries from Python are of this CPython's ABI; the libraries that they need are those of Numba's wheels.
        python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
        build_data["pure_python"] = False
        build_data["tag"] = f"{python}-{python}{sys.abiflags}-manylinux_2_17_{machine}"
        build_data["force_include"][folder] = "fuzzy/compiled/kernels"
