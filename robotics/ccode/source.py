"""A control law as a header and a source of C: the step that a robot makes in every control period."""

import math
import re
from dataclasses import dataclass
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np

from fuzzy.ccode.identifier import comment, identifier
from fuzzy.ccode.numbertype import ExportError, Floating
from fuzzy.ccode.phrases import guarded
from fuzzy.ccode.source import CSources, c_sources
from fuzzy.naming import expected
from robotics.ccode.body import Body
from robotics.ccode.carried import LIMITS, Carried, carried, first_numbers, rule_bases
from robotics.ccode.pythonsource import parsed
from robotics.ccode.terms import PIECES, Arithmetic, Known, Row, Table, Term, piece
from robotics.ccode.translation import Translator
from robotics.laws import equation as rows
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.vehicle.plant import velocity_limits, within

NUMBERS = ("double", "float")
SEEN = ("x", "y", "heading", "v", "w", "at_x", "at_y", "at_heading", "at_v", "at_w", "at_s")
AHEAD = ("ahead_x", "ahead_y", "ahead_heading", "ahead_v", "ahead_w", "ahead_s")
_UNITS = {
    "x": "m, measured",
    "y": "m, measured",
    "heading": "rad, measured; need not be wrapped",
    "v": "m/s, by the encoders over the last period",
    "w": "rad/s, by the encoders over the last period",
    "at_x": "m, where the robot shall be now",
    "at_y": "m",
    "at_heading": "rad",
    "at_v": "m/s, how fast it shall be now",
    "at_w": "rad/s",
    "at_s": "m, how far along its path",
    "ahead_x": "m, where it shall be {ahead} s from now",
    "ahead_y": "m",
    "ahead_heading": "rad",
    "ahead_v": "m/s",
    "ahead_w": "rad/s",
    "ahead_s": "m",
}


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


def law_sources(law: Law[Any], setting: Setting, name: str, number: str = "double") -> LawSources:
    """Write a law's control step for the first robot of ``setting`` in C99.

    Args:
        law: The law; see :mod:`robotics.ccode.carried` for those that can be written.
        setting: Whose robot and control period count.
        name: The prefix of everything public, and the files' name.
        number: "double" or "float".

    Raises:
        ExportError: A law or a type of numbers that is not written.
    """
    if number not in NUMBERS:
        raise ExportError(expected(number, NUMBERS, "number type of a law"))
    how = carried(law, name)
    return _Writer(law, how, setting, identifier(name), Floating("double" if number == "double" else "float")).sources()


@dataclass
class _Constant:
    value: float
    unit: str


