"""A control law as a header and a source of C: the step that a robot makes in every control period."""

import ast
import inspect
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Column, Columns
from fuzzy.naming import check_known
from fuzzy.plugins.ccode.identifier import comment, identifier, identifiers
from fuzzy.plugins.ccode.numbertype import FLOATING, ExportError, Floating
from fuzzy.plugins.ccode.source import CSources, c_sources
from fuzzy.system import Sugeno
from robotics.laws.equation import AimColumns, Equation, EquationLaw, RobotColumns, command_columns, gain_columns, giver
from robotics.laws.knowledge import SmoothedColumns, smooth_correction
from robotics.laws.law import Law
from robotics.laws.rules.of_reference import BY_PATH, later
from robotics.laws.rules.own_rules import CompositeRules, OwnRules
from robotics.laws.rules.quantities import quantity_of
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.laws.tracking.linear_quadratic import LinearQuadratic
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.laws.tracking.pid import TrackingPID
from robotics.laws.tracking.sliding_mode import SlidingMode
from robotics.plugins.ccode.guard import HandedOrder, guard_of
from robotics.plugins.ccode.terms import (
    PIECES,
    Arithmetic,
    CArray,
    CRecord,
    CTable,
    CTerm,
    KnownValue,
    Lane,
    Row,
    piece,
)
from robotics.plugins.ccode.translation import WRITTEN_OUT, CFunction, Translator, parsed
from robotics.simulation.safety.monitor import keep_one, note_order
from robotics.simulation.safety.others import PostureMessage, PromiseColumns
from robotics.tables.texts import TextFile
from robotics.world.radio.channel import HeardColumns
from robotics.world.vehicle.plant import LimitColumns, TruthColumns, velocity_limits, within_limits

_TEXTS = TextFile("robotics.plugins.ccode")
_NUMBERS = ("double", "float")
_SEEN = (*RobotColumns.columns, *(f"at_{name}" for name in AimColumns.columns), "wish_v", "wish_w")
AIM_SYMBOLS = tuple(f"ahead_{name}" for name in AimColumns.columns)


# What a number is called in C, where that is not its name in capitals
SYMBOLS = {"lam": "LAMBDA", "radius": "WHEEL_RADIUS"}


# The laws that can be written, and the thesis's sections of each
SECTIONS: dict[type[Law[Any]], str] = {
    FuzzyTracking: "(2.35), (2.36), 5.3.1",
    OwnRules: "(2.35), (2.36), 5.3.1",
    Lyapunov: "(2.30) to (2.32)",
    LinearQuadratic: "",
    TrackingPID: "",
    SlidingMode: "(2.13) to (2.23)",
    HandedOrder: "",
}
NAMES = "fuzzy (any rule base of tracking), fuzzy-lateral, fuzzy-correcting, lyapunov, lqr, pid, csm, assm, qssm, esm"


def check_written(law: Law[Any], specification: str) -> None:
    """Raise ExportError, listing the laws that can be written in C, for one that cannot."""
    if type(law) not in SECTIONS or not getattr(law, "has_equation", False):
        why = "it looks ahead, hears others, or has a control step that is not translated"
        if isinstance(law, CompositeRules):
            why = "its rule base is a tree or of type-2, which `fuzzy export c` writes alone"
        elif isinstance(law, OwnRules):
            why = "its rule base asks for more than fuzzy tracking knows"
        raise ExportError(
            f"{specification} cannot be written in C: {why}; those that can be: {NAMES}; with safe=yes behind it its "
            "monitor of passive safety is, below orders that are handed"
        )
    if (more := handed(law)) and len(law.fuzzy_systems["own"].inputs) > WRITTEN_OUT:
        raise ExportError(
            f"{specification} cannot be written in C: of more than {WRITTEN_OUT} inputs none may be {' or '.join(more)}"
        )


