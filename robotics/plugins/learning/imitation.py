"""Imitation: a rule base that does what a law does, learnt from the law's own commands; the way of thesis 5.2.2.

1. The teacher drives, and says what it does in every state; half of the runs are disturbed.
2. Clusters of (inputs, outputs) give the rules, least squares their consequents, hybrid learning moves both.
3. The pupil drives by what it learnt, the teacher says what it would do there, and all samples together are learnt
   from again; this repeats for some rounds [Ross, Gordon & Bagnell 2011].
4. Clusters of several radii are tried. What was learnt from each drives undisturbed on the checking seeds; the best
   drives in the next round, and the best of all rounds is taken: first by contacts, then by robots that do not arrive,
   then by the difference from the teacher in the states that it met.

The checking seeds, every fourth, are not learnt from: neither the consequents nor the premises have seen their runs.
"""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from fuzzy.files.fisfile import write_fis
from fuzzy.membership import Gaussian
from fuzzy.rule import Clause, Rule
from fuzzy.system import Linear, Sugeno, Variable
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError, Law
from robotics.laws.rules.quantities import quantity_of
from robotics.laws.rules.situation import NOTHING_NEAR
from robotics.plugins.learning.courses import ImitationTask
from robotics.plugins.learning.demonstrations import Demonstrations, RunOutcome, demonstrate, joined
from robotics.plugins.learning.lesson import COMMAND_UNITS, ImitationError, ImitationPlan
from robotics.plugins.learning.rulefitting import RULE_RADII, Fitted, fitted, rmse
from robotics.plugins.learning.tandem import TeacherAndPupil


class Round(NamedTuple):
    """What was learnt in one round, and how it drove on the checking seeds, undisturbed."""

    system: Sugeno
    samples: int  # that were learnt from
    radius: float  # of the clusters
    train: np.ndarray  # (outputs,) RMSE, in each output's unit
    check: np.ndarray  # (outputs,) RMSE on the checking seeds' samples of all rounds so far
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
        about = {"samples": self.samples, "radius": self.radius, **by_output}
        return about | {"contacts": self.touched, "missing": self.missing}

    def merit(self) -> tuple[int, int, float]:
        """What is compared: the less the better."""
        return self.touched, self.missing, float(np.sqrt(np.mean((self.met / self.spans) ** 2)))

    @property
    def spans(self) -> np.ndarray:
        """The ranges of the outputs (outputs,)."""
        return np.array([v.universe[1] - v.universe[0] for v in self.system.outputs])


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
    def system(self) -> Sugeno:
        """The rule base that was learnt."""
        return self.rounds[self.best].system

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
            found = [
                _tried(lesson, teacher, file, fitted(lesson, samples, radius, step), step) for radius in RULE_RADII
            ]
            rounds.append(min(found, key=Round.merit))
            write_fis(rounds[-1].system, file)
            tandem = replace(_tandem(lesson, teacher, file), driver="pupil")
    return Imitation(lesson, tuple(rounds), samples)


def write_rule_base(found: Imitation, path: str | Path) -> None:
    """Write the rule base that was learnt, and in comments from whom and how. Raises FisFileError."""
    lesson, taken = found.lesson, found.rounds[found.best]
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
    some = {"any": Gaussian(NOTHING_NEAR, 0.0)}
    inputs = [
        Variable(name, (-NOTHING_NEAR, NOTHING_NEAR), some, quantity_of(name, "inputs").unit) for name in lesson.inputs
    ]
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


def _tried(lesson: ImitationPlan, teacher: Law[Any], file: Path, learnt: "Fitted", step: Callable[[], None]) -> Round:
    """Fly what was learnt on the checking seeds, undisturbed; it is left in ``file``."""
    write_fis(learnt.system, file)
    tandem = replace(_tandem(lesson, teacher, file), driver="pupil")
    touched = missing = 0
    parts = []
    for course in lesson.courses:
        met, outcome = demonstrate(course, tandem, lesson.outputs, lesson.checking, 0, advance=step)
        touched, missing = touched + int(outcome.touched.sum()), missing + int(outcome.missing.sum())
        parts.append(met)
    error = rmse(learnt.system, joined(parts), lesson.of_pairs)
    return Round(*learnt, error, touched, missing)
