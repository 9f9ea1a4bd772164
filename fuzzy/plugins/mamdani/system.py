"""The Mamdani system as MATLAB evaluates it: what a Sugeno system made of one is measured against.

    old = read_mamdani_original("old.fis")
    old([2.0, 1.0])

The antecedents are evaluated by :mod:`fuzzy.inference`, as those of a Sugeno system. Each rule then cuts or scales its
output set, the sets of all rules are joined at ``points`` points over the output's range, and one number is taken of
the joint set [Mamdani & Assilian 1975].
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from fuzzy.files.mamdani import as_constants, renounced
from fuzzy.inference import InferenceWarning, infer, say_no_rule_fires
from fuzzy.membershipfunction import MembershipFunction
from fuzzy.naming import check_known
from fuzzy.system import FuzzySystemError, Sugeno, Terms, Variable

Implication = Literal["min", "prod"]
Aggregation = Literal["max", "sum", "probor"]
Defuzzification = Literal["centroid", "bisector", "mom", "lom", "som"]
_AT_ONCE = 1_000_000  # rows × points of the joint sets that are held at once: 8 MB
_MOST_POINTS = 100_001


@dataclass(frozen=True)
class Mamdani:
    """A Mamdani system: the terms of its outputs are sets. Its rules may be given as sentences. It is called as a
    Sugeno
    system is.

    The defaults are those of MATLAB's ``mamfis``: min, max, min, max, centroid, 101 points. Where no rule fires, or the
    joint set is empty, the output is the middle of its range, with a warning.

    Attributes:
        inputs: The inputs.
        outputs: The outputs, whose terms are membership functions.
        rules: Each a :class:`Rule`, or a sentence.
        name: The system's name.
        and_method: How "and" joins degrees.
        or_method: How "or" joins degrees.
        implication: How a firing strength cuts ("min") or scales ("prod") a set.
        aggregation: How the sets of all rules are joined.
        defuzzification: How the joint set becomes a number: centroid, bisector, or the mean, largest or smallest of its
            maxima.
        points: Of the joint set, from end to end of the output's range.
        complements: By output: the sets that rules negate, and what they call the complement ("not slow").
        premises: Inputs and rules as a Sugeno system, whose outputs are stand-ins; made on construction.

    Raises:
        FuzzySystemError: Parts that do not fit together.
        RuleError: A sentence that is no rule of the system.
    """

    inputs: Sequence[Variable]
    outputs: Sequence[Variable]
    rules: Sequence[Any] = ()
    name: str = "fuzzy"
    and_method: Literal["prod", "min"] = "min"
    or_method: Literal["probor", "max"] = "max"
    implication: Implication = "min"
    aggregation: Aggregation = "max"
    defuzzification: Defuzzification = "centroid"
    points: int = 101
    complements: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    premises: Sugeno = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for name in ("inputs", "outputs"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        for name, accepted in _CHOICES.items():
            check_known(getattr(self, name), accepted, name, FuzzySystemError, where=self.name)
        if not (isinstance(self.points, int) and 2 <= self.points <= _MOST_POINTS):
            raise FuzzySystemError(f"{self.name}: points must be from 2 to {_MOST_POINTS}, got {self.points!r}")
        stand_ins = []
        for output in self.outputs:
            for label, term in output.terms.items():
                if not isinstance(term, MembershipFunction):
                    raise FuzzySystemError(f"output {output.name!r}: term {label!r} must be a set, got {term!r}")
            labels = (*output.terms, *self.complements.get(output.name, {}).values())
            stand_ins.append(Variable(output.name, output.universe, Terms(dict.fromkeys(labels, 0.0))))
        premises = Sugeno(
            self.inputs, stand_ins, self.rules, self.name, and_method=self.and_method, or_method=self.or_method
        )
        object.__setattr__(self, "premises", premises)
        object.__setattr__(self, "rules", premises.rules)

    def __call__(self, x: Any) -> np.ndarray:
        """Evaluate the outputs (..., outputs) at ``x`` (..., inputs), in the units of the variables.

        Warns (InferenceWarning) of inputs outside their universe and of outputs at midrange because no rule fires.
        """
        output, fired = self.evaluate(x)
        missing = ~fired.reshape(-1, len(self.outputs)).all(axis=0)
        if missing.any():
            say_no_rule_fires(self.premises, missing)
        return output

    def evaluate(self, x: Any) -> tuple[np.ndarray, np.ndarray]:
        """The outputs (..., outputs) at ``x`` (..., inputs), and whether any set is there to be defuzzified (...,
        outputs), without warning of its absence.
        """
        firing = self.firing(x)
        rows = firing.reshape(-1, len(self.rules))
        output = np.empty((len(rows), len(self.outputs)))
        fired = np.empty(output.shape, dtype=bool)
        block = max(1, _AT_ONCE // self.points)
        for j, variable in enumerate(self.outputs):
            places = np.linspace(*variable.universe, self.points)
            for first in range(0, len(rows), block):
                part = slice(first, first + block)
                joint = self._joint(rows[part], j, places)
                output[part, j] = _DEFUZZIFIERS[self.defuzzification](joint, places)
                fired[part, j] = joint.max(axis=1) > 0
            output[~fired[:, j], j] = variable.midrange
        shape = (*firing.shape[:-1], len(self.outputs))
        return output.reshape(shape), fired.reshape(shape)

    def firing(self, x: Any) -> np.ndarray:
        """The firing strengths (..., rules) at ``x`` (..., inputs), with the rules' weights."""
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", ".*no rule fires", InferenceWarning)
            return np.asarray(infer(self.premises, x).firing)

    def joint_set(self, x: Sequence[float], output: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """The places (points,) and degrees (points,) of the set that all rules together give an output at one point.

        Args:
            x: The point (inputs,), in the inputs' units.
            output: The output, by its place.
        """
        places = np.linspace(*self.outputs[output].universe, self.points)
        return places, self._joint(np.atleast_2d(self.firing(x)), output, places)[0]

    def _joint(self, firing: np.ndarray, output: int, places: np.ndarray) -> np.ndarray:
        """The joint set (rows, points) of an output from firing strengths (rows, rules)."""
        variable = self.outputs[output]
        sets = [np.asarray(function(places)) for function in variable.terms.values()]
        sets += [1 - np.asarray(variable.terms[label](places)) for label in self.complements.get(variable.name, {})]
        joint = np.zeros((len(firing), len(places)))
        for strength, term in zip(firing.T, self.premises.structure.consequent[output], strict=True):
            if term < 0:
                continue
            column = strength[:, None]
            own = np.minimum(column, sets[term]) if self.implication == "min" else column * sets[term]
            if self.aggregation == "max":
                np.maximum(joint, own, out=joint)
            elif self.aggregation == "sum":
                joint += own
            else:
                joint += own - joint * own
        return joint

    def as_sugeno(self) -> tuple[Sugeno, tuple[str, ...]]:
        """The Sugeno system whose constants are the centroids of the sets, and what was changed, a sentence each."""
        settings = {"aggregation": self.aggregation, "implication": self.implication}
        new, said = renounced({**settings, "defuzzification": self.defuzzification})
        outputs, changes = [], []
        for output in self.outputs:
            variable, own = as_constants(output, self.complements.get(output.name, {}))
            outputs.append(variable)
            changes += own
        methods: dict[str, Any] = {"and_method": self.and_method, "or_method": self.or_method, **new}
        return Sugeno(self.inputs, outputs, self.rules, self.name, **methods), (*changes, *said)


_CHOICES: dict[str, tuple[str, ...]] = {
    "implication": get_args(Implication),
    "aggregation": get_args(Aggregation),
    "defuzzification": get_args(Defuzzification),
}


def _centroid(joint: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Σ μ x / Σ μ, about the middle of the range, where moments cancel less."""
    middle = (places[0] + places[-1]) / 2
    area = joint.sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(middle + joint @ (places - middle) / area)


def _bisector(joint: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The first place up to which at least half of the area lies."""
    area = np.cumsum(joint, axis=1)
    return np.asarray(places[np.argmax(area >= area[:, -1:] / 2, axis=1)])


def _mean_of_maximum(joint: np.ndarray, places: np.ndarray) -> np.ndarray:
    highest = joint == joint.max(axis=1, keepdims=True)
    return np.asarray(highest @ places / highest.sum(axis=1))


def _smallest_of_maximum(joint: np.ndarray, places: np.ndarray) -> np.ndarray:
    return np.asarray(places[np.argmax(joint, axis=1)])


def _largest_of_maximum(joint: np.ndarray, places: np.ndarray) -> np.ndarray:
    return np.asarray(places[::-1][np.argmax(joint[:, ::-1], axis=1)])


_DEFUZZIFIERS = {
    "centroid": _centroid,
    "bisector": _bisector,
    "mom": _mean_of_maximum,
    "som": _smallest_of_maximum,
    "lom": _largest_of_maximum,
}