def handed(law: Law[Any]) -> dict[str, str]:
    """The inputs of a rule base of one's own that C is handed as they are, each with the name of its field."""
    own = law.own if isinstance(law, OwnRules) else None
    names = [v.name for v in own.fis.inputs if v.name in ("time", *BY_PATH) or later(v.name)] if own else []
    return dict(zip(names, identifiers(names), strict=True))


class LawSources(NamedTuple):
    """A law in C: its two texts, and those of its rule bases."""

    name: str
    header: str
    source: str
    bases: tuple[CSources, ...]
    inputs: tuple[str, ...]  # fields of the input struct
    memory: tuple[str, ...]  # fields of the state struct
    outputs: tuple[str, ...]  # fields of the output struct
    look_ahead: float  # s: of the point ahead, where it asks for one
    handed: dict[str, str]  # quantities that it is handed as they are, each with its field
    room: int = 1  # how many numbers the state has at most
    team: int = 1  # how many robots tell each other of themselves
    blind: tuple[str, ...] = ()  # sentences: what the monitor cannot see


def law_sources(law: Law[Any], setting: Setting, name: str, number: str = "double") -> LawSources:
    """Write a law's control step for the first robot of ``setting`` in C99.

    Args:
        law: The law; those of SECTIONS can be written.
        setting: Whose robot and control period count.
        name: The prefix of everything public, and the files' name.
        number: "double" or "float".

    Raises:
        ExportError: A law or a type of numbers that is not written, or passive safety of robots that differ.
    """
    check_known(number, _NUMBERS, "number type of a law", ExportError)
    check_written(law, name)
    if isinstance(law, OwnRules) and law.own is None:
        law = replace(law.tracker, smooth=law.smooth, safe=law.safe)
    return _Writer(law, setting, identifier(name), FLOATING[number]).sources()


