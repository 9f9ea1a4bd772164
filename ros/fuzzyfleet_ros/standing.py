"""Why a robot must stand: odometry or a reading that is missing or old. The clock is one that nobody can stop."""

from collections.abc import Callable, Sequence


class CommandWatchdog:
    """The watchdog of a controller: what came when, and whether the robot stands."""

    def __init__(self, odom_timeout: float, range_timeout: float, clock: Callable[[], float]) -> None:
        """Both timeouts are in seconds, and 0 means never; ``clock`` gives the present time [s]."""
        self.odom_timeout, self.range_timeout, self.clock = odom_timeout, range_timeout, clock
        self.odometry: float | None = None  # s: when it came last
        self.readings: dict[str, float] = {}  # s: when each range sensor's came last
        self.why = ""  # it stands; "": it drives
        self.since = 0.0  # s

    def odometry_came(self) -> None:
        """Note that odometry came now."""
        self.odometry = self.clock()

    def reading_came(self, name: str) -> None:
        """Note that a range sensor's reading came now."""
        self.readings[name] = self.clock()

    def odometry_is_old(self) -> str:
        """Why the robot must stand for want of odometry, in words; nothing: it need not."""
        if self.odometry is None:
            return "no odometry has come yet"
        age = self.clock() - self.odometry
        return f"its odometry is older than {self.odom_timeout:g} s" if 0 < self.odom_timeout < age else ""

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
        """Note that the robot stands; return whether that is new."""
        new, self.since = why != self.why, self.since if self.why else self.clock()
        self.why = why
        return new

    def moves(self) -> str:
        """Note that the robot drives; return a sentence if it stood."""
        if not self.why:
            return ""
        self.why = ""
        return f"the robot drives on after {self.clock() - self.since:.2g} s"
