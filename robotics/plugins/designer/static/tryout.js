// Try it: the rule base in hand drives a robot. Top view, cross-track error and metrics, beside the design before and
// another law; where there are other robots or obstacles the run is played. Several seeds at once are a band, and a
// scenario or robot is edited in place. From what robotics/plugins/designer/session.py hands over; form: anywidget's.

import {
  axes,
  choices,
  clamp,
  color,
  element,
  framed,
  heightLeft,
  keyed,
  line,
  numbersOf,
  offer,
  pixels,
  plot,
  put,
  refill,
  said,
  say,
  scale,
  shape,
  styled,
  watch,
  whenSized,
} from "../../../../fuzzy/plugins/designer/static/chart.js";
import { field, panelForm } from "../../../../fuzzy/plugins/designer/static/form.js";
import { chips, settingsSheet } from "../../../../fuzzy/plugins/designer/static/settings.js";
import { asker, clockwork } from "./moments.js";
import { draggedTime, overTime } from "./overtime.js";
import player from "../../../show/playback/static/player.js";
import { ruleStrip } from "../../../show/playback/static/rulestrip.js";
import { band, bundle, seedStrip, sign } from "./seeds.js";
import { forgetText, textEditor, unsavedTexts } from "./texteditor.js";

const RUNS = [
  ["rival", "tr-rival"],
  ["before", "tr-before"],
  ["tried", "tr-tried"],
]; // the last is drawn on top
const SHEETS = [
  "../../../../fuzzy/plugins/designer/static/panel.css",
  "./tryout.css",
  "./seeds.css",
  "./texteditor.css",
  "../../../show/playback/static/player.css",
];
const NAMES = ["choices", "files", "trial", "course", "before", "rival", "problem", "seeds", "rules"];
const SPEEDS = [0.5, 1, 2, 5, 10, 20];
const COUNTS = [1, 5, 20]; // of seeds that are run at once
const ENDS = { contact: "Contact", stopped: "Stopped", refused: "Refused", failed: "Failed" }; // what became of a run that ended early
const COUNTED = {
  contact: "runs with a contact",
  stopped: "runs with a robot that was stopped",
  refused: "runs refused",
};
const ANOTHER = "?"; // the value of the entry that opens the browser's choice of a file
const WORDS = {
  course: "looking for its place",
  tried: "this design drives",
  before: "the design before drives",
  rival: "the other law drives",
  choices: "reading the scenarios",
  file: "reading the file",
};
const PLAN = [76, 46]; // px of the scenario in small
const LARGEST = 2e6; // bytes of a scenario's file
const CHIPS = 5; // figures in sight while one drags
const FOLLOWING = 100; // ms after which speeds and torques follow a path
const BEFORE = 8; // s before the moment that matters most from which a run is played
const RESTS = 600; // ms without another run after which that begins: to play takes the time that a drag's pictures need

/** The model of a player, as anywidget's: given.turn(name, value) gives it another value, and says so. */
function playerModel(given) {
  const nothing = () => {},
    heard = {};
  given.turn = (name, value) => {
    given[name] = value;
    heard[`change:${name}`]?.();
  };
  return {
    get: (name) => given[name],
    on: (name, f) => (heard[name] = f),
    off: nothing,
    set: nothing,
    save_changes: nothing,
  };
}

/** A number with three digits; a time that never came, and what is not known. */
const figure = (value) => (value === "never" ? "never" : said(value ?? null, 3));
const finite = (values) => values.filter(Number.isFinite);
const points = (data) => (data?.x ? data.x.map((x, i) => [x, data.y[i]]) : []);

