"""A law with an emergency rule whose share can be computed by hand."""

from dataclasses import dataclass

import numpy as np

from robotics.laws.law import Command, Law


@dataclass(frozen=True)
class Guarded(Law[None]):
    """Drives straight ahead at 0.2 m/s; its rule acts in every odd second: [1, 2), [3, 4), ..."""

    def init(self, setting, runs):
        return None

    def control(self, seen, memory, dt):
        v, w = np.full_like(seen.x, 0.2), np.zeros_like(seen.x)
        odd = int(seen.time + 1e-9) % 2 == 1
        return Command(v, w, v, w, guarded=np.full(seen.x.shape, odd)), None