class _Writer:
    def __init__(self, law: Any, how: Carried, setting: Setting, name: str, number: Floating) -> None:
        self.law, self.how, self.setting, self.name, self.number = law, how, setting, name, number
        self.arithmetic = Arithmetic(number)
        self.gains = [float(np.ravel(row)[0]) for row in law.gain_rows(setting)]
        self.limits = [float(row[0]) for row in velocity_limits(setting.robots[:1])]
        self.radius = setting.robots[0].wheel_radius
        self.memory = first_numbers(law, setting)
        self.constants: dict[str, _Constant] = {}
        self.bases = rule_bases(law, how)
        self.called: dict[str, CSources] = {}
        self.torque = law.level == "torque"
        self.outputs: list[str] = []
        self.translator = Translator(name, self.arithmetic, self.read, self.call, self.constant)

    # What the translated functions read --------------------------------------------------------------------

    def constant(self, text: str, value: float) -> Term:
        """A named number."""
        name, _, unit = text.partition(" ")
        self.constants[name] = _Constant(value, unit)
        return Term(name, "real")

    def read(self, table: Table, row: int) -> Any:
        """An entry of a table of the law, or (row −1) a part of all that it knows."""
        match table.name:
            case "dt":
                return self.constant("PERIOD s, from one step to the next", self.setting.period)
            case "time":
                return Term("0.0", "real")
            case "column" | "path" | "base":
                return Table(table.name) if row < 0 else Known(0)
            case "seen" | "gains" | "rules" | "road" if row < 0:
                return table
            case "rules":
                return table
            case "gains":
                text = self.how.gains[row]
                return self.constant(text, self.gains[row]) if text else Known(self.gains[row])
            case "limits":
                return self.constant(LIMITS[row], self.limits[row])
            case "seen":
                return Term(f"input->{SEEN[row]}", "real")
            case "memory":
                return Term(f"state->{self.how.memory[row].partition(' ')[0]}", "real")
            case "command":
                return self._commanded(row)
            case "work":
                assert self.how.work is not None
                place, first = max(((p, f) for p, f in self.how.work.items() if f <= row), key=lambda pair: pair[1])
                return Term(f"work[{place}{f' + {row - first}' if row > first else ''}]", "real")
        raise ExportError(f"{type(self.law).__name__} reads {table.name}, which C does not have")

    def _commanded(self, row: int) -> Any:
        names = {rows.FIRST: "torque_right", rows.SECOND: "torque_left"} if self.torque else {}
        names = {rows.FIRST: "v", rows.SECOND: "w"} | names
        if self.torque:
            names |= {rows.WISH_V: "v", rows.WISH_W: "w"}
        if row not in names:
            return None
        if names[row] not in self.outputs:
            self.outputs.append(names[row])
        return Term(f"output->{names[row]}", "real")

    def call(self, body: Body, name: str, arguments: Any) -> Any:
        """The functions that are not translated: rule bases, and the reference at a later time."""
        if name == "moving":
            return Row(tuple(Term(f"input->{field}", "real") for field in AHEAD))
        if name == "told":
            return Known(None)
        if name == "evaluate_packed":
            return self._rule_base(body, *arguments[:3])
        return NotImplemented

    def _rule_base(self, body: Body, rules: Table, asked: Table, said: Table) -> Any:
        title, fis = self.bases[rules.first]
        if title not in self.called:
            self.called[title] = c_sources(fis, f"{self.name}_{title}", self.number.name)
        base = self.called[title]
        places = [self.read(table, table.first).text for table in (asked, said)]
        body.say(f"{base.name}_infer(&{places[0]}, &{places[1]});")
        return Known(0)

    # The texts ---------------------------------------------------------------------------------------------

    def sources(self) -> LawSources:
        """All texts."""
        python = type(self.law).equation
        python = getattr(python, "py_func", python)
        one = next(cell.cell_contents for cell in python.__closure__ or () if callable(cell.cell_contents))
        one = getattr(one, "py_func", one)
        step = self._step(one)
        wheels = [] if self.torque else ["wheel_right", "wheel_left"]
        outputs = (*self.outputs, *wheels)
        held = " ".join(function.text for function in self.translator.done.values())
        inputs = tuple(field for field in (*SEEN, *AHEAD) if f"input->{field}" in f"{step} {held}")
        memory = tuple(row.partition(" ")[0] for row in self.how.memory)
        look_ahead = float(getattr(self.law, "look_ahead", math.nan))
        header = self._header(inputs, outputs, look_ahead)
        bases = tuple(self.called.values())
        return LawSources(
            self.name,
            header,
            self._source(step),
            bases,
            inputs,
            memory,
            outputs,
            look_ahead if "ahead_x" in inputs else math.nan,
        )

    def _step(self, one: Any) -> str:
        tree = parsed(one)
        body = Body(self.translator, one, tree)
        for argument, value in zip(
            tree.args.args,
            (Known(0), Table("known"), Table("memory"), Table("command"), Table("work")),
            strict=True,
        ):
            body.env[argument.arg] = value
        if self.how.work is not None:
            body.say(f"{self.number.name} work[WORK] = {{{self.number.constant(0.0)}}};")
        body.run(tree.body)
        zero = self.number.constant(0.0)
        if self.torque:
            body.say("if (isfinite(output->torque_right) && isfinite(output->torque_left)) return 1;")
            body.say(f"output->torque_right = output->torque_left = {zero};")
            body.say("return 0;")
        else:
            self._wheels(body, zero)
        if not self.how.memory:
            body.lines.insert(0, "    (void)state;")
        head = (
            f"int {self.name}_step({self.name}_state *state, const {self.name}_input *input, "
            f"{self.name}_output *output) {{"
        )
        return "\n".join([fill(head, 112, subsequent_indent="    "), *body.finished(), "}", ""])

    def _wheels(self, body: Body, zero: str) -> None:
        body.say("/* Within the robot's limits, and onto the wheels: r w_right = v + L w, r w_left = v - L w */")
        body.say("if (!isfinite(output->v) || !isfinite(output->w)) {")
        body.say(f"    output->wheel_right = output->wheel_left = {zero};")
        body.say("    return 0;")
        body.say("}")
        table = "gains" if self.how.gains[: len(LIMITS)] == LIMITS else "limits"
        arguments = [Table(table), Known(0), Term("output->v", "real"), Term("output->w", "real")]
        held = body.called(self.translator.function(within, arguments), arguments, "held")
        half = self.constant(LIMITS[2], self.limits[2]).text
        radius = self.constant("WHEEL_RADIUS m", self.radius).text
        for side, sign in (("right", "+"), ("left", "-")):
            body.say(f"output->wheel_{side} = ({held.name}[0] {sign} {half} * {held.name}[1]) / {radius};")
        body.say("return 1;")

    def _source(self, step: str) -> str:
        real = self.number.name
        upper = self.name.upper()
        functions = [function.text for function in self.translator.done.values()]
        used = set(re.findall(r"\w+", " ".join([*functions, step])))
        constants = []
        for name, held in self.constants.items():
            if name not in used:
                continue
            value = f"{upper}_PERIOD_S" if name == "PERIOD" else self.number.constant(held.value)
            constants.append(f"static const {real} {name} = {value}; /* {comment(held.unit)} */")
        places = ", ".join(f"{name} = {first}" for name, first in (self.how.work or {}).items())
        starts = [
            f"    state->{row.partition(' ')[0]} = {self.number.constant(float(value))};"
            for row, value in zip(self.how.memory, self.memory, strict=True)
        ] or ["    state->nothing = 0;"]
        parts = [
            f"/* The law {comment(self.name)}, in {real}: see {self.name}.h. Made of the law. */",
            "\n".join([f'#include "{self.name}.h"', *(f'#include "{b.name}.h"' for b in self.called.values()), ""]),
            "#include <math.h>\n",
            "/* The gains, and the robot's numbers */\n" + "\n".join(constants) + "\n",
            *([f"/* Places of the numbers that a step works in */\nenum {{{places}}};\n"] if places else []),
            *(piece(name, self.number) for name in PIECES if name in self.arithmetic.needed),
            *functions,
            "\n".join([f"void {self.name}_init({self.name}_state *state) {{", *starts, "}", ""]),
            step,
        ]
        return "\n".join(parts)

    def _header(self, inputs: tuple[str, ...], outputs: tuple[str, ...], look_ahead: float) -> str:
        name, upper, real = self.name, self.name.upper(), self.number.name
        said = {
            "v": "m/s: the speed that the law wants",
            "w": "rad/s: the turn rate that the law wants",
            "wheel_right": "rad/s: the right wheel's speed, within the robot's limits",
            "wheel_left": "rad/s: the left wheel's speed",
            "torque_right": "N m: the right wheel's torque",
            "torque_left": "N m: the left wheel's torque",
        }
        fields = [f"    {real} {f}; /* {_UNITS[f].format(ahead=f'{look_ahead:g}')} */" for f in inputs]
        state = [f"    {real} {n}; /* {comment(u)} */" for n, _, u in (row.partition(" ") for row in self.how.memory)]
        state = state or ["    int nothing; /* this law remembers nothing */"]
        first, second = outputs[-2:] if not self.torque else ("torque_right", "torque_left")
        doc = f" by {self.how.sections}" if self.how.sections else ""
        period = self.number.constant(self.setting.period)
        declared = [
            f"#define {upper}_PERIOD_S {period}",
            *([f"#define {upper}_LOOK_AHEAD_S {self.number.constant(look_ahead)}"] if AHEAD[0] in inputs else []),
            "",
            "typedef struct {",
            *fields,
            f"}} {name}_input;",
            "",
            "typedef struct {",
            *state,
            f"}} {name}_state;",
            "",
            "typedef struct {",
            *(f"    {real} {f}; /* {said[f]} */" for f in outputs),
            f"}} {name}_output;",
            "",
            "/* Nothing is remembered yet. */",
            f"void {name}_init({name}_state *state);",
            "",
            "/* One step; returns 1, or 0 where the command is not finite: the robot must stop. */",
            f"int {name}_step({name}_state *state, const {name}_input *input, {name}_output *output);",
        ]
        text = [
            f"/* The control step of the law {comment(name)}{doc}, for one robot, in {real}.",
            " *",
            f" * Call it every {self.setting.period:g} s:",
            " *",
            f" *     static {name}_state state;",
            f" *     {name}_init(&state);",
            " *     while (wait_for_timer()) {",
            f" *         {name}_input input = {{0}};",
            " *         input.x = ...; ...",
            f" *         {name}_output output;",
            f" *         if (!{name}_step(&state, &input, &output)) stop();",
            f" *         drive(output.{first}, output.{second});",
            " *     }",
            " *",
            " * Frames by REP 103: x ahead, y to the left, headings counter-clockwise. It allocates nothing, and all",
            " * that it remembers is in the state: several robots, several states. */",
            *guarded(name, declared),
        ]
        return "\n".join(text)