class _Writer:
    def __init__(self, law: Any, setting: Setting, name: str, number: Floating) -> None:
        self.law, self.setting, self.name, self.number = law, setting, name, number
        self.guard = guard_of(law, setting, name)
        self.arithmetic = Arithmetic(number)
        self.gains = [float(np.ravel(row)[0]) for row in law.gain_rows(setting)]
        self.lead, self.share, *_ = [float(np.ravel(row)[0]) for row in law.knowledge_rows(setting)]
        self.limits = [float(row[0]) for row in velocity_limits(setting.robots[:1])]
        self.work = _places(type(law).works)
        self.equation = inspect.getattr_static(type(law), "equation")
        self.lanes = _lanes(type(law), self.equation)
        self.radius = setting.robots[0].wheel_radius
        rows = np.asarray(law.begin(setting, 1), dtype=float)
        own = rows[:, 0, 0] if len(rows) else np.empty(0)
        self.memory = np.append(own, np.zeros(SmoothedColumns.size if self.share < 1 else 0))
        self.constants: dict[str, tuple[float, str]] = {}  # each with its unit
        self.bases = rule_bases(law)
        self.handed = handed(law)
        self.called: dict[str, CSources] = {}
        self.torque = law.level == "torque"
        self.outputs: list[str] = []
        self.translator = Translator(name, self.arithmetic, self.read, self.call, self.constant)

    # What the translated functions read --------------------------------------------------------------------

    def constant(self, text: str, value: float) -> CTerm:
        """A named number."""
        name, _, unit = text.partition(" ")
        self.constants[name] = value, unit
        return CTerm(name, "real")

    def read(self, table: CTable | Lane, row: Any) -> Any:
        """An entry of a table of the law, or (row −1) a part of all that it knows; a column of a lane by its name."""
        return self._column(table, row) if isinstance(table, Lane) else self._entry(table, row)

    def _column(self, lane: Lane, name: str) -> Any:
        column, path = lane.of.columns[name], (*lane.path, name)
        if column.of is not None:
            return Lane(lane.name, column.of, lane.first + column.row, path)
        if column.width is not None:
            return CTable(lane.name, lane.first + column.row)
        if lane.name in ("given", "sensors") and self.guard is not None:
            found = self.guard.number(lane, name)
            if isinstance(found, CArray):
                self.translator.listed[found.text] = found
                return found.entry([CTerm(lane.at, "int")])
            if lane.name == "sensors" or found in (0.0, 1.0, math.inf):
                return KnownValue(found)
            return self.constant(f"{'_'.join(('guard', *path)).upper()} {_said(column, ', ')}", found)
        match lane.name:
            case "truth":
                own = self.setting.sensing[0].posture == "odometry"
                return CTerm(f"input->{name.removeprefix('odo_') if own else name}", "real")
            case "robot" | "seen":
                return CTerm(f"input->{name}", "real")
            case "aim":
                return CTerm(f"input->{'wish' if isinstance(self.law, HandedOrder) else 'at'}_{name}", "real")
            case "gain":
                value = self.gains[lane.first + column.row]
                return self._gain(path, column, value) if column.unit else KnownValue(value)
            case "limit":
                return self._gain(path, column, self.limits[column.row])
            case "memory" | "smoothed":
                return CTerm(f"state->{_field(path)}", "real")
            case "command":
                return self._commanded(path)
            case "promises":
                return CTerm(f"state->promises[{column.row}][{lane.at}]", "real")
            case "heard":
                row = column.row - HeardColumns.size
                return CTerm(f"input->age[{lane.at}]" if row < 0 else f"input->heard[{lane.at}][{row}]", "real")
            case "said":
                return CTerm(f"output->message[{column.row}]", "real")
        return self._entry(CTable(lane.name), lane.first + column.row)

    def _gain(self, path: tuple[str, ...], column: Column, value: float) -> CTerm:
        """A gain under its own name, or under all that lead to it where another number has that."""
        names = [SYMBOLS.get(name, name).upper() for name in path]
        told = _said(column, ", ")
        taken = names[-1] in self.constants and self.constants[names[-1]][0] != value
        return self.constant(f"{'_'.join(names) if taken else names[-1]} {told}", value)

    def _entry(self, table: CTable, row: int) -> Any:
        match table.name:
            case "dt":
                return self._period
            case "time":
                return CTerm("0.0", "real")
            case "column" | "path" | "base":
                return CTable(table.name) if row < 0 else KnownValue(0)
            case "seen" | "gains" | "road" if row < 0:
                return table
            case "rules":
                return table
            case "order":
                return CTerm(f"output->{'vw'[row]}", "real")
            case "gain":
                return KnownValue(self.gains[row])
            case "work":
                place, first = max(((p, f) for p, f in self.work.items() if f <= row), key=lambda pair: pair[1])
                return CTerm(f"work[{place}{f' + {row - first}' if row > first else ''}]", "real")
        raise ExportError(f"{type(self.law).__name__} reads {table.name}, which C does not have")

    def _commanded(self, path: tuple[str, ...]) -> Any:
        torques = {"first": "torque_right", "second": "torque_left", "wish_v": "v", "wish_w": "w"}
        name = (torques if self.torque else {"first": "v", "second": "w"}).get(".".join(path))
        if name is None:
            return None
        if name not in self.outputs:
            self.outputs.append(name)
        return CTerm(f"output->{name}", "real")

    def call(self, body: CFunction, name: str, arguments: Any) -> Any:
        """The functions that are not translated: rule bases, and the reference at a later time."""
        if name == "moving":
            return Row(tuple(CTerm(f"input->{field}", "real") for field in AIM_SYMBOLS))
        if name in ("tell_inputs", "tell_asked", "see_path"):
            return KnownValue(None)
        if name == "pick" and isinstance(arguments[0], KnownValue):
            asked = self.law.own.fis.inputs[arguments[0].value].name
            return CTerm(f"input->{self.handed[asked]}", "real") if asked in self.handed else NotImplemented
        if name == "evaluate_packed":
            return self._rule_base(body, *arguments[:3])
        return NotImplemented

    def _rule_base(self, body: CFunction, rules: CTable, asked: CTable, said: CTable) -> Any:
        title, fis = self.bases[rules.first]
        if title not in self.called:
            self.called[title] = c_sources(fis, f"{self.name}_{title}", self.number.name)
        base = self.called[title]
        places = [self.read(table, table.first).text for table in (asked, said)]
        body.say(f"{base.name}_infer(&{places[0]}, &{places[1]});")
        return KnownValue(0)

    # The texts ---------------------------------------------------------------------------------------------

    def sources(self) -> LawSources:
        """All texts."""
        step = f"{self._step(self.equation.function)}{self._stood()}"
        wheels = [] if self.torque else ["wheel_right", "wheel_left"]
        team = self.guard.robots if self.guard is not None else 1
        outputs = (*self.outputs, *wheels, *((f"message[{PostureMessage.size}]",) if team > 1 else ()))
        held = " ".join(function.text for function in self.translator.done.values())
        read = {*re.findall(r"input->(\w+)", f"{step} {held}")}
        odometry = tuple(name for name in TruthColumns.columns if name.startswith("odo_"))
        fields = (*_SEEN, *AIM_SYMBOLS, *odometry, *self.handed.values())
        inputs = tuple(field for field in fields if field in read)
        room, blind = 1 + len(self._fields()), tuple[str, ...]()
        if self.guard is not None:
            inputs += (f"age[{team}]", f"heard[{team}][{PostureMessage.size}]") if team > 1 else ()
            inputs += (f"ranges[{len(self.guard.names)}]",)
            room, blind = room + self.guard.room, tuple(self.guard.told)
        memory = tuple(name for name, _ in self._fields())
        look_ahead = float(getattr(self.law, "look_ahead", math.nan))
        texts, bases = (self._header(inputs, outputs, look_ahead), self._source(step)), tuple(self.called.values())
        ahead = look_ahead if "ahead_x" in inputs else math.nan
        return LawSources(self.name, *texts, bases, inputs, memory, outputs, ahead, self.handed, room, team, blind)

    def _step(self, one: Any) -> str:
        tree = parsed(one)
        body = CFunction(self.translator, one, tree)
        for argument in self.equation.asks:
            body.env[argument] = self._argument(argument)
        if isinstance(tree.body[-1], ast.Return) and tree.body[-1].value is not None:
            command = ast.parse("command.first, command.second = 0, 0").body[0]
            assert isinstance(command, ast.Assign)
            tree.body[-1], command.value = command, tree.body[-1].value
            body.env["command"] = self.lanes["command"]
        if self.work:
            body.say(f"{self.number.name} work[WORK] = {{{self.number.constant(0.0)}}};")
        body.run(tree.body)
        zero = self.number.constant(0.0)
        if self.share < 1:
            given: list[Any] = [self.lanes[name] for name in ("command", "aim")]
            given += [self.constant("SMOOTHING 1, of a new correction", self.share), self.limit]
            given.append(Lane("smoothed", SmoothedColumns, 0, ("smoothed",)))
            body.say(f"{body.called(self.translator.function(smooth_correction, given), given).text};")
        if self.torque:
            body.say("if (isfinite(output->torque_right) && isfinite(output->torque_left)) return 1;")
            body.say(f"output->torque_right = output->torque_left = {zero};")
            body.say("return 0;")
        else:
            self._guarded(body)
            self._wheels(body, zero)
        if not self._fields() and self.guard is None:
            body.lines.insert(0, "    (void)state;")
        head = (
            f"int {self.name}_step({self.name}_state *state, const {self.name}_input *input, "
            f"{self.name}_output *output) {{"
        )
        return "\n".join([fill(head, 112, subsequent_indent="    "), *self._read_later(body.finished()), "}", ""])

    def _read_later(self, lines: list[str]) -> list[str]:
        """The lines of a step without those that write to work what nobody reads."""
        text = "\n".join([*lines, *(function.text for function in self.translator.done.values())])
        unread = [f"work[{name}] = " for name in self.work if len(re.findall(rf"\b{name}\b", text)) == 1]
        return [line for line in lines if not line.strip().startswith(tuple(unread))]

    def _argument(self, name: str) -> Any:
        """What an argument of the equation stands for."""
        if name in self.lanes:
            return self.lanes[name]
        if name in ("i", "lane", "path"):
            return KnownValue(0)
        return self._entry(CTable(name), -1) if name in ("time", "dt") else CTable(name)

    def _fields(self) -> list[tuple[str, Column]]:
        """The fields of the state, with what each is."""
        smoothed = _leaves(SmoothedColumns, ("smoothed",)) if self.share < 1 else ()
        return [(_field(path), column) for path, column in (*_leaves(type(self.law).remembers), *smoothed)]

    def _guarded(self, body: CFunction) -> None:
        """The monitor, below the law."""
        if self.guard is None:
            return
        body.say("const int told = isfinite(output->v) && isfinite(output->w);")
        given: list[Any] = [CRecord("guard", self.guard), self.guard.lane, CTerm("state->k", "int"), self._period]
        given += [KnownValue(self.guard.robots), CTable("truth"), CTable("seen"), self.guard.readings, CTable("order")]
        body.say(f"{body.called(self.translator.function(keep_one, given), given).text};")
        body.say("state->k++;")

    def _stood(self) -> str:
        """The function for a period without a step, where there is a monitor."""
        if self.guard is None:
            return ""
        given: list[Any] = [CRecord("guard", self.guard), self.guard.lane, CTerm("state->k", "int"), self._period]
        given += [KnownValue(0.0), KnownValue(0.0)]
        body = CFunction(self.translator, self.equation.function, parsed(self.equation.function))
        noted = body.called(self.translator.function(note_order, given), given).text
        return _TEXTS.text("stood", name=self.name, noted=noted)

    @property
    def _period(self) -> CTerm:
        return self.constant("PERIOD s, from one step to the next", self.setting.period)

    def _wheels(self, body: CFunction, zero: str) -> None:
        body.say("/* Within the robot's limits, and onto the wheels: r w_right = v + L w, r w_left = v - L w */")
        body.say("if (!isfinite(output->v) || !isfinite(output->w)) {")
        body.say(f"    output->wheel_right = output->wheel_left = {zero};")
        body.say("    return 0;")
        body.say("}")
        limit = self.limit
        arguments = [limit, CTerm("output->v", "real"), CTerm("output->w", "real")]
        held = body.called(self.translator.function(within_limits, arguments), arguments, "held")
        half = self.read(limit, "half_axle").text
        radius = self.constant("WHEEL_RADIUS m", self.radius).text
        for side, sign in (("right", "+"), ("left", "-")):
            body.say(f"output->wheel_{side} = ({held.name}[0] {sign} {half} * {held.name}[1]) / {radius};")
        body.say("return 1;" if self.guard is None else "return told;")

    @property
    def limit(self) -> Any:
        """The robot's limits, as a part of the law's gains where it has them."""
        own = [name for name, column in self.lanes["gain"].of.columns.items() if column.of is LimitColumns]
        return self.read(self.lanes["gain"], own[0]) if own else Lane("limit", LimitColumns)

    @property
    def number_of_team(self) -> str:
        """The parameter that says which of a team a robot is."""
        return ", int robot" if self.guard is not None and self.guard.robots > 1 else ""

    def _source(self, step: str) -> str:
        real = self.number.name
        upper = self.name.upper()
        functions = [function.text for function in self.translator.done.values()]
        used = set(re.findall(r"\w+", " ".join([*functions, step])))
        constants = []
        for name, (number, unit) in self.constants.items():
            if name not in used:
                continue
            value = f"{upper}_PERIOD_S" if name == "PERIOD" else self.number.constant(number)
            constants.append(f"static const {real} {name} = {value}; /* {comment(unit)} */")
        places = ", ".join(f"{name} = {first}" for name, first in self.work.items() if name in used)
        starts = [
            f"    state->{name} = {self.number.constant(float(value))};"
            for (name, _), value in zip(self._fields(), self.memory, strict=True)
        ]
        if self.guard is not None:
            starts = [f"    static const {self.name}_state nothing;", "    *state = nothing;", *starts]
        if self.guard is not None and self.number_of_team:
            starts.append("    state->robot = robot;")
            far = self.number.infinity
            for row, (name, bound) in enumerate(zip(PromiseColumns.columns, (far, f"-{far}", far, 0), strict=True)):
                each = f"for (int n = 0; n < {self.guard.promises.shape[1]}; n++)"
                starts.append(f"    {each} state->promises[{row}][n] = {bound}; /* {name}: none holds yet */")
        starts = starts or ["    state->nothing = 0;"]
        parts = [
            f"/* The law {comment(self.name)}, in {real}: see {self.name}.h. Made of the law. */",
            "\n".join([f'#include "{self.name}.h"', *(f'#include "{b.name}.h"' for b in self.called.values()), ""]),
            "#include <math.h>\n",
            "/* The gains, and the robot's numbers */\n" + "\n".join(constants) + "\n",
            *(self._listed(array) for array in self.translator.listed.values() if array.text in used),
            *([f"/* Places of the numbers that a step works in */\nenum {{{places}}};\n"] if places else []),
            *(piece(name, self.number) for name in PIECES if name in self.arithmetic.needed),
            *functions,
            "\n".join([f"void {self.name}_init({self.name}_state *state{self.number_of_team}) {{", *starts, "}", ""]),
            step,
            _TEXTS.text("fresh", name=self.name),
        ]
        return "\n".join(parts)

    def _listed(self, array: CArray) -> str:
        """Known numbers that are looked up, as an array of C."""
        kind, write = ("int", str) if array.kind == "int" else (self.number.name, self.number.constant)
        rows = ["{" + ", ".join(map(write, row)) + "}" for row in np.atleast_2d(array.values).tolist()]
        listed = rows[0] if len(array.shape) == 1 else "{" + ", ".join(rows) + "}"
        size = "".join(f"[{n}]" for n in array.shape)
        return fill(f"static const {kind} {array.text}{size} = {listed};", 112, subsequent_indent="    ") + "\n"

    def _header(self, inputs: tuple[str, ...], outputs: tuple[str, ...], look_ahead: float) -> str:
        name, upper, real = self.name, self.name.upper(), self.number.name
        said = _TEXTS.table("outputs")
        state = [f"    {real} {name}; /* {comment(_said(column))} */" for name, column in self._fields()]
        if self.guard is not None:
            state += [f"    {what.replace('REAL', real)}; /* {said} */" for what, said in self.guard.kept.items()]
        structs = {
            "input": [f"    {real} {f}; /* {comment(self._input_said(f, look_ahead))} */" for f in inputs],
            "state": state or [_TEXTS.text("nothing")],
            "output": [f"    {real} {f}; /* {said[f.partition('[')[0]]} */" for f in outputs],
        }
        first, second = (f"{'torque' if self.torque else 'wheel'}_{side}" for side in ("right", "left"))
        ahead = self.number.constant(look_ahead) if AIM_SYMBOLS[0] in inputs else ""
        typedefs = [_TEXTS.text("struct", name=name, kind=k, fields="\n".join(rows)) for k, rows in structs.items()]
        return _TEXTS.text(
            "header",
            name=name,
            upper=upper,
            law=comment(name),
            sections=f" by {sections}" if (sections := SECTIONS[type(self.law)]) else "",
            real=real,
            seconds=self.setting.period,
            period=self.number.constant(self.setting.period),
            first=first,
            second=second,
            look_ahead=_TEXTS.text("look-ahead", upper=upper, seconds=ahead) if ahead else "",
            structs="\n".join(typedefs),
            number=self.number_of_team,
            numbered=", 0" if self.number_of_team else "",
            guard="" if self.guard is None else self._guard_said(),
        )

    def _guard_said(self) -> str:
        """What the header says of the monitor."""
        assert self.guard is not None
        listed = ", ".join(f"{n}: {name}" for n, name in enumerate(self.guard.names))
        said = [f"ranges are of the sensors {listed}.", *(f"{told.partition(': ')[2]}." for told in self.guard.told)]
        if self.number_of_team:
            radio, delay = self.setting.radio, self.guard.delay
            said.append(
                f"Send message to the others every {radio.period:g} s. age says how old the message last heard of each "
                f"robot of the team is, by its number, and heard what it was: one that is older than {delay:g} s, and "
                "what stands at the robot's own number, is not read. Its posture and theirs are in one frame."
            )
        lines = [fill(comment(text), 112, initial_indent=" * ", subsequent_indent=" * ") for text in said]
        return _TEXTS.text("guard", name=self.name, said="\n".join(lines))

    def _input_said(self, field: str, look_ahead: float) -> str:
        """The unit and the meaning of an input."""
        for quantity, symbol in self.handed.items():
            if symbol == field:
                known = quantity_of(quantity, "")
                return f"{known.unit}, {quantity}: {known.meaning}"
        if field.partition("[")[0] in (handed := _TEXTS.table("inputs")):
            return handed[field.partition("[")[0]]
        if field in TruthColumns.columns and field.startswith("odo_"):
            return f"{TruthColumns.columns[field].unit}, by the encoders alone"
        start, _, name = field.rpartition("_")
        if self.lead > 0 and field in ("at_v", "at_w"):
            return f"{AimColumns.columns[name].unit}, the reference's {self.lead:g} s from now"
        if self.law.estimator is not None and field in ("x", "y", "heading"):
            unit = RobotColumns.columns[name].unit
            return f"{unit}, measured, joined with odometry by the estimator {self.law.estimator}"
        if start == "ahead":
            column = AimColumns.columns[name]
            return f"{column.unit}, where it shall be {look_ahead:g} s from now" if name == "x" else column.unit
        return _said((AimColumns if start else RobotColumns).columns[name], ", ")


