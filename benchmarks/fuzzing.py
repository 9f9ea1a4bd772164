"""Damaged and hostile files against every reader: what is refused, what is accepted and usable, what else comes out.

    python -m benchmarks.fuzzing --mutations 20000 --border fis --border run

Each mutation is made of its seed and number alone: ``--only NUMBER --keep FILE`` writes one that is to be looked at.
Ends with 1 if anything but a sentence came out.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from tests.fuzzing.borders import BORDERS, assault, kinds
from tests.fuzzing.mutation import mutated


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mutations", type=int, default=2000, help="how many for each border (2000)")
    parser.add_argument("--seed", type=int, default=0, help="the seed of the mutations (0)")
    parser.add_argument("--border", action="append", choices=sorted(BORDERS), help="only this border; may be repeated")
    parser.add_argument("--only", type=int, metavar="NUMBER", help="only this mutation")
    parser.add_argument("--keep", type=Path, metavar="FILE", help="with --only: write the mutated file")
    options = parser.parse_args()
    names = options.border or sorted(BORDERS)
    if options.keep:
        border = BORDERS[names[0]]
        rng = np.random.default_rng([options.seed, options.only or 0])
        options.keep.write_bytes(mutated(rng, border.corpus(), border.mutations))
    numbers = range(options.mutations) if options.only is None else range(options.only, options.only + 1)
    print(
        f"{'border':10} {'mutations':>9} {'accepted':>9} {'refused':>9} {'escaped':>9} {'slowest, cpu':>14} {'wall':>8}"
    )
    escaped = 0
    for name in names:
        tally = assault(BORDERS[name], options.seed, numbers)
        escaped += len(tally.escaped)
        print(
            f"{name:10} {len(numbers):9} {tally.accepted:9} {tally.refused:9} {len(tally.escaped):9} "
            f"{tally.slowest:7.2f} s #{tally.slowest_number:<4}",
            flush=True,
        )
        first = {what: number for number, what in reversed(tally.escaped)}
        for what, count in kinds(tally).most_common():
            print(f"    {count} x {what}, first #{first[what]}")
    return 1 if escaped else 0


if __name__ == "__main__":
    sys.exit(main())
