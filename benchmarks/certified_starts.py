"""Starts in a certified region, by the simulator's plant: `python benchmarks/certified_starts.py [STARTS]`.

Prints the greatest V of any sample of any start over that on the region's boundary, on which half of the starts lie,
and how many starts left it, with the exact 95 % bound of their share.
"""

import sys
import time

from robotics.measures.statistics.intervals import clopper_pearson
from robotics.plugins.certificates.commandstates import certified
from robotics.plugins.certificates.loopmodel import LoopModel, closed_loop
from robotics.plugins.certificates.regions import FULL_EFFORT
from robotics.plugins.certificates.starts import simulate_starts
from robotics.simulation.scenario.robots import load_robot

STARTS = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
PIECE = 5_000
MODELS = (LoopModel(), LoopModel(speed_low=0.2, position_noise=0.002, heading_noise=0.005))


def main() -> None:
    """Certify, drive and print."""
    robot = load_robot("etsro").robot
    for law in ("fuzzy-correcting:smooth=0", "lyapunov"):
        for model in MODELS:
            began = time.perf_counter()
            found, why = certified(closed_loop(law, robot, model), FULL_EFFORT)
            if found is None:
                print(f"{law}: not certified: {why}")
                continue
            print(f"{law}: half widths {found.half_widths().round(4)}, {time.perf_counter() - began:.0f} s")
            began, greatest, left = time.perf_counter(), 0.0, 0
            for seed in range(-(-STARTS // PIECE)):
                seen = simulate_starts(found, robot, min(PIECE, STARTS), duration=5.0, seed=seed)
                greatest, left = max(greatest, float(seen.greatest.max())), left + int((seen.greatest > 1 + 1e-9).sum())
            most = float(clopper_pearson(left, STARTS).high)
            print(f"  {STARTS} starts: greatest V {greatest:.6f} of the region's, {left} left it (at most {most:.2g})")
            print(f"  {time.perf_counter() - began:.0f} s")


if __name__ == "__main__":
    main()
