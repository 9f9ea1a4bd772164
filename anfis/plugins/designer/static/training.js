// Train: data and which column is which, a system to start from, the error live, memberships before and after.
// From what anfis/plugins/designer/panel.py hands over; the form is anywidget's.

import {
  axes,
  boxed,
  choices,
  color,
  element,
  keepDrawn,
  keyed,
  labelled,
  line,
  offer,
  pixels,
  plot,
  put,
  quantity,
  say,
  scale,
  shape,
  ticks,
} from "../../../../fuzzy/plugins/designer/static/chart.js";
import { dataPictures } from "../../../../fuzzy/plugins/designer/static/datapictures.js";
import {
  columnField,
  described,
  fillColumns,
  tableFields,
} from "../../../../fuzzy/plugins/designer/static/datasource.js";
import { acts, field, formStyled, group, panelForm, row } from "../../../../fuzzy/plugins/designer/static/form.js";
import { degree, places } from "../../../../fuzzy/plugins/designer/static/membership.js";

const NAMES = [
  "sources",
  "accepted",
  "table",
  "choice",
  "columns",
  "system",
  "progress",
  "before",
  "after",
  "problem",
  "pictures",
  "points",
  "residual",
  "terms",
  "about",
  "unit",
  "lack",
];
const RADIUS = "Cluster radius (share of range)",
  GOAL = "Error goal (RMSE)",
  SHARE = "Checking share [%]";
const NUMBERS = ["radius", "mfs", "epochs", "goal", "share", "seed"];
const STARTS = { present: "the present system", subtractive: "clusters of the data", grid: "a grid of terms" };
const ROLES = [
  ["unused", "not used"],
  ["input", "input"],
  ["output", "output"],
];
const STOPPED = {
  epochs: "all epochs are done",
  goal: "the goal is reached",
  callback: "stopped by hand",
  converged: "no step reduces the error any more",
  diverged: "the error is no longer finite",
  patience: "no progress",
  interrupted: "interrupted",
};

/** Powers of ten, where there are few of them also their double and fivefold, and within a factor of 4 round numbers. */
function decades(low, high) {
  if (high < 4 * low) return ticks(low, high, 4);
  const out = [];
  for (let p = Math.floor(Math.log10(low)) - 1; p <= Math.ceil(Math.log10(high)); p++) {
    for (const m of high / low < 1000 ? [1, 2, 5] : [1]) out.push(m * 10 ** p);
  }
  return out.filter((v) => v >= low * 0.999 && v <= high * 1.001);
}

