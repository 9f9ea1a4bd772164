"""Imitation: a rule base that does what a law does, learnt from the law's own commands; the way of thesis 5.2.2.

1. The teacher drives, and says what it does in every state; half of the runs are disturbed.
2. Clusters of (inputs, outputs) give the rules, least squares their consequents, hybrid learning moves both.
3. The pupil drives by what it learnt, the teacher says what it would do there, and all samples together are learnt
   from again; this repeats for some rounds [Ross, Gordon & Bagnell 2011].
4. Clusters of several radii are tried. What was learnt from each drives undisturbed on the checking seeds; the best
   drives in the next round, and the best of all rounds is taken: first by contacts, then by robots that do not arrive,
   then by the difference from the teacher in the states that it met.

The checking seeds, every fourth, are not learnt from: neither the consequents nor the premises have seen their runs.

A rule base of pairs says one number of each other robot, of which the least holds; the teacher shows only that one
number. Who of the others it was for is found as in learning from sets of instances [Dietterich et al. 1997]: it is the
one for whom the present rule base says least, and of the rest the rule base must only say no less.

T. G. Dietterich, R. H. Lathrop, T. Lozano-Pérez, "Solving the multiple instance problem with axis-parallel
rectangles", Artificial Intelligence 89 (1997).
"""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

import anfis
from fuzzy.compiled.sugeno import outputs_of
from fuzzy.files.fisfile import write_fis
from fuzzy.fitting.clustering import ClusteringOptions as Clustering
from fuzzy.fitting.clustering import densities, select_centers
from fuzzy.fitting.consequents import least_squares
from fuzzy.fitting.identification import Data, cluster_partition, system_of
from fuzzy.fitting.termnames import with_telling_names
from fuzzy.rule import Clause, Rule
from fuzzy.system import Linear, Sugeno, Variable
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError, Law
from robotics.laws.rules.quantities import quantity_of
from robotics.laws.rules.situation import NOTHING_NEAR
from robotics.plugins.learning.demonstrations import Demonstrations, ImitationTask, RunOutcome, demonstrate, joined
from robotics.plugins.learning.lesson import COMMAND_UNITS, ImitationError, ImitationPlan
from robotics.plugins.learning.onlooker import inputs_of
from robotics.plugins.learning.tandem import TeacherAndPupil

RULE_RADII = (0.2, 0.35, 0.6, 0.9)  # of the clusters, as shares of each column's range: all are tried
_LARGEST = 6000  # samples that are learnt from; more would be slow, and say little more
RARE = 0.002  # the share of samples below a universe, and of those above it
FREE = 0.6  # m/s: what is said of another robot that does not matter; thrice what timings ask for
GUESSES = 4  # times that the robot for which the teacher's number was is guessed anew


@dataclass(frozen=True, eq=False)
class Fitted:
    """A rule base that was fitted, and how well."""

    system: Sugeno
    samples: int  # that were learnt from
    radius: float  # of the clusters
    train: np.ndarray  # (outputs,) RMSE, in each output's unit
    check: np.ndarray  # (outputs,) RMSE on the checking seeds' samples of all rounds so far


@dataclass(frozen=True, eq=False)
class Round(Fitted):
    """What was learnt in one round, and how it drove on the checking seeds, undisturbed."""

    met: np.ndarray  # (outputs,) RMSE from the teacher in the states that it met itself on the checking seeds
    touched: int  # runs with a contact
    missing: int  # robots that did not arrive, or were stopped

    def __str__(self) -> str:
        def told(errors: np.ndarray) -> str:
            rows = zip(self.system.outputs, errors, strict=True)
            return ", ".join(f"{v.name} {error:.3g} {v.unit}" for v, error in rows)

        return (
            f"{self.samples} samples, radius {self.radius:g}; RMSE {told(self.train)} training, {told(self.check)} "
            f"checking, {told(self.met)} on its own; {self.touched} contacts, {self.missing} robots missing"
        )

    def told(self) -> dict[str, Any]:
        """Its numbers by name, for JSON."""
        names = [v.name for v in self.system.outputs]
        errors = {"train_rmse": self.train, "check_rmse": self.check, "flight_rmse": self.met}
        by_output = {what: dict(zip(names, map(float, rows), strict=True)) for what, rows in errors.items()}
        about = {"samples": self.samples, "radius": self.radius, **by_output, "of_the_range": self.of_the_range}
        return about | {"contacts": self.touched, "missing": self.missing}

    def merit(self) -> tuple[int, int, float]:
        """What is compared: the less the better."""
        return self.touched, self.missing, self.of_the_range

    @property
    def of_the_range(self) -> float:
        """The difference from the teacher in the states that it met, as a share of the outputs' ranges."""
        spans = np.array([v.span for v in self.system.outputs])
        return float(np.sqrt(np.mean((self.met / spans) ** 2)))


