// Step response: a plant, a loop, and the responses of the design, of the file's design and of a PID over time.
// From what fuzzy/plugins/loop/panel.py hands over; the form is anywidget's.

import {
  axes,
  boxed,
  choices,
  color,
  element,
  framed,
  heightLeft,
  heldLine,
  keepDrawn,
  keyed,
  labelled,
  line,
  numbersOf,
  offer,
  pixels,
  plot,
  put,
  said,
  say,
  scale,
  shape,
  watch,
} from "../../designer/static/chart.js";
import { field, formStyled, group, panelForm, row } from "../../designer/static/form.js";
import { chips, settingsSheet } from "../../designer/static/settings.js";

const NAMES = ["choice", "files", "system", "problem"];
const KINDS = { design: "design", file: "before", pid: "PID" };
const kind = (row) => KINDS[row.name] ?? row.name; // or an operating point
const WORDS = {
  error: "error e",
  error_rate: "its rate de/dt",
  error_sum: "its sum ∫e",
  scheduling: "operating variable",
  u: "u, direct",
  du: "du, rate",
};
// Label, name, least value, and what an empty field means
const PLANT = [["Dead time [s]", "dead_time", 0]];
const LOOP = [
  ["Reference", "reference"],
  ["Duration [s]", "duration", 1e-9],
  ["Sample time [s]", "sample_time", 1e-9],
  ["Disturbance at [s]", "disturbance_time", 0],
  ["Its size", "disturbance"],
  ["Least u", "low", "", "none"],
  ["Greatest u", "high", "", "none"],
  ["Measurement noise", "noise", 0],
  ["Rate filter [s]", "rate_filter", 0],
];
const FACTORS = { Ke: "error", Kde: "error_rate", Kie: "error_sum", Ku: "u", Kdu: "du" }; // and what each scales
const GAINS = ["Kp", "Ki", "Kd"].map((name) => [name, name, "", "by rule"]);
const POWERS = { 0: "", 1: "s", 2: "s²", 3: "s³" };
const IN_SIGHT = ["overshoot", "rise_time", "settling_time", "ise", "variation"]; // figures, while one drags
const BAND = 0.02;
const HEIGHTS = { output: 300, control: 240, operating: 150 }; // [px]
const MARGINS = { left: 56, right: 16, below: 54 }; // of a picture [px]
const AFTER = ["peak_deviation", "recovery_time"]; // of a disturbance alone

const short = (value) => Number(value.toPrecision(5));

/** Coefficients as a polynomial of s. */
function polynomial(text) {
  const numbers = String(text)
    .trim()
    .split(/[\s,]+/);
  const terms = numbers.map((number, k) => {
    const power = POWERS[numbers.length - 1 - k] ?? `s^${numbers.length - 1 - k}`;
    return Number(number) === 0 ? "" : power && Number(number) === 1 ? power : `${number} ${power}`.trim();
  });
  return terms.filter(Boolean).join(" + ") || "0";
}

