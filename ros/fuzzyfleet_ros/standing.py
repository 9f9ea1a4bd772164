"""Why a robot must stand: odometry or a reading that is missing or old. The clock is one that nobody can stop."""

from collections.abc import Callable, Sequence
from math import inf

_QUIET = 5.0  # s without a message that is ignored: the next one is said again


class CommandWatchdog:
    """The watchdog of a controller: what came when, and whether the robot stands."""

    def __init__(self, odom_timeout: float, range_timeout: float, clock: Callable[[], float]) -> None:
        """Both timeouts are in seconds, and 0 means never; ``clock`` gives the present time [s]."""
        self.odom_timeout, self.range_timeout, self.clock = odom_timeout, range_timeout, clock
        self.odometry: dict[str, float] = {}  # s: when it came last, "" this robot's, or another's by its name
        self.readings: dict[str, float] = {}  # s: when each range sensor's came last
        self.stamps: dict[str, float] = {}  # s: of the last message that counted, by what it is
        self.refusals: dict[str, float] = {}  # s: when a message was ignored last, by what it is
        self.why = ""  # it stands; "": it drives
        self.said: set[str] = set()  # why it stood, since it drove last
        self.since = 0.0  # s

    def refusal(self, what: str, stamp: float, now: float, most: float = inf) -> str:
        """Why a message is ignored, in words; nothing: it counts.

        A driver that repeats its last message, or whose clock is another, would let the robot drive blind.

        Args:
            what: What it is, of which there are many.
            stamp: When it was made [s].
            now: The present time by the same clock [s]; 0: not known yet.
            most: By how much [s] it may be older; it may be as much newer, but by no more than ``odom_timeout``.
        """
        if stamp <= 0:  # as in a message that nobody filled in
            return "its stamp is not set"
        if stamp <= self.stamps.get(what, -inf):
            return f"its stamp, {stamp:.9g} s, does not move on"
        if now > 0 and (now - stamp > most or stamp - now > min(most, self.odom_timeout or inf)):
            return f"its stamp is {abs(now - stamp):.3g} s {'behind' if stamp < now else 'ahead of'} the clock here"
        self.stamps[what] = stamp
        return ""

    def refused(self, what: str) -> bool:
        """Note that a message is ignored now; return whether to say it: not again before 5 s without one of these.

        A driver that sends each message twice would otherwise be named as often as it sends.
        """
        before, self.refusals[what] = self.refusals.get(what, -inf), self.clock()
        return self.clock() - before > _QUIET

    def odometry_came(self, robot: str = "") -> None:
        """Note that odometry came now, of this robot, or of another ``robot`` whose place its law reads."""
        self.odometry[robot] = self.clock()

    def reading_came(self, name: str) -> None:
        """Note that a range sensor's reading came now."""
        self.readings[name] = self.clock()

    def odometry_is_old(self) -> str:
        """Why the robot must stand for want of odometry, in words; nothing: it need not."""
        if "" not in self.odometry:
            return "no odometry has come yet"
        for robot, came in self.odometry.items():
            if 0 < self.odom_timeout < self.clock() - came:
                whose = f"the odometry of {robot}" if robot else "its odometry"
                return f"{whose} is older than {self.odom_timeout:g} s"
        return ""

    def reason(self, needs: Sequence[str] = ()) -> str:
        """Why the robot must stand, in words; nothing: it may drive. ``needs`` are the range sensors of its law."""
        if old := self.odometry_is_old():
            return old
        for name in needs if self.range_timeout else ():
            if name not in self.readings:
                return f"no reading of {name} has come yet"
            if self.clock() - self.readings[name] > self.range_timeout:
                return f"the reading of {name} is older than {self.range_timeout:g} s"
        return ""

    def stands(self, why: str) -> bool:
        """Note that the robot stands; return whether to say why: once for each reason, until it drives again."""
        new, self.since = why not in self.said, self.since if self.why else self.clock()
        self.why = why
        self.said.add(why)
        return new

    def moves(self) -> str:
        """Note that the robot drives; return a sentence if it stood."""
        if not self.why:
            return ""
        self.why = ""
        self.said.clear()
        return f"the robot drives on after {self.clock() - self.since:.2g} s"