@dataclass(frozen=True, eq=False)
class Imitation:
    """What came of a lesson."""

    lesson: ImitationPlan
    rounds: tuple[Round, ...]
    samples: Demonstrations  # of all rounds, those of the checking seeds included

    @property
    def best(self) -> int:
        """The number of the round whose rule base is taken."""
        return min(range(len(self.rounds)), key=lambda k: self.rounds[k].merit())

    @property
    def taken(self) -> Round:
        """That round."""
        return self.rounds[self.best]

    @property
    def system(self) -> Sugeno:
        """The rule base that was learnt."""
        return self.taken.system

    def table(self) -> tuple[list[str], np.ndarray]:
        """All samples as a table: the names of the columns, with units, and the numbers (samples, columns)."""
        lesson, samples = self.lesson, self.samples
        units = [quantity_of(name, "inputs").unit for name in lesson.inputs]
        names = ["round", "seed", "moment"]
        names += [f"{name} [{unit}]" for name, unit in zip(lesson.inputs, units, strict=True)]
        names += [f"{name} [{COMMAND_UNITS[name]}]" for name in lesson.outputs]
        of = samples.moment
        about = np.stack([samples.round[of], samples.seed[of], of], axis=1)
        return names, np.concatenate([about, samples.known, samples.said[of]], axis=1)


def steps(lesson: ImitationPlan) -> int:
    """How many times :func:`imitate` calls ``advance`` if no training stops early."""
    driven = len(lesson.courses) * (len(lesson.seeds) + len(RULE_RADII) * len(lesson.checking))
    return (lesson.rounds + 1) * (driven + len(RULE_RADII) * (lesson.options.epochs + 1))


def imitate(lesson: ImitationPlan, advance: Callable[[], None] | None = None) -> Imitation:
    """Learn a rule base from a teacher.

    Args:
        lesson: What is learnt, from whom, and how.
        advance: Called after every run and every epoch, see :func:`steps`.

    Raises ImitationError where the teacher cannot drive, and what laws, scenarios and learning raise.
    """
    step = advance or (lambda: None)
    teacher = make_controller(lesson.teacher)
    parts: list[Demonstrations] = []
    rounds: list[Round] = []
    # The matrices are small, and with one thread the same numbers come out everywhere
    with tempfile.TemporaryDirectory() as folder, threadpool_limits(1, "blas"):
        file = Path(folder) / "pupil.fis"
        write_fis(blank(lesson), file)
        tandem = _tandem(lesson, teacher, file)
        for number in range(lesson.rounds + 1):
            for course in lesson.courses:
                new, outcome = demonstrate(
                    course, tandem, lesson.outputs, lesson.seeds, number, lesson.disturbance, step
                )
                _expect_drives(lesson, course, outcome, new)
                parts.append(new)
            samples = joined(parts)
            found = [_tried(lesson, teacher, file, fitted(lesson, samples, r, step), step) for r in RULE_RADII]
            rounds.append(min(found, key=Round.merit))
            write_fis(rounds[-1].system, file)
            tandem = replace(_tandem(lesson, teacher, file), driver="pupil")
    return Imitation(lesson, tuple(rounds), samples)


def write_rule_base(found: Imitation, path: str | Path) -> None:
    """Write the rule base that was learnt, and in comments from whom and how. Raises FisFileError."""
    lesson, taken = found.lesson, found.taken
    lines = [
        f"{len(taken.system.rules)} rules learnt from {lesson.teacher} for {lesson.into}; driven were "
        f"{', '.join(course.name for course in lesson.courses)}",
        f"with the seeds {lesson.seeds[0]} to {lesson.seeds[-1]}, of which {', '.join(map(str, lesson.checking))} only "
        f"checked; round {found.best} of {lesson.rounds}, {lesson.options.epochs} epochs of {lesson.options.method}, "
        f"disturbance {lesson.disturbance:g}.",
        f"{taken}.",
    ]
    write_fis(taken.system, path, "\n".join(lines))