export async function render({ model, el }) {
  await formStyled(import.meta.url, "./step.css");
  const form = panelForm(model, (note) => settings.node.after(note)),
    { get, send, choose, fields } = form;
  let sample = null; // the slider's

  const number = ([label, name, min = "", empty = null]) => field(label, form.number(label, name, { min }, { empty }));
  function text(label, name, placeholder = null) {
    const input = element("input", {
      type: "text",
      "aria-label": label,
      placeholder,
      spellcheck: "false",
      autocomplete: "off",
    });
    input.addEventListener("change", () => choose(name, input.value));
    input.show = (value) => {
      if (document.activeElement !== input && input.value !== value) input.value = value;
    };
    fields[name] = input;
    return field(label, input);
  }
  const folded = (title, ...children) => element("details", {}, element("summary", {}, title), ...children);

  const example = choices("Example", [], "", (value) => value && send({ do: "example", value }));
  const source = form.list("Plant", "source");
  const template = form.act(`Write ${get("template")}`, "template");
  const coefficients = row(
    text("Numerator, highest power first", "numerator"),
    text("Denominator", "denominator"),
    ...PLANT.map(number),
  );
  const fileNote = element(
    "p",
    { class: "pn-note" },
    "The file has plant(x, u, t), which gives dx/dt, a number of states, and may have output(x). It is run on this machine. With operating = [points] it is plant(x, u, t, v).",
  );
  const points = put(row(text("Operating points", "points", "value: numerator; denominator; dead time | value: …")), {
    class: "pn-row st-points",
  });
  const plant = group(
    "Plant",
    row(field("Plant", source), field("Example", example), template),
    coefficients,
    points,
    fileNote,
  );
  const roles = row();
  const roleBox = folded("What the variables are", roles);
  const loop = folded(
    "Reference, disturbance, limits",
    row(...LOOP.map(number), text("Operating variable over time", "operating", "value, or time,value time,value …")),
  );
  const scales = Object.keys(FACTORS).map((name) => number([name, name]));
  const begin = form.act("Start from the PID's gains", "pid"),
    code = form.act("C of the whole controller", "code");
  const factors = put(row(...scales, begin), {
    class: "pn-row st-factors",
    role: "group",
    "aria-label": "Scale factors",
  });
  const rival = folded(
    "Beside it",
    row(form.check("the file's design", "before").node, form.check("a PID", "rival").node, ...GAINS.map(number)),
  );
  const state = element("p", { class: "pn-said", role: "status" });
  const keys = element("div", { class: "pn-keys" });
  const outputs = plot("Output over time"),
    controls = plot("Control over time"),
    plane = plot("Error and error rate");
  const courses = plot("Operating variable over time"),
    shown = form.list("Shown", "shown"),
    showing = row(field("Shown", shown));
  const slider = element("input", { type: "range", min: 0, step: 1, "aria-label": "Time" });
  const at = element("span");
  const time = element("label", { class: "st-time" }, at, slider);
  const table = element("table");
  const scroll = element(
    "div",
    { class: "st-scroll", tabindex: 0, role: "region", "aria-label": "Figures of the responses" },
    table,
  );
  const views = element("div", { class: "pn-views" }, element("div", {}, controls), element("div", {}, plane));
  const results = element(
    "div",
    {},
    showing,
    keys,
    outputs,
    time,
    element("div", {}, courses),
    views,
    scroll,
    row(code),
  );
  const settings = settingsSheet([plant, roleBox, loop, rival]),
    figures = chips("Figures of the response: the file's design, and this one");
  const root = element(
    "div",
    { class: "fd fd-panel fd-form fd-step" },
    settings.node,
    form.note,
    factors,
    figures.node,
    results,
    state,
  );
  el.append(root);

  const looked = framed(() => send({ do: "look", sample }));
  slider.addEventListener("input", () => {
    sample = Number(slider.value);
    looked.soon();
    drawResponse();
  });

  function drawForm() {
    const choice = get("choice");
    for (const [name, input] of Object.entries(fields))
      input.show?.(name in FACTORS ? short(choice[name]) : choice[name]);
    for (const name of ["before", "rival"]) fields[name].checked = choice[name];
    offer(source, [["", "transfer function"], ...get("files").map((name) => [name, name])], choice.source);
    offer(example, [["", "choose …"], ...get("examples")], "");
    coefficients.hidden = choice.source !== "" || choice.points !== "";
    points.hidden = choice.source !== "";
    fileNote.hidden = choice.source === "";
    template.hidden = get("files").includes(get("template"));
    drawRoles();
    drawLine(choice);
    form.drawProblem();
  }

  /** The loop in one line. */
  function drawLine(choice) {
    settings.words([
      choice.source ||
        (choice.points && `${choice.points.split("|").length} operating points`) ||
        `(${polynomial(choice.numerator)}) / (${polynomial(choice.denominator)})`,
      choice.source === "" && choice.points === "" && choice.dead_time > 0
        ? `dead time ${said(choice.dead_time)} s`
        : "",
      `step of ${said(choice.reference)}`,
      `${said(choice.duration)} s`,
      choice.low === null && choice.high === null ? "" : "limits of u",
      choice.rival ? "beside a PID" : "",
    ]);
  }

  function drawRoles() {
    const system = get("system"),
      accepted = get("accepted");
    const key = JSON.stringify(["inputs", "outputs"].map((kind) => system[kind].map((v) => v.name)));
    if (roles.dataset.key !== key) {
      roles.dataset.key = key;
      roles.replaceChildren(
        ...["inputs", "outputs"].flatMap((kind) =>
          system[kind].map((variable) => {
            const select = choices(`What ${variable.name} is`, [], "", (value) =>
              send({ do: "role", variable: variable.name, value }),
            );
            return field(variable.name, select);
          }),
        ),
      );
    }
    const selects = [...roles.querySelectorAll("select")];
    ["inputs", "outputs"].forEach((kind) =>
      system[kind].forEach((variable) => {
        offer(selects.shift(), [["", "not said"], ...accepted[kind].map((name) => [name, WORDS[name]])], variable.role);
      }),
    );
    const lacking = [...system.inputs, ...system.outputs].some((v) => v.role === "");
    if (lacking && !roleBox.open) {
      roleBox.open = true;
      settings.show(true);
    }
    const known = new Set([...system.inputs, ...system.outputs].map(({ role }) => role));
    Object.values(FACTORS).forEach((role, k) => (scales[k].hidden = !known.has(role)));
  }

  const finite = (lists) => lists.flat().filter((v) => v !== null && Number.isFinite(v));

  /** A chart of the rows' lists over time; gives the scales. */
  function drawOver(svg, response, name, label, more, marks) {
    // The first picture is in sight with all that stands above it.
    const above = [factors.clientHeight, keys.clientHeight, figures.node.clientHeight].join(),
      tall = svg === outputs ? heightLeft(svg, above) : Infinity;
    const box = boxed(svg, Math.max(170, Math.min(HEIGHTS[name], tall)), MARGINS);
    const values = [...finite(response.rows.map((r) => r[name])), ...more];
    const low = Math.min(...values),
      high = Math.max(...values),
      room = 0.06 * (high - low || 1);
    const x = scale(0, response.time.at(-1), box.left, box.right),
      y = scale(low - room, high + room, box.bottom, box.top);
    const xs = response.time.map(x);
    const disturbed = response.disturbed;
    numbersOf.set(svg, [
      ["time [s]", ...response.time],
      ...response.rows.map((r) => [`${label}, ${kind(r)}`, ...r[name]]),
    ]);
    svg.replaceChildren(
      axes(box, x, y, ["time [s]", label]),
      ...marks(x, y, box),
      ...(disturbed === null
        ? []
        : [shape("line", { class: "st-disturbed", x1: x(disturbed), x2: x(disturbed), y1: box.top, y2: box.bottom })]),
      ...response.rows
        .map((r, k) => {
          const drawn = name === "control" ? heldLine : line; // a control is held between samples
          return shape("path", { class: classOf(r), style: strokeOf(r, k), d: drawn(xs, pixels(r[name], y)) });
        })
        .reverse(),
      shape("line", { class: "st-now", x1: x(now(response)), x2: x(now(response)), y1: box.top, y2: box.bottom }),
    );
  }

  // A row of an operating point has its own colour.
  const classOf = (r) => (KINDS[r.name] ? `st-${r.name}` : "st-at"),
    strokeOf = (r, k) => (KINDS[r.name] ? null : `stroke: ${color(k)}`);
  const now = (response) => response.time[Math.min(sample ?? 0, response.time.length - 1)];

  function drawResponse() {
    const response = get("response");
    results.hidden = response === null;
    drawFigures(response);
    drawShown(response);
    if (response === null) return say(state, get("problem") ? "" : "The loop is being simulated …");
    const own = response.rows[0],
      reference = response.reference,
      [start] = own.output;
    const reach = BAND * Math.abs(reference - start);
    put(slider, { max: response.time.length - 1 });
    slider.value = String(sample ?? 0);
    say(at, `Time ${said(now(response))} s: the viewer shows what the rules knew then`);
    put(slider, { "aria-valuetext": `${said(now(response))} s` });
    const shown = response.rows.map((r) => r.name).join();
    if (keys.dataset.shown !== shown) {
      keys.dataset.shown = shown;
      keys.replaceChildren(
        ...response.rows.map((r, k) => keyed(classOf(r), kind(r), KINDS[r.name] ? null : color(k))),
        keyed("st-reference", "reference, ±2 %"),
      );
    }
    drawOver(outputs, response, "output", "output y", [reference], (x, y, box) => {
      const marks = [
        shape("rect", {
          class: "st-band",
          x: box.left,
          width: box.right - box.left,
          y: y(reference + reach),
          height: Math.max(1, y(reference - reach) - y(reference + reach)),
        }),
        shape("path", { class: "st-reference", d: line([box.left, box.right], [y(reference), y(reference)]) }),
      ];
      if (own.name !== "design") return marks;
      if (own.figures.overshoot > 0.5) {
        const sign = Math.sign(reference - start),
          until = response.disturbed ?? Infinity;
        const before = own.output.map((v, k) => (response.time[k] <= until ? sign * v : -Infinity));
        const k = before.indexOf(Math.max(...before));
        marks.push(shape("circle", { class: "st-peak", cx: x(response.time[k]), cy: y(own.output[k]), r: 4 }));
        const text = `${said(own.figures.overshoot, 3)} % over`;
        marks.push(shape("text", { x: x(response.time[k]) + 8, y: y(own.output[k]) - 4 }, text));
      }
      if (own.figures.settling_time !== null) {
        const settled = x(own.figures.settling_time);
        marks.push(
          shape("line", { class: "st-disturbed", x1: settled, x2: settled, y1: y(reference + reach), y2: box.bottom }),
          shape("text", { x: settled + 4, y: box.bottom - 6 }, `settled ${said(own.figures.settling_time, 3)} s`),
        );
      }
      return marks;
    });
    others.soon();
  }

  /** What follows the first picture. */
  function drawOthers() {
    const response = get("response");
    if (response === null) return;
    drawOver(controls, response, "control", "control u", [], () => []);
    drawPlane(response);
    drawTable(response);
    const words = response.rows.filter((r) => r.stopped).map((r) => `${kind(r)}: ${r.stopped}.`);
    if (response.rival)
      words.push(
        `PID: Kp ${said(response.rival.Kp)}, Ki ${said(response.rival.Ki)}, Kd ${said(response.rival.Kd)}${response.rival.rule ? `, ${response.rival.rule}` : ""}.`,
      );
    if (response.words) words.push(response.words);
    say(state, words.join(" "));
  }

  /** What may be shown of a plant with operating points, and how their variable moves. */
  function drawShown(response) {
    const values = response?.points ?? [],
      moves = response?.operating ?? null;
    showing.hidden = values.length === 0;
    courses.parentElement.hidden = moves === null;
    const each = values.map((value) => [value, `at ${value}`]);
    offer(shown, [["time", "as the variable moves"], ["points", "each operating point"], ...each], get("choice").shown);
    if (moves !== null)
      drawOver(
        courses,
        { ...response, rows: [{ name: "design", operating: moves }] },
        "operating",
        "operating variable",
        [],
        () => [],
      );
  }

  /** The first figures as chips: what the file's design has, and this one. */
  function drawFigures(response) {
    const of = (name) => response?.rows.find((row) => row.name === name)?.figures;
    const [now, old] = [of("design"), of("file")];
    const rows = !now ? [] : get("titles").filter(([name]) => IN_SIGHT.includes(name));
    figures.update(
      rows.map(([name, title, unit]) => ({
        title: unit ? `${title} [${unit}]` : title,
        unit: "",
        before: old?.[name] ?? undefined,
        now: now[name],
      })),
    );
  }

  /** The way through the first two inputs, over their universes. */
  function drawPlane(response) {
    const [a, b] = get("system").inputs,
      [xs, ys] = response.known;
    plane.parentElement.hidden = !b || !ys;
    if (!b || !ys) return;
    const box = boxed(plane, 240, MARGINS);
    const around = (variable, values, from, to) => {
      const all = [variable.low, variable.high, ...finite([values])];
      const low = Math.min(...all),
        high = Math.max(...all),
        room = 0.05 * (high - low || 1);
      return scale(low - room, high + room, from, to);
    };
    const x = around(a, xs, box.left, box.right),
      y = around(b, ys, box.bottom, box.top);
    const k = Math.min(sample ?? 0, xs.length - 1);
    plane.replaceChildren(
      axes(box, x, y, [`${labelled(a)}, scaled`, `${labelled(b)}, scaled`]),
      shape("rect", {
        class: "st-universe",
        x: x(a.low),
        width: x(a.high) - x(a.low),
        y: y(b.high),
        height: y(b.low) - y(b.high),
      }),
      shape("path", { class: "st-design", d: line(pixels(xs, x), pixels(ys, y)) }),
      ...(xs[k] === null ? [] : [shape("circle", { class: "st-now", cx: x(xs[k]), cy: y(ys[k]), r: 5 })]),
    );
    put(plane, { "aria-label": `The way of ${a.name} and ${b.name}; the frame is their universe` });
  }

  function drawTable(response) {
    const rows = response.rows;
    const head = element(
      "tr",
      {},
      element("th", { scope: "col" }, "Figure"),
      ...rows.map((r) => element("th", { scope: "col" }, kind(r))),
    );
    const body = get("titles")
      .map(([name, title, unit]) => [name, unit ? `${title} [${unit}]` : title, rows.map((r) => r.figures[name])])
      .filter(([name]) => response.disturbed !== null || !AFTER.includes(name))
      .map(([, title, values]) => {
        // The least in size is best, as it is shown; not by colour alone
        const shown = values.map((v) => (v === null ? "–" : said(v)));
        // What does not settle is never the best.
        const counts = (v, k) => v !== null && rows[k].figures.settling_time !== null;
        const compared = values.length > 1 && rows[0].name === "design"; // not one design at several operating points
        const best = said(Math.min(Infinity, ...values.filter(counts).map(Math.abs)));
        const cells = values.map((v, k) => {
          const wins = compared && counts(v, k) && said(Math.abs(v)) === best;
          return element("td", wins ? { class: "st-best" } : {}, shown[k]);
        });
        return element("tr", {}, element("th", { scope: "row" }, title), ...cells);
      });
    table.replaceChildren(element("thead", {}, head), element("tbody", {}, ...body));
  }

  const draw = () => {
    drawForm();
    drawResponse();
  };
  const others = framed(drawOthers);
  // What follows the hand waits for no frame.
  const following = watch(model, ["response"], drawResponse);
  return keepDrawn(model, NAMES, root, draw, () => {
    following();
    others.end();
    looked.end();
    settings.end();
  });
}

export default { render };