def rule_bases(law: Any) -> dict[int, tuple[str, Sugeno]]:
    """The rule bases of a law by where each begins in its packed rows: what it is called, and the system."""
    fuzzy, own = isinstance(law, (FuzzyTracking, OwnRules)), isinstance(law, OwnRules)
    systems = {"rules": law.tracking.fis, "turn": law.turn.fis} if fuzzy else {}
    systems |= {"own": law.own.fis} if own else {}
    found, place = {}, 0
    for (name, fis), row in zip(systems.items(), law.rule_rows(), strict=False):
        found[place] = (name, fis)
        place += len(row)
    return found


def _lanes(law: type[EquationLaw], equation: Equation) -> dict[str, Lane]:
    """The arguments of an equation that have columns."""
    gains = gain_columns(giver(law, equation))
    found: dict[str, type[Columns]] = {"robot": RobotColumns, "aim": AimColumns, "gain": gains}
    found |= {"memory": law.remembers, "command": command_columns(law), "work": law.works}
    return {name: Lane(name, of) for name, of in found.items()}


def _leaves(of: type[Columns], path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Column]]:
    """All rows that are numbers, by the names that lead to them."""
    for name, column in of.columns.items():
        if column.of is not None:
            yield from _leaves(column.of, (*path, name))
        else:
            yield (*path, name), column


def _places(works: type[Columns]) -> dict[str, int]:
    """What the numbers that a law works in are called, by where they begin, and last how many they are."""
    found, row = {}, 0
    for path, column in _leaves(works):
        if column.rows:
            found["_".join(path).upper()] = row
        row += column.rows
    return found | {"WORK": row} if found else {}


def _field(path: tuple[str, ...]) -> str:
    """What a number that is remembered is called: integral_v of v.integral."""
    return "_".join(reversed(path))


def _said(column: Column, between: str = ": ") -> str:
    return column.unit + between + column.meaning if column.meaning else column.unit