export async function render({ model, el }) {
  await formStyled(import.meta.url, "../../../../fuzzy/plugins/designer/static/datapictures.css", "./training.css");
  const mapping = element("div", { class: "pn-columns" });
  const form = panelForm(model, (note) => data.before(note), { leads: true, columns: mapping }),
    { get, send, number } = form;

  // Data
  const {
    row: sources,
    file,
    about,
    skip,
  } = tableFields(
    form,
    "File of the folder, or generated",
    (value) => {
      const [kind, name] = [value.slice(0, 1), value.slice(2)];
      drawAsks();
      if (name && asked().length === 0) send({ do: kind === "g" ? "generate" : "file", name });
    },
    () => ({ ...get("accepted"), larger: "use anfis train for large tables" }),
  );
  const asks = element("div", { class: "pn-row", hidden: true });
  /** What the chosen generator asks for. */
  const asked = () => get("sources").generators.find(([name]) => file.value === `g:${name}`)?.[2] ?? [];
  function drawAsks() {
    const wanted = asked(),
      key = JSON.stringify([file.value, wanted]);
    if (asks.dataset.key === key) return;
    asks.dataset.key = key;
    asks.hidden = wanted.length === 0;
    const controls = wanted.map((ask) =>
      ask.options.length
        ? choices(ask.title, ask.options, ask.value, () => {})
        : element("input", { type: "number", min: 1, step: 1, value: ask.value, "aria-label": ask.title }),
    );
    const name = file.value.slice(2);
    const make = () => {
      const chosen = Object.fromEntries(wanted.map((ask, i) => [ask.name, controls[i].value]));
      send({ do: "generate", name, chosen });
      say(about, "making the data …");
    };
    asks.replaceChildren(
      ...wanted.map((ask, i) => field(ask.title, controls[i])),
      element("button", { onclick: make }, "Make the data"),
    );
  }
  const data = group("Data", sources, asks, about);

  // Start and method
  const start = form.list("Start from", "start");
  const radiusField = field(RADIUS, number(RADIUS, "radius", { min: 0.01, max: 2 })),
    mfsField = field("Terms per input", number("Terms per input", "mfs", { min: 2, max: 20, step: 1 }));
  const from = group("Start", row(field("Start from", start), radiusField, mfsField), mapping, skip.node);
  const method = form.list("Method", "method");
  const goal = number(GOAL, "goal", { min: 0 }),
    goalField = field(GOAL, goal);
  const go = form.act("Train", "train", "pn-main"),
    stop = form.act("Stop", "stop"),
    take = form.act("Take the best into the design", "take");
  const how = group(
    "Learning",
    row(
      field("Method", method),
      field("Epochs", number("Epochs", "epochs", { min: 0, max: 100000, step: 1 })),
      goalField,
      field(SHARE, number(SHARE, "share", { min: 0, max: 80 }, { factor: 100 })),
      field("Seed of the split", number("Seed of the split", "seed", { min: 0, step: 1 })),
    ),
  );

  // What comes of it
  const bar = element("progress", { "aria-label": "Epochs done", max: 1, value: 0 });
  const state = element("p", { class: "pn-said", role: "status" });
  const notes = element("div");
  const keys = element("div", { class: "pn-keys" });
  const curve = plot();
  const terms = element("div");
  const views = element("div", { class: "pn-views" }, element("div", {}, keys, curve), terms);
  const drawn = dataPictures({
    look: (row) => send({ do: "look", row }),
    output: (value) => send({ do: "output", value }),
  });
  const root = element(
    "div",
    { class: "fd fd-panel fd-form fd-training" },
    form.note,
    data,
    from,
    how,
    acts([go, stop, take], bar, state),
    notes,
    views,
    drawn.node,
  );
  el.append(root);

  function drawForm() {
    const sources = get("sources"),
      choice = get("choice"),
      accepted = get("accepted"),
      table = get("table"),
      progress = get("progress");
    const options = [
      ["", "choose …"],
      ...sources.files.map((name) => [`f:${name}`, name]),
      ...sources.generators.map(([name, title]) => [`g:${name}`, title]),
    ];
    offer(file, options, options.some(([value]) => value === file.value) ? file.value : "");
    if (file.value === "" && table && sources.files.includes(table.name)) file.value = `f:${table.name}`;
    drawAsks();
    offer(
      start,
      accepted.start.map((name) => [name, STARTS[name]]),
      choice.start,
    );
    offer(method, accepted.method, choice.method);
    for (const name of NUMBERS) form.fields[name].show(choice[name]);
    radiusField.hidden = choice.start !== "subtractive";
    mfsField.hidden = choice.start !== "grid";
    say(
      about,
      table
        ? `${table.name}: ${table.rows} samples, ${table.columns.length} columns`
        : 'The table needs one row per sample, inputs and outputs in columns, below a header such as "speed [m/s]".',
    );
    const aim = get("unit") ? `Error goal (RMSE in ${get("unit")})` : GOAL;
    say(goalField.firstElementChild, aim);
    put(goal, { "aria-label": aim });
    skip.show(get("lack"), choice.skip_bad);
    const running = ["starting", "learning", "stopping"].includes(progress.state);
    go.disabled = running || !table;
    stop.disabled = !running || progress.state === "stopping";
    take.disabled = running || progress.stopped === null;
    form.drawProblem();
    drawMapping(table, choice, get("columns"), get("system"));
  }

  function drawMapping(table, choice, columns, system) {
    mapping.hidden = !table;
    if (!table) return;
    const pick = (name, text, what, options, chosen) =>
      columnField(name, text, what, options, chosen, (of, value) => send({ do: "column", name: of, value }));
    const names = table.columns.map((c) => [c.name, described(c)]);
    const key = JSON.stringify([choice.start === "present", table, columns, system]);
    fillColumns(mapping, key, () => {
      if (choice.start !== "present")
        return table.columns.map((c) => pick(c.name, described(c), "its role", ROLES, columns[c.name] ?? "unused"));
      const of = (kind) => (name) =>
        pick(name, `${name} (${kind})`, "its column", [["", "choose …"], ...names], columns[name] ?? "");
      return [...system.inputs.map(of("input")), ...system.outputs.map(of("output"))];
    });
  }

  function drawProgress() {
    const p = get("progress"),
      last = p.epoch.at(-1) ?? 0;
    put(bar, { max: Math.max(1, p.epochs) });
    bar.value = p.state === "done" ? Math.max(1, p.epochs) : last;
    bar.hidden = p.state === "idle";
    const words = [];
    if (p.state === "starting") words.push("starting …");
    if (p.state === "stopping") words.push("stopping after this epoch …");
    if (p.rules !== null) words.push(`${p.rules} ${p.rules === 1 ? "rule" : "rules"}`);
    if (p.parameters !== null) words.push(`${p.parameters} parameters`);
    if (p.epoch.length) words.push(`epoch ${last}`);
    if (p.best)
      words.push(
        `smallest ${p.best.checked ? "checking" : "training"} error ${quantity(p.best.error, p)} at epoch ${p.best.epoch}${p.first ? ` (${quantity(p.first, p)} at the start)` : ""}`,
      );
    if (p.stopped !== null) words.push(STOPPED[p.stopped] ?? p.stopped);
    say(state, words.join(" · "));
    const told = [...p.words];
    if (p.outputs > 1)
      told.unshift(
        `The ${p.outputs} outputs are learnt together and share their membership functions; the error is the RMSE over all of them.`,
      );
    notes.replaceChildren(...told.map((text) => element("p", { class: "pn-note" }, text)));
  }

  function drawCurve() {
    const p = get("progress");
    const known = [...p.train, ...(p.check ?? [])].filter((v) => v !== null && v > 0);
    curve.parentElement.hidden = known.length === 0;
    if (known.length === 0) return;
    keys.replaceChildren(keyed("tn-train", "training"), ...(p.check ? [keyed("tn-check", "checking")] : []));
    const box = boxed(curve, 280);
    let low = Math.min(...known),
      high = Math.max(...known);
    [low, high] = [low / 1.15, high * 1.15];
    const end = Math.max(
      1,
      p.state === "done" || p.state === "idle" ? p.epoch.at(-1) : Math.min(p.epochs, Math.max(10, 2 * p.epoch.at(-1))),
    );
    const x = scale(0, end, box.left, box.right),
      log = scale(Math.log10(low), Math.log10(high), box.bottom, box.top);
    const y = (v) => (v > 0 ? log(Math.log10(v)) : NaN);
    y.ends = [low, high];
    const drawn = axes(box, x, y, ["epoch", p.unit ? `RMSE [${p.unit}]` : "RMSE"], decades(low, high));
    const over = (values, kind) => shape("path", { d: line(p.epoch.map(x), pixels(values, y)), class: kind });
    const all = [drawn, over(p.train, "tn-train")];
    if (p.check) all.push(over(p.check, "tn-check"));
    if (p.best && p.best.error > 0)
      all.push(shape("circle", { cx: x(p.best.epoch), cy: y(p.best.error), r: 5, class: "tn-best" }));
    curve.replaceChildren(...all);
    put(curve, { "aria-label": `Error over the epochs, logarithmic. ${state.textContent}` });
  }

  function drawTerms() {
    const before = get("before"),
      after = get("after");
    terms.hidden = before === null;
    if (before === null) return;
    const held = terms.clientWidth || root.clientWidth;
    const key = element(
      "div",
      { class: "pn-keys" },
      keyed("tn-before", "before"),
      ...(after ? [keyed("", "after: the best", color(0))] : []),
    );
    const pictures = before.map((variable, i) => {
      const picture = plot(
          `Membership functions of ${variable.name}, ${after ? "before and after" : "before"} learning`,
        ),
        box = boxed(picture, 170, { left: 40, held });
      picture.classList.toggle("tn-many", variable.terms.length > 7);
      const x = scale(variable.low, variable.high, box.left, box.right),
        y = scale(0, 1, box.bottom, box.top);
      const path = (term, kind, stroke) => {
        const xs = places(term.parameters, variable.low, variable.high);
        return shape("path", {
          d: line(
            xs.map(x),
            xs.map((v) => y(degree(term.type, v, term.parameters))),
          ),
          class: kind,
          stroke,
        });
      };
      picture.append(
        axes(box, x, y, [labelled(variable), "degree"], [0, 0.5, 1]),
        ...variable.terms.map((term) => path(term, "tn-before", null)),
      );
      if (after) picture.append(...after[i].terms.map((term, k) => path(term, "", color(k))));
      return picture;
    });
    terms.replaceChildren(key, ...pictures);
  }

  const draw = () => {
    drawForm();
    drawProgress();
    drawCurve();
    drawTerms();
    drawn.draw({
      pictures: get("pictures"),
      points: get("points"),
      residual: get("residual"),
      terms: get("terms"),
      along: { name: "number of the sample", unit: "" },
      outputs: (get("about")?.outputs ?? []).map((name, n) => [n, name]),
      looks: get("about")?.looks ?? false,
    });
  };
  return keepDrawn(model, NAMES, root, draw);
}

export default { render };