export async function render({ model, el }) {
  await styled(import.meta.url, ...SHEETS);
  const form = panelForm(model, (note) => editor.node.after(note)),
    { get, send, choose, fields } = form;
  const state = { share: 1, touched: false, ticks: false, offered: new Map(), widths: new Map(), planes: new Map() };

  // Controls
  const scenario = choices("Scenario", [], "", (value) => {
    if (value === ANOTHER) {
      scenario.value = get("trial").scenario;
      file.click();
    } else choose("scenario", value);
  });
  fields.scenario = scenario;
  const file = element("input", { type: "file", accept: ".toml", hidden: true, "aria-label": "Scenario file" });
  file.addEventListener("change", async () => {
    const [taken] = file.files;
    // Of one that is too large enough is sent to be refused.
    if (taken) send({ do: "file", name: taken.name, text: await taken.slice(0, LARGEST + 1).text() });
    file.value = ""; // the same file may be chosen again after it has been changed
  });
  const robot = form.list("Robot", "robot");
  const robotOf = form.list("Which one is another robot", "robot_of", Number);
  const law = form.list("Law that holds the rule base", "law");
  const rival = form.list("Compare with", "rival");
  // Files come and go while the page is open.
  for (const list of [scenario, robot, rival])
    for (const name of ["pointerdown", "focus"]) list.addEventListener(name, () => send({ do: "list" }));
  const count = form.list("Seeds at once", "count", Number);
  const noise = element("input", { type: "checkbox", onchange: () => choose("noise", noise.checked) });
  const beside = element("input", { type: "checkbox", onchange: () => choose("beside", beside.checked) });
  const besideField = element(
    "div",
    { class: "tr-noise", hidden: true },
    element("label", {}, beside, " Play both side by side"),
  );
  const noiseWords = element("span", { class: "tr-aside" });
  const given = form.list("Laws are given", "given");
  const givenWords = element("span", { class: "tr-aside" });
  const ahead = form.number("Look-ahead [s]", "look_ahead", { min: 0, max: 10 });
  const seed = form.number("First seed of the noise", "seed", { min: 0, step: 1 });
  const lawField = field("Law", law),
    rivalField = field("Compare with", rival, "tr-rivals"),
    robotOfField = field("Which one", robotOf),
    aheadField = field("Look-ahead [s]", ahead);
  const pin = element(
    "button",
    {
      class: "tr-pin",
      title: "Later designs are compared with this one",
      onclick: () => send({ do: "pin" }),
    },
    "Compare from here",
  );
  const word = element("span", { role: "status" }),
    bar = element("progress", { max: 1, "aria-label": "Run in progress" });
  const busy = element("span", { class: "tr-busy" }, word, bar);
  const edit = (what) =>
    element(
      "button",
      { class: "tr-button", "aria-label": `Edit the ${what}'s file`, onclick: () => openEditor(what) },
      "Edit",
    );
  const editRobot = edit("robot");
  const plan = shape("svg", { class: "tr-plan", width: PLAN[0], height: PLAN[1], "aria-hidden": "true", hidden: true });
  const controls = element(
    "div",
    { class: "tr-controls" },
    element("span", { class: "tr-pair" }, field("Scenario", scenario, "tr-scenario"), plan, edit("scenario")),
    element("span", { class: "tr-pair" }, field("Robot", robot, "tr-robots"), editRobot),
    robotOfField,
    lawField,
    aheadField,
    field("First seed", seed),
    field("Seeds", count),
    element("div", { class: "tr-noise" }, element("label", {}, noise, " Noise"), noiseWords),
    field("Laws are given", given),
    givenWords,
    rivalField,
    besideField,
    pin,
  );
  const settings = settingsSheet([controls, file], busy),
    figures = chips("Figures of this design, before and now");
  const editor = textEditor((message) => send(message));
  const kept = element("div", { class: "tr-kept", hidden: true });
  const strip = seedStrip({
    pick: (value) => choose("shown", value),
    weigh: () => send({ do: "weigh" }),
    open: (rule) => seek(state.share * get("course").duration, rule),
  });
  const notes = element("div", { class: "tr-notes" }),
    ends = element("div", { class: "tr-ends" }),
    verdict = element("p", { class: "tr-verdict", hidden: true });

  // Pictures
  const keys = element("div", { class: "pn-keys" });
  const above = put(plot(), { "data-glance": "" }),
    error = plot();
  const clock = element("input", { type: "range", min: 0, max: 1, step: "any", "aria-label": "Time" });
  const reading = element("output");
  const start = element("button", { class: "tr-button", onclick: () => pass() }, "Play");
  const pace = choices(
    "Speed",
    SPEEDS.map((n) => [n, `${n}×`]),
    5,
    () => {},
  );
  const time = element("div", { class: "tr-time" }, start, pace, clock, reading);
  const speed = plot(),
    turning = plot(),
    torques = plot();
  const wheelsFigure = element(
    "div",
    { hidden: true },
    torques,
    element("div", { class: "pn-keys" }, keyed("tr-tried", "right wheel, this design"), keyed("tr-left", "left wheel")),
  );
  const rules = ruleStrip({
    seek: (at) => seek(at),
    open: (rule) => seek(state.share * get("course").duration, rule),
  });
  const single = element(
    "div",
    {},
    keys,
    element("div", { class: "pn-views" }, above),
    time,
    rules.node,
    element("div", { class: "pn-views" }, error, speed, turning, wheelsFigure),
  );
  const stage = element("div", { class: "fleet-player" }),
    rivalStage = element("div", { class: "fleet-player" });
  const stageTitle = element("figcaption", { hidden: true }, "This design"),
    rivalTitle = element("figcaption", {});
  const rivalFigure = element("figure", { hidden: true }, rivalTitle, rivalStage);
  const stages = element("div", { class: "tr-stages" }, element("figure", {}, stageTitle, stage), rivalFigure);
  const all = plot();
  const every = element("figure", { class: "tr-every", hidden: true }, element("figcaption", {}, "All seeds"), all);
  const table = element(
    "table",
    { class: "tr-metrics" },
    element("caption", { hidden: true }, "Metrics"),
    element("thead"),
    element("tbody"),
  );
  const parts = [
    settings.node,
    figures.node,
    kept,
    editor.node,
    form.note,
    notes,
    ends,
    verdict,
    strip.node,
    every,
    single,
    stages,
    table,
  ];
  const root = element("div", { class: "fd fd-panel fd-tryout" }, ...parts);
  el.append(root);

  const label = (name, data) => {
    const trial = get("trial");
    if (name === "tried") return "this design";
    if (name === "before") return `design ${data.label}`;
    return get("choices")?.rivals[trial.kind]?.find(([value]) => value === trial.rival)?.[1] ?? trial.rival;
  };
  const touched = (data) => (data.contacts ?? []).length > 0;
  const shown = () =>
    RUNS.map(([name, kind]) => [name, kind, get(name)]).filter(([, , data]) => data !== null && !data.why);

  const option = (value, text, attributes = {}) => element("option", { value, ...attributes }, text);
  /** A law as it is offered: with what it does not look at in the scenario. */
  const marked = (course, name, title) => (course?.marks?.[name] ? `${title} (${course.marks[name]})` : title);
  const group = (label, options) => (options.length ? element("optgroup", { label }, ...options) : "");

  /** Offer groups of options; an open list is left alone while nothing in it changes. */
  function offerGroups(select, groups, chosen) {
    const nodes = groups.filter(Boolean),
      text = nodes.map((node) => node.outerHTML).join("");
    if (text !== state.offered.get(select)) select.replaceChildren(...nodes);
    state.offered.set(select, text);
    select.value = chosen;
  }

  /** The scenarios in their groups: those that show what the system does, the folder's files, and the others. */
  function offerScenarios(known, trial, course) {
    const kinds = [...new Set((course?.laws ?? []).flatMap(([, , , each]) => each))];
    // As on the command line, in brackets
    const full = ({ name, title }) => (title === name ? name : `${title} [${name}]`);
    const title = (name) => full(known?.scenarios.find((s) => s.name === name) ?? { name, title: name });
    const files = get("files")?.scenarios ?? [];
    const suggested = known ? (course?.suggested ?? []) : [];
    const listed = new Set([...suggested, ...files, ...(known?.scenarios.map((s) => s.name) ?? [])]);
    const rest = (known?.scenarios ?? []).filter((s) => !suggested.includes(s.name));
    const possible = (s) => kinds.length === 0 || kinds.includes(s.kind);
    const chosen = listed.has(trial.scenario) ? [] : [trial.scenario];
    const groups = [
      ...chosen.map((name) => option(name, course?.title ?? (name || "to suit the rule base"))),
      group(
        "Suited to this rule base",
        suggested.map((name) => option(name, title(name))),
      ),
      group("Files in this folder", [...files.map((name) => option(name, name)), option(ANOTHER, "Another file …")]),
      ...(known?.groups ?? []).map((name) =>
        group(
          name,
          rest
            .filter((s) => s.group === name)
            .map((s) => option(s.name, full(s), possible(s) ? {} : { disabled: true, title: "no law that it fits" })),
        ),
      ),
    ];
    offerGroups(scenario, groups, trial.scenario);
    scenario.title = title(trial.scenario);
    drawPlan(course);
  }

  /** The scenario in small, beside its name: paths, obstacles, and where robots start. */
  function drawPlan(course) {
    plan.toggleAttribute("hidden", course === null);
    if (course === null || course === state.planned) return;
    state.planned = course;
    const lines = [...course.paths.map((p) => [p.x, p.y]), ...(course.obstacles ?? [])];
    const [across, up] = [0, 1].map((k) => finite([...lines.flatMap((p) => p[k]), ...course.starts.map((s) => s[k])]));
    const [x0, x1, y0, y1] = [Math.min(...across), Math.max(...across), Math.min(...up), Math.max(...up)];
    const unit = Math.min((PLAN[0] - 8) / (x1 - x0 || 1), (PLAN[1] - 8) / (y1 - y0 || 1));
    const x = (value) => PLAN[0] / 2 + unit * (value - (x0 + x1) / 2),
      y = (value) => PLAN[1] / 2 - unit * (value - (y0 + y1) / 2);
    plan.replaceChildren(
      ...lines.map(([xs, ys], k) =>
        shape("path", { d: line(xs.map(x), ys.map(y)), class: k < course.paths.length ? "tr-course" : "tr-obstacle" }),
      ),
      ...course.starts.map(([sx, sy]) => shape("circle", { cx: x(sx), cy: y(sy), r: 2.5, class: "tr-tried" })),
    );
  }

  /** The robots: that of the scenario, the package's and the folder's. */
  function offerRobots(known, trial, course) {
    const packaged = known?.robots ?? [],
      files = get("files")?.robots ?? [];
    const listed = ["", ...packaged.map(([name]) => name), ...files];
    const chosen = listed.includes(trial.robot ?? "") ? [] : [trial.robot];
    const named = (names) => names.map((name) => option(name, name));
    const groups = [
      option("", "as the scenario says"),
      ...named(chosen),
      group(
        "Of the package",
        packaged.map(([name, title]) => option(name, title)),
      ),
      group("Files in this folder", named(files)),
    ];
    offerGroups(robot, groups, trial.robot ?? "");
    editRobot.disabled = !trial.robot;
    const robots = course?.starts.length ?? 1;
    robotOfField.hidden = !trial.robot || robots < 2;
    const each = Array.from({ length: robots }, (_, k) => [String(k + 1), `robot ${k + 1}`]);
    offer(robotOf, [["0", "all robots"], ...each], String(trial.robot_of ?? 0));
  }

  /** What there is to compare with: laws of the catalogue, and the folder's rule bases and Python files. */
  function offerRivals(known, trial, course) {
    const laws = get("files")?.laws ?? [],
      listed = known?.rivals[trial.kind] ?? [];
    const missing = laws.includes(trial.rival) || listed.some(([name]) => name === trial.rival) ? [] : [trial.rival];
    const groups = [
      ...missing.filter(Boolean).map((name) => option(name, name)),
      group(
        "Laws",
        listed.map(([name, title]) => option(name, marked(course, name, title))),
      ),
      group(
        "Files in this folder; Python runs once chosen",
        laws.map((name) => option(name, name)),
      ),
    ];
    offerGroups(rival, groups, trial.rival);
  }

  /** What is chosen, in one line. */
  function drawLine(known, trial, course) {
    if (course === null) return settings.words(["to suit the rule base"]);
    const seeds = trial.count ?? 1;
    const driven = (course.laws ?? []).find(([name, task]) => name === trial.law && task === trial.task);
    const robots = known?.robots.find(([name]) => name === trial.robot)?.[1] ?? trial.robot;
    settings.words([
      course.scenario,
      robots,
      driven?.[2],
      seeds > 1 ? `${seeds} seeds from ${trial.seed}` : `seed ${trial.seed}`,
      trial.noise === false ? "no noise" : "",
      known?.given.find(([value]) => value === trial.given && value !== "")?.[1],
      trial.rival ? `against ${label("rival", null)}` : "",
    ]);
  }

  /** The first figures as chips: what the design before has, and this one. */
  function drawFigures() {
    const course = get("course"),
      [tried, before] = [get("tried"), get("before")];
    if (course === null || tried === null || tried.why) return figures.update([]);
    const runs = get("seeds")?.runs;
    const of = (name, data) => (runs ? runs[name]?.median : data && !data.why ? data.metrics : null);
    const [now, old] = [of("tried", tried), of("before", before)];
    figures.update(
      course.metrics
        .filter(({ name }) => now?.[name] !== undefined && now[name] !== null)
        .slice(0, CHIPS)
        .map(({ name, title, unit, larger }) => ({ title, unit, larger, before: old?.[name], now: now[name] })),
    );
  }

  function openEditor(what) {
    if (editor.node.hidden || get("editor")?.what !== what) send({ do: "edit", what });
    editor.open();
  }

  /** Texts that were edited here and never saved. */
  function drawKept() {
    const open = get("editor");
    const texts = unsavedTexts().filter(([what, name]) => !(open?.what === what && open.name === name));
    kept.hidden = texts.length === 0 || state.asked === true;
    const row = ([what, name]) => {
      const done = () => ((state.asked = true), (kept.hidden = true));
      const act = (text, onclick) => element("button", { class: "tr-button", onclick }, text);
      return element(
        "p",
        {},
        `Unsaved edits of the ${what} ${name} are kept in this browser. `,
        act("Take them up", () => {
          done();
          choose(what, name);
          send({ do: "edit", what });
        }),
        " ",
        act("Discard", () => {
          forgetText(what, name);
          drawKept();
        }),
      );
    };
    kept.replaceChildren(...texts.map(row));
  }

  function drawControls() {
    const known = get("choices"),
      course = get("course"),
      trial = get("trial");
    offerScenarios(known, trial, course);
    const laws = course?.laws ?? [];
    offer(
      law,
      laws.map(([name, task, title]) => [`${name}/${task}`, marked(course, name, title)]),
      `${trial.law}/${trial.task}`,
    );
    offerRobots(known, trial, course);
    offerRivals(known, trial, course);
    offer(
      count,
      COUNTS.map((n) => [n, String(n)]),
      trial.count ?? 1,
    );
    noise.checked = trial.noise ?? true;
    const drawn = course?.noises ?? [];
    const off = noise.checked ? "off takes away" : "taken away";
    const some = `${off}: ${drawn.join(", ")}; encoders, latency and faults stay`;
    say(noiseWords, course === null ? "" : drawn.length ? some : "this scenario has none");
    offer(given, known?.given ?? [], trial.given ?? "");
    const untaken = trial.given ? (course?.untaken ?? []) : [];
    say(givenWords, untaken.length ? `this law has ${untaken.join("; ")}` : "");
    rivalField.hidden = pin.hidden = course === null;
    drawLine(known, trial, course);
    lawField.hidden = laws.length < 2;
    aheadField.hidden = !course?.ahead;
    ahead.show(trial.look_ahead);
    seed.show(trial.seed);
    form.drawProblem();
  }

  /** What was to be feared before the runs, how they ended early, and what else is to be said of them. */
  function drawEnds() {
    const found = (get("tried")?.outcomes ?? []).length ? "" : (get("tried")?.verdict ?? "");
    verdict.hidden = found === "";
    say(verdict, found === "" ? "" : `This design: ${found}.`);
    const boxes = new Map(),
      warned = new Map(),
      told = [];
    const gather = (into, key, name, data) => into.set(key, [...(into.get(key) ?? []), [name, label(name, data)]]);
    for (const [name] of [...RUNS].reverse()) {
      const data = get(name);
      if (data === null) continue;
      for (const text of data.warned ?? []) gather(warned, text, name, data);
      const found = data.why ? [[data.failed ? "failed" : "refused", data.why]] : (data.outcomes ?? []);
      for (const [kind, text] of found) gather(boxes, `${kind}:${text}`, name, data);
      for (const note of data.notes ?? []) told.push(`${label(name, data)}: ${note}`);
    }
    const names = (who) => who.map(([, text]) => text).join(", ");
    const before = [...warned].map(([text, who]) => {
      const head = element("strong", {}, `Before the run: ${names(who)}.`);
      return element("p", { class: "tr-end tr-end-warned" }, head, ` ${text}`);
    });
    const after = [...boxes].map(([key, who]) => {
      const [, kind, text] = /^(\w+):(.*)$/s.exec(key);
      const head = element("strong", {}, `${ENDS[kind]}: ${names(who)}.`);
      const looks = `tr-end tr-end-${kind} ${who.some(([name]) => name === "tried") ? "" : "tr-end-other"}`;
      return element("p", { class: looks }, sign(kind, 14), head, ` ${text}`);
    });
    notes.replaceChildren(...before);
    ends.replaceChildren(...after, ...told.map((text) => element("p", { class: "pn-note" }, text)));
  }

  function drawKeys() {
    refill(
      keys,
      keyed("tr-reference", "reference"),
      ...shown()
        .reverse()
        .map(([name, kind, data]) => keyed(kind, label(name, data))),
      ...(get("seeds") ? [keyed("tr-seed", "its other seeds; the band holds all of them")] : []),
    );
  }

  /** What the top view shows: all of the paths, and as much of the runs as leaves the paths large. */
  function bounds(course) {
    const all = [...course.paths.map((p) => [p.x, p.y]), ...(course.obstacles ?? [])],
      spans = [];
    for (const k of [0, 1]) {
      const fixed = finite([...all.flatMap((p) => p[k]), ...course.starts.map((s) => s[k])]);
      let low = Math.min(...fixed),
        high = Math.max(...fixed);
      const room = 0.3 * Math.max(0.5, high - low);
      const runs = [...shown().map(([, , data]) => data), ...(get("seeds")?.rows ?? [])];
      const moved = finite(runs.flatMap((data) => points(data).flatMap((p) => p[k])));
      low = Math.min(low, Math.max(low - room, Math.min(...moved, low)));
      high = Math.max(high, Math.min(high + room, Math.max(...moved, high)));
      spans.push([low, high]);
    }
    return spans;
  }

  /** The width of a picture [px], measured once a width of the panel: each measuring lays the whole page out anew. */
  function measured(svg) {
    if (!state.widths.has(svg) && svg.clientWidth) state.widths.set(svg, svg.clientWidth);
    return Math.max(240, state.widths.get(svg) ?? root.clientWidth);
  }

  /** What is left for the top view's plane where it, the time and the strip of rules are in sight together [px]. */
  function room() {
    const parts = [figures.node, strip.node, editor.node, form.note, kept].map(({ hidden }) => hidden);
    return clamp(heightLeft(above, [shown().length, measured(above), ...parts]) - 182, 180, 380);
  }

  /** The picture of the plane: paths to follow and starts, and between them what `fill` draws. */
  function plane(svg, tallest, fill) {
    const course = get("course");
    const width = measured(svg),
      box = { left: 52, right: width - 10, top: 26, bottom: 0 };
    const [[x0, x1], [y0, y1]] = bounds(course);
    const pad = 0.06 * Math.max(x1 - x0, y1 - y0, 0.2),
      wide = x1 - x0 + 2 * pad,
      high = y1 - y0 + 2 * pad;
    const tall = Math.min(tallest, Math.max(200, ((box.right - box.left) * high) / wide));
    box.bottom = box.top + tall;
    // Equal axes: the same pixels a metre in both directions, the rest is left over round the middle.
    const unit = Math.min((box.right - box.left) / wide, tall / high);
    const middle = [(x0 + x1) / 2, (y0 + y1) / 2],
      half = [(box.right - box.left) / unit / 2, tall / unit / 2];
    const x = scale(middle[0] - half[0], middle[0] + half[0], box.left, box.right);
    const y = scale(middle[1] - half[1], middle[1] + half[1], box.bottom, box.top);
    const height = box.bottom + 44;
    // While its axes stay, only what is filled in is another.
    const kept = state.planes.get(svg),
      key = JSON.stringify([width, height, x.ends, y.ends]);
    if (kept?.course === course && kept.key === key) {
      kept.filled.replaceChildren();
      fill(kept.filled, x, y);
      return { ...kept, x, y };
    }
    const id = `tr-${Math.random().toString(36).slice(2)}`,
      filled = shape("g");
    put(svg, { viewBox: `0 0 ${width} ${height}`, height });
    const clip = shape(
      "clipPath",
      { id },
      shape("rect", { x: box.left, y: box.top, width: box.right - box.left, height: tall }),
    );
    const drawn = shape("g", { "clip-path": `url(#${id})` });
    for (const path of course.paths)
      drawn.append(shape("path", { d: line(path.x.map(x), path.y.map(y)), class: "tr-reference" }));
    for (const [xs, ys] of course.obstacles ?? [])
      drawn.append(shape("path", { d: line(xs.map(x), ys.map(y)), class: "tr-obstacle" }));
    fill(filled, x, y);
    drawn.append(filled);
    for (const [sx, sy, heading] of course.starts) {
      drawn.append(
        shape("path", {
          d: "M9 0L-6 6L-3 0L-6 -6Z",
          class: "tr-start",
          transform: `translate(${x(sx)} ${y(sy)}) rotate(${(-heading * 180) / Math.PI})`,
        }),
      );
    }
    svg.replaceChildren(clip, axes(box, x, y, ["x [m]", "y [m]"]), drawn);
    state.planes.set(svg, { course, key, filled, drawn });
    return { x, y, drawn };
  }

  /** Where something touched: a cross, with who in words. */
  function markContacts(drawn, x, y, rows) {
    for (const { contacts, seed: of } of rows)
      for (const [at, cx, cy, who] of contacts ?? [])
        drawn.append(
          shape(
            "path",
            {
              d: "M-5 -5L5 5M-5 5L5 -5",
              class: "tr-contact",
              transform: `translate(${x(cx)} ${y(cy)})`,
            },
            shape("title", {}, `contact at ${said(at, 2)} s: ${who}${of === undefined ? "" : `, seed ${of}`}`),
          ),
        );
  }

  function drawAbove() {
    const course = get("course");
    const { x, y, drawn } = plane(above, room(), (into, across, up) => {
      into.append(bundle(get("seeds"), across, up));
      for (const [name, kind, data] of shown()) {
        for (const [xs, ys] of points(data))
          into.append(
            shape("path", {
              d: line(pixels(xs, across), pixels(ys, up)),
              class: kind,
              "data-run": name,
            }),
          );
      }
    });
    put(above, {
      "aria-label": `Top view of ${course.title}: the reference, the start and the path of ${shown()
        .map(([n, , d]) => label(n, d))
        .reverse()
        .join(", ")}`,
    });
    numbersOf.set(
      above,
      shown().flatMap(([name, , data]) =>
        points(data).flatMap(([xs, ys], k) => [
          [`x [m], ${name} ${k + 1}`, ...xs],
          [`y [m], ${name} ${k + 1}`, ...ys],
        ]),
      ),
    );
    state.above = { x, y, drawn, timeAt: (...at) => timeNear(...at) };
  }

  /** When the design's robot was nearest to a place on the screen. */
  function timeNear(clientX, clientY) {
    const data = get("tried"),
      box = above.getBoundingClientRect(),
      unit = above.viewBox.baseVal.width / box.width;
    const [px, py] = [(clientX - box.left) * unit, (clientY - box.top) * unit];
    let best = 0,
      least = Infinity;
    data?.x?.[0].forEach((value, k) => {
      if (value === null) return;
      const gap = Math.hypot(state.above.x(value) - px, state.above.y(data.y[0][k]) - py);
      if (gap < least) [best, least] = [k, gap];
    });
    return data?.time?.[best] ?? 0;
  }

  /** All seeds of a run that is played: a colour for each robot, the seed that is played strong, contacts marked. */
  function drawEvery() {
    const seeds = get("seeds"),
      course = get("course"),
      drawn = seeds?.rows.some((row) => row.x) ?? false;
    // While the design is edited the last picture stays, faint, so that what is below it does not jump.
    const old = seeds === null && (get("trial").count ?? 1) > 1 && state.every === course.scenario;
    every.hidden = !drawn && !old;
    every.classList.toggle("se-stale", old);
    if (!drawn) return;
    state.every = course.scenario;
    plane(all, 460, (drawn, x, y) => {
      drawn.append(bundle(seeds, x, y, color));
      markContacts(drawn, x, y, seeds.rows);
    });
    const names = course.starts.map((_, k) => `robot ${k + 1}`).join(", ");
    put(all, { "aria-label": `Top view of the paths of ${names} in ${seeds.count} seeds; contacts are marked` });
  }

  /** Draw curves over time, as overTime does, of all runs; `words` say what they are of. */
  function drawOver(svg, given, words) {
    const width = measured(svg),
      size = { width, height: given.height };
    const who = shown().map(([n, , d]) => label(n, d));
    put(svg, { "aria-label": `${words} over time of ${who.reverse().join(", ")}` });
    return overTime(svg, { duration: get("course").duration, ...given, size });
  }

  function drawError() {
    const seeds = get("seeds");
    state.error = drawOver(
      error,
      {
        title: "cross-track error [m], left of the path > 0",
        height: 240,
        least: [-0.005, 0.005],
        curves: shown().flatMap(([run, kind, data]) =>
          (data.cross_track ?? []).map((values) => ({ kind, run, time: data.time, values })),
        ),
        bounds: (seeds?.rows ?? []).flatMap((row) => (row.cross_track ?? []).flat()),
        under: (x, y) => band(seeds, x, y),
      },
      "Cross-track error",
    );
  }

  /** The speeds beside their references, and the wheels' torques: they follow, so that a drag's path is not late. */
  function drawMotion() {
    state.following = 0;
    const runs = shown(),
      tried = get("tried");
    if (get("course") === null || get("course").played) return;
    const moving = (name, among = runs) =>
      among.flatMap(([run, kind, data]) =>
        (data.motion?.[name] ?? []).map((values) => ({ kind, run, time: data.motion.time, values })),
      );
    const due = (name) =>
      (tried?.reference?.[name] ?? []).map((values) => ({ kind: "tr-reference", time: tried.motion.time, values }));
    const look = { height: 220, least: [-1e-3, 1e-3] };
    state.speed = drawOver(
      speed,
      { ...look, title: "speed v [m/s]", curves: [...due("v"), ...moving("v")] },
      "Speed beside that of the reference",
    );
    state.turning = drawOver(
      turning,
      { ...look, title: "turn rate ω [rad/s]", curves: [...due("w"), ...moving("w")] },
      "Turn rate beside that of the reference",
    );
    // Of the design alone: six curves of torques tell nothing apart.
    const mine = runs.filter(([name]) => name === "tried");
    const wheels = ["torque_right", "torque_left"].flatMap((name) =>
      moving(name, mine).map((curve) => ({ ...curve, kind: name === "torque_left" ? "tr-left" : "tr-tried" })),
    );
    wheelsFigure.hidden = wheels.length === 0;
    state.wheels = wheels.length
      ? drawOver(torques, { ...look, title: "wheel torque [N m]", curves: wheels }, "Torques of both wheels")
      : null;
    pointOut();
  }
  const errors = framed(() => {
    if (get("course") === null || get("course").played) return;
    drawError();
    pointOut();
  });
  /** Move the dots of all pictures over time. */
  function pointOut() {
    const at = state.share * get("course").duration;
    for (const picture of [state.error, state.speed, state.turning, state.wheels]) picture?.at(at);
  }

  function drawMoment() {
    const course = get("course"),
      at = state.share * course.duration,
      words = [];
    put(clock, { max: course.duration });
    clock.value = at;
    state.above.drawn.querySelectorAll("circle").forEach((dot) => dot.remove());
    for (const [name, kind, data] of shown()) {
      if (!data.time) continue;
      const k = sampleAt(data, at);
      data.x.forEach((xs, i) => {
        if (xs[k] === null) return;
        state.above.drawn.append(
          shape("circle", { cx: state.above.x(xs[k]), cy: state.above.y(data.y[i][k]), r: 5, class: kind }),
        );
        if (name === "tried") words.push(`${said(data.cross_track[i][k], 3)} m`);
      });
    }
    pointOut();
    rules.at(at);
    say(reading, `${at.toFixed(1)} s${words.length ? `: ${words.join(", ")}` : ""}`);
    put(clock, { "aria-valuetext": reading.textContent });
  }
  const sampleAt = (data, at) =>
    Math.min(data.time.length - 1, Math.round((at / get("course").duration) * (data.time.length - 1)));

  // The time that one looks at

  /** Look at a time [s]: all pictures here, and what the robot knew then in the viewer; `rule` leads to a rule. */
  function seek(time, rule = null) {
    const { duration } = get("course");
    state.share = Math.min(1, Math.max(0, time / (duration || 1)));
    drawMoment();
    ask({ time: state.share * duration, robot: 0, rule });
  }
  const moments = asker((moment) => send({ do: "time", ...moment }));
  const ask = moments.ask;
  const passing = clockwork(
    (seconds) => {
      const { duration } = get("course"),
        to = state.share * duration + seconds * Number(pace.value);
      seek(Math.min(duration, to));
      return to < duration;
    },
    (on) => say(start, on ? "Pause" : "Play"),
  );
  function pass() {
    if (!passing.on && state.share >= 1) seek(0);
    passing.toggle();
  }

  /** Which rule ruled when, of the run that is drawn; it is found once the design rests. */
  function drawRules() {
    const found = get("rules"),
      run = get("tried")?.number;
    if (run !== undefined && found?.number !== run) return; // the last one stays until then
    rules.update(found);
  }

  function drawTable() {
    const course = get("course"),
      runs = shown().reverse(),
      several = course.starts.length > 1,
      seeds = get("seeds");
    const of = several ? "mean of the robots; of contacts and clearances the worst" : "";
    const head = element(
      "tr",
      {},
      element(
        "th",
        { scope: "col" },
        seeds ? `median of ${seeds.count} seeds, and the worst${of && `; ${of}`}` : `one seed${of && `; ${of}`}`,
      ),
      ...runs.map(([name, , data]) =>
        element("th", { scope: "col" }, label(name, data) + (!seeds && touched(data) ? " ✕ contact" : "")),
      ),
    );
    const rows = seeds ? seedRows(course, runs, seeds.runs) : course.metrics.map((metric) => runRow(metric, runs));
    refill(table.tHead, head);
    refill(table.tBodies[0], ...rows);
  }

  const titled = (metric) =>
    element("th", { scope: "row" }, metric.unit === "1" ? metric.title : `${metric.title} [${metric.unit}]`);

  /** Not by colour alone: the best is bold, and equal ones are all best. What touched is never the best. */
  function bestOf(metric, values, counts) {
    const size = values.map((value, n) =>
      typeof value === "number" && counts[n] ? (metric.larger ? -value : value) : Infinity,
    );
    const best = Math.min(...size);
    return size.map((each) => values.length > 1 && Number.isFinite(best) && each === best);
  }

  function runRow(metric, runs) {
    const values = runs.map(([, , data]) => data.metrics[metric.name]);
    const best = bestOf(
      metric,
      values,
      runs.map(([, , data]) => !touched(data)),
    );
    const share = (data) => {
      const part = data.shares?.[metric.name];
      return typeof part === "number" ? [element("span", { class: "tr-worst" }, `${Math.round(100 * part)} %`)] : [];
    };
    const cell = (value, n) => element("td", best[n] ? { class: "tr-best" } : {}, figure(value), ...share(runs[n][2]));
    return element("tr", {}, titled(metric), ...values.map(cell));
  }

  /** The lines of several seeds: how many runs ended early, then each metric's median above its worst. */
  function seedRows(course, runs, known) {
    const summaries = runs.map(([name]) => known[name] ?? null);
    const counted = Object.keys(COUNTED).filter((state) => summaries.some((each) => each?.[state]));
    const counts = counted.map((state) =>
      element(
        "tr",
        { class: "tr-counts" },
        element("th", { scope: "row" }, COUNTED[state]),
        ...summaries.map((each) => element("td", {}, each ? `${each[state]} of ${each.runs}` : "…")),
      ),
    );
    const rows = course.metrics
      .filter((metric) => metric.name !== "contacts")
      .map((metric) => {
        const middle = summaries.map((each) => each?.median[metric.name] ?? null);
        const best = bestOf(
          metric,
          middle,
          summaries.map((each) => each !== null && !each.contact),
        );
        const cell = (each, n) => {
          if (each === null) return element("td", {}, "…");
          const worst = element("span", { class: "tr-worst" }, figure(each.worst[metric.name]));
          return element("td", best[n] ? { class: "tr-best" } : {}, figure(middle[n]), worst);
        };
        return element("tr", {}, titled(metric), ...summaries.map(cell));
      });
    return [...counts, ...rows];
  }

  /** The player of a run that is played; it stays while the scenario does, and shows every new run. */
  function playerIn(stage) {
    const player_ = { stage, given: null, run: null, stop: null };
    player_.end = () => {
      player_.stop?.();
      stage.replaceChildren();
      Object.assign(player_, { given: null, run: null, stop: null });
    };
    player_.button = () => stage.querySelector("button.play");
    /** Show a run, from a time [s] on; null: from the one that was shown. */
    player_.show = (run, time, more) => {
      if (run === player_.run) return false;
      const { scenario } = get("trial");
      if (run === null || player_.given?.scenario !== scenario) player_.end();
      player_.run = run;
      if (run === null) return false;
      if (player_.given === null) {
        player_.given = { run, speed: 5, scenario, ...more };
        player_.stop = player.render({ model: playerModel(player_.given), el: stage });
        if (time !== null) player_.given.turn("time", time);
        return true;
      }
      const speed = Number(stage.querySelector(".controls select, select")?.value) || 5;
      Object.assign(player_.given, { speed, time });
      player_.given.turn("run", run);
      return true;
    };
    return player_;
  }
  const main = playerIn(stage),
    other = playerIn(rivalStage);
  const task = () => get("trial")?.task;
  const told = ({ time: at, robot: who, rule, task: of }) =>
    ask({ time: at, robot: who, rule: of === null || of === task() ? rule : null });
  /** Both players have one clock: what one shows the other shows too. */
  const ticked = (from, to) => (t) => {
    if (state.ticks || to.given === null || from.given === null) return;
    state.ticks = true;
    to.given.turn("time", t);
    state.ticks = false;
  };

  function play() {
    const playing = main.button()?.textContent === "Pause",
      began = main.given === null;
    // Until a hand is laid on it, it plays what matters most of every new run; then it stays at the time that one looks
    // with, and plays on.
    const led = !began && !state.touched && !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    const time = led ? Math.max(0, get("tried").moment - BEFORE) : null;
    const shows = main.show(get("tried")?.player ?? null, time, { told, task: task(), ticked: ticked(main, other) });
    if (shows) clearTimeout(state.starting);
    if (shows && led) state.starting = setTimeout(() => main.button()?.click(), RESTS);
    else if (shows && !began && playing) main.button().click();
    playBeside();
  }
  /** The rival's run beside that of the design, on the same clock. */
  function playBeside() {
    const asked = get("trial").beside === true,
      run = asked ? (get("rival")?.player ?? null) : null;
    besideField.hidden = !get("course")?.played || get("trial").rival === "";
    beside.checked = asked;
    rivalFigure.hidden = run === null;
    stages.classList.toggle("tr-paired", run !== null);
    stageTitle.hidden = run === null;
    say(rivalTitle, run === null ? "" : label("rival", get("rival")));
    const now = Number(stage.querySelector("input[aria-label=Time]")?.value);
    other.show(run, Number.isFinite(now) ? now : null, { ticked: ticked(other, main) });
  }
  for (const kind of ["pointerdown", "keydown"])
    stages.addEventListener(
      kind,
      () => {
        state.touched = true;
        clearTimeout(state.starting);
      },
      { capture: true },
    );

  function draw() {
    drawControls();
    drawRuns();
  }
  function drawRuns() {
    const course = (state.course = get("course")),
      played = Boolean(course?.played);
    single.hidden = course === null || played;
    stages.hidden = !played;
    // First: what else is written here would be laid out before a canvas writes.
    if (played) play();
    else besideField.hidden = true;
    drawEnds();
    table.hidden = course === null || shown().length === 0;
    if (table.hidden) figures.update([]);
    if (course === null) {
      every.hidden = true;
      state.every = null;
      return;
    }
    drawTable();
    drawFigures();
    if (played) return drawEvery();
    every.hidden = true;
    state.every = null;
    main.end();
    other.end();
    drawKeys();
    drawAbove();
    errors.soon();
    state.following ||= setTimeout(drawMotion, FOLLOWING);
    drawRules();
    drawMoment();
  }

  clock.addEventListener("input", () => seek(Number(clock.value)));
  const reach = (at, still) => seek(at, still ? "strongest" : null);
  draggedTime(above, () => state.above, reach);
  for (const [svg, name] of [
    [error, "error"],
    [speed, "speed"],
    [turning, "turning"],
    [torques, "wheels"],
  ])
    draggedTime(svg, () => state[name] ?? null, reach);
  single.addEventListener("keydown", (event) => {
    const on = event.target.tagName;
    if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey) return;
    if (on === "BUTTON" || on === "SELECT") return; // Space presses those by itself
    event.preventDefault();
    pass();
  });
  // Several values may come together: one picture for all of them.
  const { soon, end } = framed(draw);
  /** What is being run once it takes a while, and then how far it is if it takes as long as the last time. */
  const sayBusy = () => {
    clearInterval(state.ticking);
    const doing = get("busy"),
      began = performance.now();
    const tick = () => {
      const past = (performance.now() - began) / 1000;
      const long = doing !== null && past > 0.6;
      put(bar, { hidden: long ? null : "" });
      // Without a time to compare with, a bar without a value moves to and fro.
      if (doing?.took) put(bar, { value: Math.min(0.97, past / doing.took) });
      else bar.removeAttribute("value");
      say(word, doing === null ? "" : `${WORDS[doing.what]} …${long ? ` ${past.toFixed(0)} s` : ""}`);
    };
    if (doing === null) tick();
    else state.ticking = setInterval(tick, 250);
  };
  sayBusy();
  const drawSeeds = () =>
    strip.update(get("seeds"), get("round"), get("course") === null ? 1 : (get("trial").count ?? 1));
  const drawEditor = () => {
    editor.update(get("editor"));
    drawKept();
  };
  drawSeeds();
  drawEditor();
  // The word alone changes with it: the pictures are not drawn anew for it.
  const watches = [
    watch(model, NAMES, soon),
    // What follows the hand waits for no frame.
    watch(model, ["tried"], () => (state.course === get("course") ? drawRuns() : soon())),
    watch(model, ["busy"], sayBusy),
    watch(model, ["seeds", "round", "trial", "course"], drawSeeds),
    watch(model, ["editor"], drawEditor),
    watch(model, ["moment"], moments.answered),
    whenSized(root, () => {
      state.widths.clear();
      soon();
    }),
  ];
  // Nothing is run for a panel that is hidden; one further down is seen in the small picture under what is edited.
  const watching = new IntersectionObserver((entries) => send({ do: "see", on: entries.at(-1).isIntersecting }), {
    rootMargin: "10000px 0px",
  });
  watching.observe(root);
  draw();
  return () => {
    end();
    clearTimeout(state.following);
    clearTimeout(state.starting);
    errors.end();
    passing.toggle(false);
    settings.end();
    rules.end();
    for (const end of watches) end();
    editor.end();
    watching.disconnect();
    clearInterval(state.ticking);
    main.end();
    other.end();
    root.remove();
  };
}

export default { render };