def drives(
    lesson: ImitationPlan, file: str | Path, seeds: Sequence[int], advance: Callable[[], None] | None = None
) -> dict[str, dict[str, dict[str, float]]]:
    """The outcome of the teacher and of the rule base in ``file`` on each course: by course, law and what it is.

    Args:
        lesson: What was learnt.
        file: The rule base.
        seeds: Seeds that were not learnt from.
        advance: Called after each course and law.
    """
    laws = {"teacher": lesson.teacher, "learnt": lesson.controller(file)}
    found: dict[str, dict[str, dict[str, float]]] = {}
    for course in lesson.courses:
        found[course.name] = {}
        for who, name in laws.items():
            found[course.name][who] = course.judged(make_controller(name), name, seeds)
            if advance is not None:
                advance()
    return found


class Lost(NamedTuple):
    """Where a rule base is the farthest from its teacher: a third of the states, by one of its inputs."""

    input: str
    low: float  # in the input's unit
    high: float
    share: float  # of the squared errors

    def __str__(self) -> str:
        unit = f" {quantity_of(self.input, 'inputs').unit}".removesuffix(" 1")
        return f"{100 * self.share:.0f} % where {self.input} is {self.low:.3g} to {self.high:.3g}{unit}"


def most_lost(found: Imitation) -> Lost | None:
    """The third of an input, by quantiles, with the greatest share of the squared errors on the checking seeds.

    Outputs count in their ranges. None where no input falls into thirds; and of pairs, whose least alone is shown.
    """
    lesson, system = found.lesson, found.system
    checked = found.samples.where(np.isin(found.samples.seed, lesson.checking))
    if lesson.of_pairs:
        return None
    spans = [v.span for v in system.outputs]
    squares = np.sum(((_said(system, checked.known) - checked.said[checked.moment]) / spans) ** 2, axis=1)
    parts = []
    for name, values in zip(lesson.inputs, checked.known.T, strict=True):
        for low, high in pairwise(np.quantile(values, [0, 1 / 3, 2 / 3, 1])):
            inside = (values >= low) & (values <= high)
            if inside.mean() < 0.5:  # else most of the values are the same
                parts.append(Lost(name, float(low), float(high), float(squares[inside].sum() / squares.sum())))
    return max(parts, key=lambda part: part.share, default=None)


def _tandem(lesson: ImitationPlan, teacher: Law[Any], file: Path) -> TeacherAndPupil:
    try:
        pupil: Any = make_controller(lesson.controller(file))
    except ControllerError as error:
        raise ImitationError(f"into {lesson.into}: {error}".replace(str(file), "the rule base")) from None
    own = [task for task, base in getattr(pupil, "rule_bases", {}).items() if base.fis.name == lesson.name]
    if not own:
        raise ImitationError(
            f"into {lesson.into}: it drives by no rule base whose inputs are named quantities; fuzzy:rule_base does, "
            "and fuzzy-team:crash_rule_base"
        )
    return TeacherAndPupil(teacher=teacher, pupil=pupil, learns=own[0])


def blank(lesson: ImitationPlan) -> Sugeno:
    """A rule base that says nothing, by which the inputs are asked for while the teacher drives."""
    inputs = inputs_of(lesson.inputs)
    zero = {"none": Linear((0.0,) * len(inputs), 0.0)}
    outputs = [Variable(name, (-1.0, 1.0), zero, COMMAND_UNITS[name]) for name in lesson.outputs]
    rule = Rule(tuple(Clause(v.name, "any") for v in inputs), tuple((v.name, "none") for v in outputs))
    return Sugeno(inputs, outputs, [rule], lesson.name, out_of_range="clip")


def _expect_drives(lesson: ImitationPlan, course: ImitationTask, outcome: RunOutcome, samples: Demonstrations) -> None:
    if outcome.refused.all():
        raise ImitationError(f"{course.name}: {lesson.teacher} knows no safe way in any run, and shows nothing")
    learnt_from = ~np.isin(samples.seed, lesson.checking)
    for what, chosen in (("learn from", learnt_from), ("check with", ~learnt_from)):
        if not chosen.any():
            raise ImitationError(f"{course.name}: no sample to {what}; let more seeds drive")


