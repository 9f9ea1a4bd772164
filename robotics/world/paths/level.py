"""Level places: who of a formation stands beside whom, on paths of any shape, also closed ones.

Robots are level with each other at equal shares of their ways. In a formation by offsets
(:mod:`robotics.world.paths.offset`) the share is that of the virtual path; on other paths it is that of a robot's own
path from where its reference begins, σ = (s − s_0)/(length − s_0), which goes on below 0 on what lies before.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robotics.world.paths.joined import PathTable
from robotics.world.paths.references import References


@dataclass(frozen=True, eq=False)
class Level:
    """The level places of robots; robot 1, the first in every array, leads."""

    joined: PathTable
    begin: np.ndarray  # m, as the table's lengths: the abscissae at which the references begin

    @classmethod
    def of(cls, references: References) -> "Level":
        """The level places on the paths of ``references``."""
        return cls(references.joined, references.at(-references.road.since).s)

    @cached_property
    def _leader_nodes(self) -> np.ndarray:
        """The abscissae of the nodes of the leader's path [m]."""
        return np.linspace(0.0, float(self.joined.lengths[0]), int(self.joined.cells[0]) + 1)

    def share(self, s: np.ndarray) -> np.ndarray:
        """The shares of the ways, of robots at the abscissae ``s`` (..., robots) [m]."""
        if self.joined.shares is not None:
            return self.joined.share(s)
        return np.asarray((s - self.begin) / (self.joined.lengths - self.begin))

    def place(self, share: np.ndarray) -> np.ndarray:
        """The abscissae [m] of all robots at the shares ``share`` (..., robots); what :meth:`share` inverts."""
        if self.joined.shares is not None:
            return self.joined.place(share)
        return np.asarray(self.begin + share * (self.joined.lengths - self.begin))

    def on_leader(self, s: np.ndarray) -> np.ndarray:
        """The abscissae [m] on the leader's path that are level with robots at ``s`` (..., robots) [m]."""
        share = self.share(s)
        if self.joined.shares is not None:
            shares = self.joined.shares[0][0]
            return np.interp(share, shares, self._leader_nodes)
        begin, length = self.begin[..., :1], self.joined.lengths[..., :1]
        return np.asarray(begin + share * (length - begin))

    def stretch(self, s: np.ndarray) -> np.ndarray:
        """The way on each robot's path for each metre of the leader's, of robots at ``s`` (..., robots) [m]."""
        if self.joined.shares is not None:
            share = self.joined.share(s)
            return np.asarray(self.joined.stretch(share) / np.interp(share, *self.joined.shares[0]))
        ways = self.joined.lengths - self.begin
        return np.broadcast_to(ways / ways[..., :1], np.shape(s))
