// Tune: what may move, on what and at what cost, the cost as it falls, and the robot's path before and after.
// From what robotics/plugins/designer/tunepanel.py hands over; the form is anywidget's.

import {
  axes,
  boxed,
  choices,
  element,
  heldLine,
  keepDrawn,
  keyed,
  line,
  offer,
  pixels,
  plot,
  put,
  said,
  say,
  scale,
  shape,
} from "../../../../fuzzy/plugins/designer/static/chart.js";
import {
  acts,
  checkBox,
  field,
  formStyled,
  group,
  panelForm,
  row,
} from "../../../../fuzzy/plugins/designer/static/form.js";

const NAMES = [
  "accepted",
  "choice",
  "offer",
  "scenarios",
  "metrics",
  "progress",
  "courses",
  "before",
  "after",
  "left",
  "problem",
];
const PARTS = {
  gains: "gains of the law",
  memberships: "memberships",
  consequents: "consequents",
  weights: "weights of rules",
  choices: "which consequent a rule takes",
  rules: "rules may be left out",
};
const ENGINES = { cmaes: "CMA-ES", random: "random search" };
const NUMBERS = ["runs", "evaluations", "seed"];
const RUNNING = ["starting", "searching", "stopping", "testing"];

export async function render({ model, el }) {
  await formStyled(import.meta.url, "./tuning.css");
  const homes = {}; // by name: what stands above a refusal that no field asked for
  const chosen = {}; // by name: what was chosen here, until Python has it too
  const current = () => ({ ...get("choice"), ...chosen });
  const form = panelForm(model, (note, name) => (homes[name] ? homes[name].after(note) : root.prepend(note)), {
      leads: true,
      chosen: (name, value) => (chosen[name] = value),
    }),
    { get, send, choose, fields, number, act } = form;
  const whole = (label, name, min, max) => field(label, number(label, name, { min, max, step: 1 }));

  // What may move
  const law = form.list("Law", "law");
  const parts = element("div", { class: "tu-checks" }),
    variables = element("div", { class: "tu-checks" });
  const symmetric = checkBox("keep it symmetric: to the left as to the right", (on) => choose("symmetric", on));
  const why = element("p", { class: "pn-note" });
  const moving = group("What may move", row(field("Law", law)), why, parts, variables, symmetric.node);
  /** Checkboxes for the options [value, text], of which those in `on` are set; built anew where they differ. */
  function drawChecks(home, options, on, react) {
    const key = JSON.stringify(options);
    if (home.dataset.key !== key) {
      home.dataset.key = key;
      home.replaceChildren(
        ...options.map(([value, text]) => {
          const { node, input } = checkBox(text, () =>
            react([...home.querySelectorAll("input")].filter((b) => b.checked).map((b) => b.value)),
          );
          input.value = value;
          return node;
        }),
      );
    }
    for (const box of home.querySelectorAll("input")) box.checked = on.includes(box.value);
  }

  // Scenarios and cost
  const scenarios = element("div", {
    class: "tu-checks tu-many",
    role: "group",
    "aria-label": "Scenarios",
    tabindex: 0,
  });
  const noise = checkBox("measure postures with 3 mm and 3 mrad of noise where nothing is random", (on) =>
    choose("noise", on),
  );
  const driven = group("Scenarios", scenarios, noise.node);
  const terms = element("div", { class: "tu-terms" });
  const more = choices("Another term of the cost", [], "", (value) => {
    if (value) choose("terms", [...current().terms, [value, 1, 1]]);
  });
  const priced = group("Cost: the sum of weight × metric / scale", terms, field("Another term", more));
  function drawTerms(rows) {
    const key = rows.map(([name]) => name).join();
    const units = Object.fromEntries((get("metrics") ?? []).map(([name, title, unit]) => [name, { title, unit }]));
    const built = `${key}|${Object.keys(units).length}`;
    if (terms.dataset.key !== built) {
      terms.dataset.key = built;
      const part = (label, min, row, at) =>
        number(
          label,
          null,
          { min },
          {
            react: (value) =>
              choose(
                "terms",
                current().terms.map((term, i) => (i === row ? term.with(at, value) : term)),
              ),
          },
        );
      terms.replaceChildren(
        ...rows.map(([name], row) => {
          const { title = name, unit = "" } = units[name] ?? {};
          const scaled = unit && unit !== "1" ? `Scale [${unit}]` : "Scale";
          return element(
            "div",
            { class: "tu-term", role: "group", "aria-label": title },
            element("span", { title: name }, title),
            field(scaled, part(`${scaled} of ${title}`, 1e-9, row, 1)),
            field("Weight", part(`Weight of ${title}`, 0, row, 2)),
          );
        }),
      );
    }
    const inputs = terms.querySelectorAll("input");
    rows.forEach(([, one, weight], row) => {
      inputs[2 * row].show(Number(one.toPrecision(6)));
      inputs[2 * row + 1].show(weight);
    });
  }

  // The search
  const accepted = get("accepted");
  const engine = form.list("Engine", "engine");
  const start = act("Start", "start", "pn-main"),
    stop = act("Stop", "stop"),
    keep = act("Keep", "keep"),
    discard = act("Discard", "discard");
  const compare = checkBox("show before beside it in the editors", (on) => send({ do: "compare", value: on }));
  const searching = group(
    "Search",
    row(
      whole("Runs (seeds) of each", "runs", 1, accepted.runs),
      whole("Evaluations", "evaluations", 1, accepted.evaluations),
      field("Engine", engine),
      whole("Seed of the search", "seed", 0, 2147483648),
    ),
  );
  const leftText = element("span");
  const goOn = act("Go on", "go on"),
    take = act("Take the best so far", "take"),
    drop = act("Forget it", "forget");
  const left = element("div", { class: "tu-left", hidden: true, role: "status" }, leftText, goOn, take, drop);
  Object.assign(homes, {
    move: parts,
    still: variables,
    scenarios,
    terms,
    noise: noise.input,
    symmetric: symmetric.input,
  });

  // What comes of it
  const bar = element("progress", { "aria-label": "Evaluations done", max: 1, value: 0 });
  const state = element("p", { class: "pn-said", role: "status" });
  const verdict = element("p", { class: "pn-said tu-verdict" });
  const curve = plot(),
    track = plot();
  const course = choices("Path drawn in", [], "", () => drawPath());
  const left1 = element(
    "div",
    { hidden: true },
    element("div", { class: "pn-keys" }, keyed("tu-best", "best so far"), keyed("tu-before", "before")),
    curve,
  );
  const right1 = element(
    "div",
    { hidden: true },
    element(
      "div",
      { class: "pn-keys" },
      keyed("tu-reference", "reference"),
      keyed("tu-before", "before"),
      keyed("tu-best", "best so far"),
    ),
    track,
    field("Path drawn in", course),
  );
  const views = element("div", { class: "pn-views" }, left1, right1);
  const root = element(
    "div",
    { class: "fd fd-panel fd-form fd-tuning" },
    form.note,
    left,
    moving,
    driven,
    priced,
    searching,
    acts([start, stop, keep, discard, compare.node], bar, state),
    verdict,
    views,
  );
  el.append(root);

  function drawForm() {
    for (const [name, value] of Object.entries(chosen))
      if (JSON.stringify(get("choice")[name]) === JSON.stringify(value)) delete chosen[name];
    const choice = current(),
      from = get("offer"),
      progress = get("progress"),
      running = RUNNING.includes(progress.state);
    offer(
      law,
      from.laws.map((use) => [`${use.law}/${use.task}`, use.title]),
      choice.law,
    );
    say(why, from.why ?? "");
    why.hidden = !from.why;
    drawChecks(
      parts,
      accepted.move.map((name) => [name, PARTS[name] ?? name]),
      choice.move,
      (on) => choose("move", on),
    );
    drawChecks(
      variables,
      from.variables.map((name) => [name, `${name} may move`]),
      from.variables.filter((name) => !choice.still.includes(name)),
      (on) =>
        choose(
          "still",
          from.variables.filter((name) => !on.includes(name)),
        ),
    );
    symmetric.node.hidden = !from.symmetric;
    symmetric.input.checked = choice.symmetric;
    drawChecks(
      scenarios,
      get("scenarios").map(([name, title]) => [name, title === name ? name : `${name}: ${title}`]),
      choice.scenarios,
      (on) => choose("scenarios", on),
    );
    noise.input.checked = choice.noise;
    drawTerms(choice.terms);
    offer(more, [["", "choose …"], ...(get("metrics") ?? []).map(([name, title]) => [name, title])], "");
    for (const name of NUMBERS) fields[name].show(choice[name]);
    offer(
      engine,
      accepted.engine.map((name) => [name, ENGINES[name] ?? name]),
      choice.engine,
    );
    for (const set of [moving, driven, priced]) {
      for (const control of set.querySelectorAll("input, select")) control.disabled = running;
    }
    for (const name of [...NUMBERS, "engine"]) fields[name].disabled = running;
    start.disabled = running || from.laws.length === 0;
    stop.disabled = !running || progress.state === "stopping";
    keep.disabled = discard.disabled = running || !progress.undecided;
    compare.node.hidden = !progress.undecided;
    compare.input.checked = progress.compares;
    const rest = get("left");
    left.hidden = rest === null;
    if (rest) {
      say(
        leftText,
        `A search on ${rest.scenarios.join(", ")} was not finished or not decided: ${rest.evaluations} of ${rest.of} evaluations, cost ${said(rest.before)} before, ${said(rest.cost)} at best.`,
      );
    }
    form.drawProblem();
  }

  function drawProgress() {
    const p = get("progress"),
      running = RUNNING.includes(p.state);
    put(bar, { max: Math.max(1, p.of) });
    bar.value = p.evaluations ?? 0;
    bar.hidden = !running;
    const words = [];
    if (p.state === "starting") words.push("starting …");
    if (p.state === "stopping") words.push("stopping after this generation …");
    if (p.state === "testing") words.push("comparing on unseen seeds …");
    if (p.parameters) words.push(`${p.parameters} parameters`);
    if (p.evaluations) words.push(`${p.evaluations} of ${p.of} evaluations`);
    if (p.state !== "idle" || p.evaluations) words.push(`${said(p.seconds, 3)} s`);
    if (p.curve) words.push(`cost ${said(p.curve[0][1])} before, ${said(p.curve.at(-1)[1])} at best`);
    if (p.state === "done" && p.stopped) words.push("stopped by hand");
    if (p.gains) words.push(`gains of the law, which no rule base holds: ${p.gains}`);
    say(state, words.join(" · "));
    const told = [];
    if (p.sentence) told.push(p.sentence.charAt(0).toUpperCase() + p.sentence.slice(1));
    if (p.words) told.push(p.words);
    else if (p.undecided)
      told.push("The editors show the best so far: Keep leaves it in the design as one edit, Discard takes it out.");
    say(verdict, told.map((text) => (text.endsWith(".") ? text : `${text}.`)).join(" "));
  }

  function drawCurve() {
    const p = get("progress");
    left1.hidden = !p.curve;
    if (!p.curve) return;
    const box = boxed(curve, 280);
    const first = p.curve[0][1],
      last = p.curve.at(-1)[1],
      room = Math.max(first - last, first * 0.02) * 0.12;
    const end = RUNNING.includes(p.state) ? p.of : p.evaluations;
    const x = scale(0, Math.max(2, end), box.left, box.right),
      y = scale(Math.max(0, last - room), first + room, box.bottom, box.top);
    curve.replaceChildren(
      axes(box, x, y, ["evaluations", "cost, best so far"]),
      shape("path", { d: line([box.left, box.right], [y(first), y(first)]), class: "tu-before" }),
      shape("path", {
        d: heldLine(
          p.curve.map(([at]) => x(at)),
          p.curve.map(([, cost]) => y(cost)),
        ),
        class: "tu-best",
      }),
    );
    put(curve, { "aria-label": `Cost over the evaluations. ${state.textContent}` });
  }

  function drawPath() {
    const courses = get("courses"),
      before = get("before"),
      after = get("after");
    right1.hidden = courses.length === 0;
    if (courses.length === 0) return;
    const now = courses.some((c, i) => String(i) === course.value) ? course.value : "0";
    offer(
      course,
      courses.map((c, i) => [String(i), c.name]),
      now,
    );
    const at = Number(now),
      paths = [...courses[at].paths, ...(before[at] ?? []), ...(after[at] ?? [])];
    const all = (k) => paths.flatMap((path) => path[k]).filter((v) => v !== null);
    const [xs, ys] = [all(0), all(1)];
    const box = boxed(track, 280);
    // A metre is as long along as across.
    const spans = [Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)];
    const meter = 1.1 * Math.max(spans[0] / (box.right - box.left), spans[1] / (box.bottom - box.top), 1e-6);
    const around = (values, from, to) => {
      const middle = (Math.max(...values) + Math.min(...values)) / 2,
        half = (Math.abs(to - from) * meter) / 2;
      return scale(middle - half, middle + half, from, to);
    };
    const x = around(xs, box.left, box.right),
      y = around(ys, box.bottom, box.top);
    const drawn = (list, kind) =>
      (list ?? []).map((path) =>
        shape("path", {
          class: kind,
          d: line(pixels(path[0], x), pixels(path[1], y)),
        }),
      );
    track.replaceChildren(
      axes(box, x, y, ["x [m]", "y [m]"]),
      ...drawn(courses[at].paths, "tu-reference"),
      ...drawn(before[at], "tu-before"),
      ...drawn(after[at], "tu-best"),
    );
    put(track, {
      "aria-label": `The path in ${courses[at].name}: before${after.length ? ", and with the best so far" : ""}`,
    });
  }

  const draw = () => {
    drawForm();
    drawProgress();
    drawCurve();
    drawPath();
  };
  return keepDrawn(model, NAMES, root, draw);
}

export default { render };