def _tried(lesson: ImitationPlan, teacher: Law[Any], file: Path, learnt: Fitted, step: Callable[[], None]) -> Round:
    """Fly what was learnt on the checking seeds, undisturbed; it is left in ``file``."""
    write_fis(learnt.system, file)
    tandem = replace(_tandem(lesson, teacher, file), driver="pupil")
    touched = missing = 0
    parts = []
    for course in lesson.courses:
        met, outcome = demonstrate(course, tandem, lesson.outputs, lesson.checking, 0, advance=step)
        touched, missing = touched + int(outcome.touched.sum()), missing + int(outcome.missing.sum())
        parts.append(met)
    met_itself = rmse(learnt.system, joined(parts), lesson.of_pairs)
    return Round(**vars(learnt), met=met_itself, touched=touched, missing=missing)


# A rule base from samples: clusters, least squares, hybrid learning --------------------------------------------------


def fitted(lesson: ImitationPlan, samples: Demonstrations, radius: float, step: Callable[[], None]) -> Fitted:
    """Fit a rule base to samples.

    Args:
        lesson: What is learnt, and how; its checking seeds' samples are not learnt from.
        samples: The samples.
        radius: That of the clusters, as a share of each column's range.
        step: Called after every epoch.
    """
    checking = np.isin(samples.seed, lesson.checking)
    of_pairs = lesson.of_pairs
    train = _some(samples.where(~checking), _LARGEST, of_pairs)
    check = _some(samples.where(checking), _LARGEST // 2, of_pairs)
    if of_pairs:
        system = _guessed(lesson, train, radius)
        said, shown = _wanted(system, train), _wanted(system, check)
    else:
        said, shown = train.said, check.said
        system = _clustered(lesson, _data(lesson, train.known, said), radius)
    data, count = _data(lesson, train.known, said), len(lesson.inputs)
    held = np.clip(check.known, data.low[:count], data.high[:count])
    system = _trained(lesson, system, data, (held, shown), step)
    return Fitted(system, len(train.known), radius, rmse(system, train, of_pairs), rmse(system, check, of_pairs))


def _some(samples: Demonstrations, most: int, of_pairs: bool) -> Demonstrations:
    """About ``most`` of the samples, whole moments drawn at random, the same ones for the same samples.

    Of pairs, moments in which a teacher holds a robot back are few, and they are what there is to learn: up to half of
    the samples are theirs.
    """
    if len(samples.known) <= most:
        return samples
    rng = np.random.default_rng(len(samples.said))
    count = max(1, most * len(samples.said) // len(samples.known))
    order = rng.permutation(len(samples.said))
    if of_pairs:
        held_back = order[samples.held_back[order]][: count // 2]
        free = order[~samples.held_back[order]]
        order = np.concatenate([held_back, free])
    chosen = np.zeros(len(samples.said), dtype=bool)
    chosen[order[:count]] = True
    return samples.where(chosen)


def _data(lesson: ImitationPlan, known: np.ndarray, said: np.ndarray) -> Data:
    """The samples, with universes that hold all but the rarest of them; others are clipped, as when it drives."""
    names = [(name, quantity_of(name, "inputs").unit) for name in lesson.inputs]
    outputs = [(name, COMMAND_UNITS[name]) for name in lesson.outputs]
    low, high = np.transpose([_universe(column) for column in np.concatenate([known, said], axis=1).T])
    count = known.shape[1]
    clipped = np.clip(known, low[:count], high[:count]), np.clip(said, low[count:], high[count:])
    return Data(*clipped, low, high, names, outputs)


def _universe(values: np.ndarray) -> tuple[float, float]:
    """The lowest and the highest of ``values`` (samples,) but for the rarest, in round numbers.

    NOTHING_NEAR is what is told where there is nothing to tell: it has no place of its own beyond the others.
    """
    told = values[np.abs(values) < NOTHING_NEAR]
    low, high = np.quantile(told if len(told) else values, [RARE, 1 - RARE]).tolist()
    if high - low < 1e-9:
        low, high = low - 0.5, high + 0.5
    unit = 10.0 ** np.floor(np.log10(high - low) - 1)
    return round(float(np.floor(low / unit) * unit), 9), round(float(np.ceil(high / unit) * unit), 9)


def _clustered(lesson: ImitationPlan, data: Data, radius: float) -> Sugeno:
    """A system of the wanted number of rules from clusters of that radius, its consequents by least squares.

    Of wide clusters there may be fewer.
    """
    both = np.concatenate([data.x, data.y], axis=1)
    found = select_centers(
        densities(both, radius, ranges=data.ranges), Clustering(accept=0.0, reject=0.0), most=lesson.rules
    )
    partition = cluster_partition(found.centers, found.sigma, data.x.shape[1])
    system = system_of(partition, data, lesson.name)
    return least_squares(system, data.x, data.y, lesson.options.ridge).fis


def _trained(
    lesson: ImitationPlan, system: Sugeno, data: Data, held: tuple[np.ndarray, np.ndarray], step: Callable[[], None]
) -> Sugeno:
    """The system after hybrid learning, each output counted in its range; named, and fit to drive by."""
    spans = (data.high - data.low)[data.x.shape[1] :]
    begin, y, check = _scaled(system, 1 / spans), data.y / spans, (held[0], held[1] / spans)
    training = anfis.train(begin, data.x, y, lesson.options, check=check, callback=lambda _: step())
    return with_telling_names(replace(_scaled(training.system, spans), out_of_range="clip"))


def _scaled(system: Sugeno, factors: np.ndarray) -> Sugeno:
    """The system with each output multiplied by a factor > 0."""
    outputs = []
    for variable, factor in zip(system.outputs, factors.tolist(), strict=True):
        terms: dict[str, Any] = {
            name: Linear(tuple(slope * factor for slope in term.slopes), term.constant * factor)
            for name, term in variable.terms.items()
            if isinstance(term, Linear)
        }
        low, high = variable.universe
        outputs.append(replace(variable, terms=terms, universe=(low * factor, high * factor)))
    return replace(system, outputs=outputs)


def _said(system: Sugeno, x: np.ndarray) -> np.ndarray:
    """What the system says at ``x`` (samples, inputs), outside its universes as when it drives."""
    return np.asarray(outputs_of(replace(system, out_of_range="clip"), np.ascontiguousarray(x)))


def rmse(system: Sugeno, samples: Demonstrations, of_pairs: bool) -> np.ndarray:
    """The RMSE (outputs,) of ``system`` over the moments of ``samples``, in each output's unit.

    Of pairs it is that of the least that is said; where the teacher does not hold a robot back, no more is no error.
    """
    said = _said(system, samples.known)
    if not of_pairs:
        return np.sqrt(np.mean((said - samples.said[samples.moment]) ** 2, axis=0))
    off = _least(said[:, 0], samples) - samples.said[:, 0]
    # Where the teacher holds a robot back for nobody, any speed that is no less will do
    off = np.where(samples.held_back, off, np.minimum(off, 0.0))
    return np.sqrt(np.mean(off**2, keepdims=True))


def _guessed(lesson: ImitationPlan, train: Demonstrations, radius: float) -> Sugeno:
    """A system from clusters, after guessing some times for whom of the others the teacher's speed was."""
    wanted = np.where(train.held_back[train.moment, None], train.said[train.moment], FREE)
    system = _clustered(lesson, _data(lesson, train.known, wanted), radius)
    for _ in range(GUESSES):
        system = _clustered(lesson, _data(lesson, train.known, _wanted(system, train)), radius)
    return system


def _wanted(system: Sugeno, samples: Demonstrations) -> np.ndarray:
    """What should be said of each other robot (samples, 1) [m/s].

    Where the teacher holds the robot back: the teacher's speed for the one of whom the least is said, and of the others
    no less. Where it does not: FREE.
    """
    said = _said(system, samples.known)[:, 0]
    shown, held_back = samples.said[samples.moment, 0], samples.held_back[samples.moment]
    least = said <= _least(said, samples)[samples.moment]
    wanted = np.where(least, shown, np.clip(said, shown, FREE))
    return np.where(held_back, wanted, FREE)[:, None]


def _least(said: np.ndarray, samples: Demonstrations) -> np.ndarray:
    """The least of what is ``said`` (samples,) of the other robots in each moment (moments,)."""
    least = np.full(len(samples.said), np.inf)
    np.minimum.at(least, samples.moment, said)
    return least
