"""Which topic of a log is which: of which robot, and its odometry, its commands, its reference, its path."""

from collections.abc import Sequence
from typing import NamedTuple

from fuzzy.naming import expected
from robotics.plugins.logs.bag import Bag, Topic
from robotics.plugins.logs.typestore import LogError

ODOMETRY = "nav_msgs/Odometry"


def namespaces(bag: Bag) -> list[str]:
    """The namespaces in which there is odometry; "" is none."""
    found = {t.name.rpartition("/")[0].strip("/") for t in bag.topics if t.kind == ODOMETRY}
    return sorted(found)


def namespace_of(bag: Bag, robot: str) -> str:
    """The namespace that is meant. Raises LogError."""
    found = namespaces(bag)
    if robot:
        if not any(topic.name.startswith(f"/{robot}/") for topic in bag.topics):
            known = [name for name in found if name] or ["none: leave it out"]
            raise LogError(f"{bag.path}: " + expected(robot, known, "robot"))
        return robot
    if "" in found or not found:
        return ""
    if len(found) > 1:
        raise LogError(f"{bag.path}: several robots drive there; choose one with --robot: {', '.join(found)}")
    return found[0]


class TopicsOf(NamedTuple):
    """The topics of one robot."""

    bag: Bag
    space: str

    def topic(
        self,
        named: str,
        what: str,
        kinds: Sequence[str],
        usual: Sequence[str],
        *,
        needed: bool = True,
        only: bool = True,
        without: Sequence[str] = (),
    ) -> Topic | None:
        """The topic that is meant; None where there is none and none is needed. Raises LogError.

        Args:
            named: As the user names it; "": not at all.
            what: What it is, for messages.
            kinds: The types that it may have.
            usual: The names that it has by custom.
            needed: Whether there must be one.
            only: Whether the only one of its kind is taken whatever its name.
            without: Names that are something else.
        """
        bag, begin = self.bag, f"/{self.space}/" if self.space else "/"
        if named:
            wanted = [t for t in bag.topics if t.name in (named, f"/{named}", f"{begin}{named}")]
            if not wanted:
                raise LogError(f"{bag.path}: there is no topic {named}; {bag.said()}")
            fit = [t for t in wanted if t.kind in kinds]
            if not fit:
                raise LogError(
                    f"{bag.path}: {named} is of {wanted[0].kind}, and {what} must be of {' or '.join(kinds)}; "
                    f"{bag.said()}"
                )
            return fit[0]
        mine = [t for t in bag.topics if t.kind in kinds and t.name.startswith(begin)]
        mine = [t for t in mine if t.name.removeprefix(begin) not in without]
        for name in usual:
            called = [t for t in mine if t.name == f"{begin}{name}"]
            if called:
                return max(called, key=lambda topic: topic.messages)
        inside = [t for t in mine if only and (self.space or "/" not in t.name[1:])] or (mine if only else [])
        if len(inside) == 1:
            return inside[0]
        if not needed:
            return None
        if inside:
            several = ", ".join(t.name for t in inside)
            raise LogError(f"{bag.path}: which topic is the {what}: {several}? Name it")
        raise LogError(f"{bag.path}: there is no {what}, a topic of {' or '.join(kinds)}; {bag.said()}")
