// The player of a run: scene, controls, chart and readout, from what robotics/show/playback/player.py packed.
// The form is anywidget's: render({ model, el }), the data in model.get("run"); it returns what cleans up after it.

import { unpacked } from "./packed.js";
import { axes, begin, fixed, hatch, line, sized, ticks } from "./pen.js";
import { rulesPanel } from "./rules.js";
import { series, unpack } from "./rundata.js";

// Colours are names of the page's palette, fuzzy/figures/palette.py; every line has its dashes too.
const COLORS = ["c0", "c1", "c2", "c3", "c4", "c5", "c6"];
const DASHES = [[], [6, 3], [6, 2, 1, 2], [2, 2], [8, 2, 2, 2, 2, 2], [10, 3], []];
const FEW = 8; // robots that are all in the table, with their numbers in the scene
const MANY_LINKS = 400; // from here on only stale ones are drawn unless asked for
const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20, 50];
const STANDS = 0.005; // m/s and, tenfold, rad/s

const SMALL_FONT = '9px system-ui, "DejaVu Sans", sans-serif'; // as a canvas tells it
const GRAIN = 0.02; // m: a run that reaches so much further than the last one shows the same part of the floor
const PAIRS = 3; // where the looks of pairs begin, so that none is that of robot 1
const dash = (i) => DASHES[i % DASHES.length];
// What robots are about, by code & 3: colours beside those of three robots, each with its dashes; words come with the run
const MODES = ["faint", "s5", "s3", "s4"];
const MODE_DASHES = [[], [], [5, 3], [2, 2]];
const GONE = 8; // the code of a stopped robot
const words = { failure: "failure", delay: "delay", silence: "silent", stall: "stalled" };
/** Set a text that differs: the page is laid out anew for it. */
function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}
function make(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null) node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

/** The part of the floor that is shown: the least and the greatest x, then y [m]. */
const floor = ({ bounds }) =>
  bounds.map((value, n) => GRAIN * (n % 2 ? Math.ceil(value / GRAIN) : Math.floor(value / GRAIN)));
/** What decides how the scene looks where nothing moves: of runs that are alike in it the picture is kept. */
const stillOf = (run) => {
  const { sizes, patches, obstacles, channels, faults, stale_after } = run;
  const { path_x, path_y } = channels;
  return JSON.stringify([floor(run), sizes, patches, obstacles, path_x, path_y, faults.length, stale_after]);
};
/** What decides which parts a player has: runs that are alike in it are shown in the same ones. */
const partsOf = ({ robots, hears, sonar, modes, contacts, rules, channels }) =>
  JSON.stringify([
    robots,
    hears === null,
    sonar?.sensors,
    modes && [modes.words, modes.events.length > 0],
    (contacts ?? []).length > 0,
    rules && [rules.top, rules.bases, Boolean(rules.values)],
    Object.keys(channels),
  ]);

// A model that says so when its run changes is shown anew: from its time on, by default from the one that was shown.
function render({ model, el }) {
  let shown = mount(model, el, null);
  const again = () => {
    const time = model.get("time") ?? shown.time();
    if (shown.renew(time)) return;
    shown.remove();
    shown = mount(model, el, time);
  };
  const follow = () => shown.seek(model.get("time"));
  model.on?.("change:run", again);
  model.on?.("change:time", follow);
  return () => {
    model.off?.("change:run", again);
    model.off?.("change:time", follow);
    shown.remove();
  };
}

function mount(model, el, time) {
  let drawn = stillOf(model.get("run"));
  const data = unpack(model.get("run")),
    built = partsOf(data),
    { count } = data,
    few = count <= FEW;
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)"),
    dark = window.matchMedia("(prefers-color-scheme: dark)");
  const within = (t) => (t === null ? data.start : Math.min(data.end, Math.max(data.start, t)));
  const state = { t: within(time), playing: false, before: null, picked: few ? -1 : 0, over: -1, hidden: new Set() };
  const seen = (i) => !state.hidden.has(i);
  // The robot whose rules are shown: under the cursor, or chosen, or the first
  const subject = () => (state.over >= 0 ? state.over : Math.max(state.picked, 0));

  // Parts
  const option = (value, text, chosen) => make("option", { value, selected: value === chosen }, text);
  const choice = (label, options, chosen, react) => {
    const select = make("select", { onchange: react }, ...options.map(([value, text]) => option(value, text, chosen)));
    return [make("label", {}, `${label} `, select), select];
  };
  const speeds = [...new Set([...SPEEDS, model.get("speed") || 1])].sort((a, b) => a - b);
  const pace = String(model.get("speed") || 1);
  const [speedLabel, speed] = choice(
    "Speed",
    speeds.map((s) => [String(s), `${s}×`]),
    pace,
    () => {},
  );
  const tails = [
    ["0", "none"],
    ["10", "10 s"],
    ["1e9", "all"],
  ];
  const [trailLabel, trail] = choice("Trail", tails, count > 20 ? "10" : "1e9", () => draw());
  const shares = [
    ["all", "all"],
    ["stale", "stale"],
    ["mine", "of the selected robot"],
    ["none", "hide"],
  ];
  const [linksLabel, links] = choice("Messages", shares, data.links.length > MANY_LINKS ? "stale" : "all", () =>
    draw(),
  );
  const kinds = [
    ["distance", "distance to the target [m]"],
    ["speed", "speed v [m/s]"],
  ];
  const apart = count > 4 ? "s minus the team's median" : "differences sᵢ − sⱼ";
  if (data.channels.progress) kinds.unshift(["progress", "progress s"], ["difference", apart]);
  const [chartLabel, chart] = choice("Chart", kinds, kinds[0][0], () => layout());
  const play = make(
    "button",
    { type: "button", class: "play", onclick: (event) => toggle(!state.playing, event.isTrusted) },
    "Play",
  );
  const button = (text, onclick, label = null) =>
    make("button", { type: "button", "aria-label": label, onclick }, text);
  const step = (text, label, by) => button(text, () => reach(state.t + by), label);
  const range = { type: "range", step: "any", "aria-label": "Time", oninput: () => reach(Number(slider.value)) };
  const slider = make("input", range);
  const clock = make("output", { class: "clock" });
  let events = [], // changes of mode
    contacts = []; // start, end [s], x, y, depth [m], who
  const marks = make("canvas", { class: "marks", role: "img" });
  const timeline = data.modes ? make("div", { class: "timeline" }, slider, marks) : slider;
  const contactWords = make("p", { class: "note contacts" });
  function read() {
    events = data.modes?.events ?? [];
    contacts = data.contacts ?? [];
    Object.assign(slider, { min: data.start, max: data.end });
    const said = `The robots' operating modes over time, with ${events.length} changes of mode; click to go to a time`;
    marks.setAttribute("aria-label", said);
    say(contactWords, contactList());
  }
  const nextContact = () => {
    const later = contacts.map(([at]) => at).filter((at) => at - state.t > 1e-3);
    if (contacts.length) reach(later.length ? later[0] : contacts[0][0]);
  };
  const jump = (way) => {
    const times = events.map(([at]) => at).filter((at) => way * (at - state.t) > 1e-3);
    if (times.length) reach(way > 0 ? Math.min(...times) : Math.max(...times));
  };
  const jumps = [
    ["◂ mode change", "◂ mode change: go to the previous one (key P)", -1],
    ["mode change ▸", "mode change ▸: go to the next one (key N)", 1],
  ];
  const cones = make("input", { type: "checkbox", checked: true, onchange: () => draw() });
  const conesLabel = make("label", { class: "robot" }, cones, "Sonar cones");
  const about = `Top view of ${count} robot${count > 1 ? "s" : ""}, their paths and messages; the table has the numbers`;
  const scene = make("canvas", { role: "img", "aria-label": about, "data-glance": true });
  const plot = make("canvas", { role: "img", "aria-label": "Chart over time; click to go to a time" });
  const note = make("p", { class: "note" }),
    keys = make("p", { class: "note keys" }),
    summary = make("p", { class: "summary" });
  const heads = ["robot", "x [m]", "y [m]", "ψ [rad]", "v [m/s]", "ω [rad/s]"];
  heads.push(...(data.channels.progress ? ["progress"] : []), "state", ...(data.hears === null ? [] : ["hears"]));
  const worded = (head) => (["robot", "state", "hears"].includes(head) ? "words" : null);
  const swatch = (i) =>
    make("canvas", { class: "swatch", width: 44, height: 24, "aria-hidden": "true", "data-line": i });
  const box = (i) => {
    const tick = { type: "checkbox", checked: true, "aria-label": `show robot ${i + 1}` };
    const input = make("input", { ...tick, onchange: () => show(i, input.checked) });
    return make("label", { class: "robot" }, input, swatch(i), `${i + 1}`);
  };
  const contactList = () => {
    const first = contacts.slice(0, 8).map(([at, , , , deep, who]) => {
      return `${fixed(at, 2)} s ${who} (${fixed(1000 * deep, 0)} mm deep)`;
    });
    return `⊗ Contacts: ${first.join(", ")}${contacts.length > 8 ? `, and ${contacts.length - 8} more` : ""}.`;
  };
  const row = (i) => {
    const first = make("th", { scope: "row" }, ...(i === null ? [] : [box(i)]));
    const cells = heads.slice(1).map((head) => make("td", { "data-label": head, class: worded(head) }));
    const onclick = (event) => {
      if (i !== null && !event.target.closest("label")) pick(i);
    };
    return make("tr", { onclick }, first, ...cells);
  };
  const rows = few ? Array.from({ length: count }, (_, i) => row(i)) : [row(null)];
  const titles = heads.map((head) => make("th", { scope: "col", class: worded(head) }, head));
  const table = make("table", {}, make("thead", {}, make("tr", {}, ...titles)), make("tbody", {}, ...rows));
  const side = [make("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "Readout" }, table)];
  let chosen = null,
    boxes = [];
  if (!few) {
    const numbered = Array.from({ length: count }, (_, i) => [String(i), String(i + 1)]);
    const [label, select] = choice("Robot in the table", numbered, "0", () => pick(Number(select.value)));
    chosen = select;
    boxes = numbered.map((_, i) => box(i));
    const every = (on) => () => {
      for (const each of boxes) each.firstChild.checked = on;
      state.hidden = new Set(on ? [] : boxes.keys());
      layout();
    };
    side.unshift(make("div", { class: "controls" }, label));
    const both = make("div", { class: "controls" }, button("All", every(true)), button("None", every(false)));
    const ticks = make(
      "div",
      { class: "robots", tabindex: "0", role: "group", "aria-label": "Robots shown" },
      ...boxes,
    );
    side.push(make("fieldset", {}, make("legend", {}, "Robots shown"), both, ticks));
  }
  const chooseRobot = (i) => {
    state.picked = i;
    if (chosen) chosen.value = String(i);
    draw();
  };
  // Whoever shows the player may be told what a hand does: the time, the robot, and a rule with its rule base's task
  const told = model.get("told") ?? null;
  const tell = (rule = null, task = null) => told?.({ time: state.t, robot: subject(), rule, task });
  read();
  const rules = rulesPanel(data, {
    make,
    choice,
    pick: chooseRobot,
    draw: () => draw(),
    seek: (t) => reach(t),
    open: told && tell,
    task: model.get("task") ?? null,
  });
  const root = make(
    "div",
    { class: "fp-root" },
    make(
      "div",
      { class: "fp-scene" },
      make("div", { class: "fp-canvas" }, scene),
      make(
        "div",
        { class: "controls" },
        play,
        step("−1 s", "−1 s: back", -1),
        step("+1 s", "+1 s: forward", 1),
        timeline,
        clock,
      ),
      make(
        "div",
        { class: "controls" },
        speedLabel,
        trailLabel,
        ...(data.hears === null ? [] : [linksLabel]),
        ...(data.sonar ? [conesLabel] : []),
        ...(contacts.length ? [button("contact ▸", nextContact, "contact ▸: go to the next one (key C)")] : []),
        ...(events.length ? jumps.map(([text, label, way]) => button(text, () => jump(way), label)) : []),
      ),
      note,
      ...(contacts.length ? [contactWords] : []),
    ),
    make(
      "div",
      { class: "fp-side" },
      ...(rules ? [rules.root] : []),
      make("div", { class: "controls" }, chartLabel),
      make("div", { class: "fp-canvas" }, plot),
      keys,
      summary,
      ...side,
    ),
  );
  el.querySelectorAll(".fp-waiting").forEach((node) => node.remove());
  el.append(root);

  // Looks that depend on the page: sizes, colours, and what does not change with time
  let theme, view, span, lines;
  const widths = new Map(); // of canvases [px]: each measuring lays the page out
  function widthOf(canvas, least = 160) {
    if (!widths.has(canvas)) widths.set(canvas, canvas.parentNode.clientWidth);
    return Math.max(least, widths.get(canvas));
  }
  function layout() {
    root.classList.toggle("wide", el.clientWidth >= 1040);
    root.classList.toggle("narrow", el.clientWidth < 600);
    const style = getComputedStyle(el),
      named = (name) => style.getPropertyValue(`--ff-${name}`).trim();
    const colors = COLORS.map(named),
      modes = MODES.map(named);
    theme = {
      colors: colors.length,
      color: (i) => colors[i % colors.length],
      mode: (code) => modes[code & 3],
      ink: named("ink"),
      quiet: named("quiet"),
      line: named("line"),
      paper: named("paper"),
    };
    root.querySelectorAll(".swatch").forEach((node) => drawSwatch(node));
    widths.clear();
    layoutScene();
    redraw();
  }
  function redraw() {
    layoutChart();
    if (data.modes) layoutMarks();
    draw();
  }

  // Under the slider: a row a robot, coloured while it does something else than track, and a tick at every change of mode
  let strip = null;
  const [marksStill, still, chartStill] = [0, 1, 2].map(() => make("canvas"));
  function layoutMarks() {
    const rows = few ? count : 0,
      size = sized(widthOf(marks, 60), 8 + 7 * rows, marks, marksStill),
      left = 8,
      right = size.width - 8; // as a slider's thumb
    strip = { size, x: (t) => left + ((right - left) * (t - data.start)) / (data.end - data.start) };
    strip.time = (px) => data.start + ((data.end - data.start) * (px - left)) / (right - left);
    const pen = begin(marksStill, size, SMALL_FONT),
      { codes } = data.modes;
    pen.textBaseline = "middle";
    for (let i = 0; i < rows; i++) {
      const y = 7 + 7 * i;
      pen.fillStyle = theme.quiet;
      pen.fillText(`${i + 1}`, 0, y);
      pen.lineWidth = 1;
      pen.setLineDash([]);
      pen.strokeStyle = theme.line;
      pen.beginPath();
      pen.moveTo(left, y);
      pen.lineTo(right, y);
      pen.stroke();
      for (let k = 0, from = 0; k < data.frames; k++) {
        const code = codes[i * data.frames + k];
        if (k + 1 < data.frames && codes[i * data.frames + k + 1] === code) continue;
        if (code > 0 && code < GONE) {
          pen.lineWidth = 5;
          pen.strokeStyle = theme.mode(code);
          pen.setLineDash(MODE_DASHES[code & 3]);
          pen.beginPath();
          pen.moveTo(strip.x(data.time[from]), y);
          pen.lineTo(strip.x(data.time[Math.min(k + 1, data.frames - 1)]), y);
          pen.stroke();
        }
        from = k + 1;
      }
    }
    pen.setLineDash([]);
    pen.lineWidth = 1;
    pen.strokeStyle = theme.ink;
    for (const [at] of events) {
      pen.beginPath();
      pen.moveTo(strip.x(at), 0);
      pen.lineTo(strip.x(at), size.height);
      pen.stroke();
    }
  }

  function drawMarks(t) {
    const pen = begin(marks, strip.size);
    pen.drawImage(marksStill, 0, 0, strip.size.width, strip.size.height);
    pen.strokeStyle = theme.ink;
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(strip.x(t), 0);
    pen.lineTo(strip.x(t), strip.size.height);
    pen.stroke();
  }

  function drawSwatch(node) {
    const pen = node.getContext("2d"),
      i = Number(node.dataset.line);
    pen.setTransform(2, 0, 0, 2, 0, 0);
    pen.clearRect(0, 0, 22, 12);
    pen.strokeStyle = theme.color(i);
    pen.lineWidth = 2.5;
    pen.setLineDash(dash(i));
    pen.beginPath();
    pen.moveTo(0, 6);
    pen.lineTo(22, 6);
    pen.stroke();
  }

  function layoutScene() {
    const [left, right, bottom, top] = floor(data),
      around = Math.max(...data.sizes.map((size) => Math.round(50 * Math.hypot(...size)) / 100)),
      margin = 0.03 * Math.max(right - left, top - bottom) + around;
    const width = widthOf(scene),
      inner = width - 56;
    const wanted = (inner * (top - bottom + 2 * margin)) / (right - left + 2 * margin);
    const height = Math.round(Math.min(Math.max(wanted, 150), Math.max(260, 0.8 * width), 620)) + 70,
      size = sized(width, height, scene, still);
    const frame = { left: 44, right: size.width - 12, top: 30, bottom: size.height - 40 };
    const across = frame.right - frame.left,
      down = frame.bottom - frame.top;
    const scale = Math.min(across / (right - left + 2 * margin), down / (top - bottom + 2 * margin));
    const cx = (left + right) / 2,
      cy = (bottom + top) / 2,
      mx = frame.left + across / 2,
      my = frame.top + down / 2;
    // Among obstacles a robot that is drawn too large would seem to touch them.
    const grown = data.obstacles ? 1 : Math.max(1, (few ? 18 : count > 60 ? 8 : 11) / (data.shortest * scale));
    view = { size, scale, grown, frame, x: (v) => mx + scale * (v - cx), y: (v) => my - scale * (v - cy) };
    const pen = begin(still, size),
      most = Math.max(3, Math.round(across / 70));
    const wide = across / scale / 2,
      high = down / scale / 2,
      rows = Math.max(2, (most * high) / wide);
    const xs = ticks(cx - wide, cx + wide, most),
      ys = ticks(cy - high, cy + high, rows);
    axes(pen, frame, view, theme, xs, ys, ["x [m]", "y [m]"]);
    data.patches.forEach(([friction, points]) => drawPatch(pen, friction, points));
    if (data.obstacles && !data.obstacles.moving) drawObstacles(pen, { k: 0, share: 0 });
    const nodes = data.channels.path_x.length / count;
    pen.strokeStyle = theme.quiet;
    pen.globalAlpha = few ? 0.9 : 0.5;
    pen.lineWidth = few ? 1.2 : 0.7;
    pen.setLineDash([5, 3]);
    for (let i = 0; i < count; i++) {
      if (!seen(i)) continue;
      pen.beginPath();
      line(
        pen,
        nodes,
        (k) => view.x(data.channels.path_x[i * nodes + k]),
        (k) => view.y(data.channels.path_y[i * nodes + k]),
      );
      pen.stroke();
    }
    const said = grown > 1.05 ? `robots drawn ${fixed(grown, 1)} times their size` : "robots to scale";
    const parts = ["dashed: path", "+: target", said, "outline only: standing"];
    const old = `dashed if older than ${fixed(data.stale_after, 2)} s`;
    if (data.hears !== null) parts.push(`half of a line: what the robot at its end hears from the other, ${old}`);
    if (data.faults.length) parts.push("hatched: a robot with a fault");
    if (data.patches.length) parts.push("hatched floor: other friction");
    if (data.obstacles) parts.push("grey: obstacle");
    if (data.sonar) parts.push("cone: the range that a sonar reads, faint without an echo");
    if (data.modes) parts.push("ring, and bars under the slider: a robot's operating mode");
    if (contacts.length) parts.push("⊗: contact, from its begin on");
    if (rules) parts.push("broad band and numbers: the rule that decides most along the path of the robot with a ring");
    if (calm.matches) parts.push("reduced motion: two pictures a second");
    say(
      note,
      `${parts.join(" · ")}. Keys: space plays and pauses; ← and → move by 1 s, with shift by 10 s${data.sonar ? "; S shows the sonar cones" : ""}${events.length ? "; P and N go to the changes of mode" : ""}${contacts.length ? "; C goes to the next contact" : ""}${rules && count > 1 ? "; R shows the rules of the next robot" : ""}.`,
    );
  }

  function layoutChart() {
    lines = series(data, chart.value);
    const size = sized(widthOf(plot), root.classList.contains("wide") ? 250 : 200, plot, chartStill);
    const frame = { left: 48, right: size.width - 16, top: 30, bottom: size.height - 40 };
    let low = Infinity,
      high = -Infinity;
    for (const { values } of lines.filter(({ who }) => who.every(seen))) {
      for (const value of values) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (!(low <= high)) [low, high] = [0, 1];
    const room = 0.05 * (high - low) || 0.05;
    [low, high] = [low - room, high + room];
    span = {
      size,
      frame,
      x: (t) => frame.left + ((frame.right - frame.left) * (t - data.start)) / (data.end - data.start),
      y: (v) => frame.bottom - ((frame.bottom - frame.top) * (v - low)) / (high - low),
      time: (px) => data.start + ((data.end - data.start) * (px - frame.left)) / (frame.right - frame.left),
    };
    const pen = begin(chartStill, size);
    const xs = ticks(data.start, data.end, Math.max(3, Math.round(size.width / 80)));
    axes(pen, frame, span, theme, xs, ticks(low, high, 4), [
      "time [s]",
      kinds.find(([value]) => value === chart.value)[1],
    ]);
    const shown = data.faults.filter(([robot]) => seen(robot));
    const taken = [];
    for (const [robot, kind, from, to] of shown) {
      const left = Math.max(frame.left, span.x(from)),
        right = Math.min(frame.right, span.x(to));
      if (right <= left) continue;
      pen.save();
      pen.beginPath();
      pen.rect(left, frame.top, right - left, frame.bottom - frame.top);
      pen.clip();
      pen.globalAlpha = 0.09;
      pen.fillStyle = theme.ink;
      pen.fillRect(left, frame.top, right - left, frame.bottom - frame.top);
      pen.globalAlpha = 0.2;
      pen.strokeStyle = theme.ink;
      hatch(pen, left, frame.top, right - left, frame.bottom - frame.top, 9, kind);
      pen.restore();
      const text = `${robot + 1}: ${words[kind]}`,
        wide = pen.measureText(text).width + 6;
      const level = [0, 1, 2].find((n) => !taken.some(([a, b, m]) => m === n && left < b && left + wide > a));
      if (level !== undefined) {
        taken.push([left, left + wide, level]);
        const at = Math.min(left, frame.right - wide);
        pen.fillStyle = theme.paper;
        pen.fillRect(at, frame.top + 16 * level, wide, 16);
        pen.fillStyle = theme.ink;
        pen.textAlign = "left";
        pen.textBaseline = "middle";
        pen.fillText(text, at + 3, frame.top + 8 + 16 * level);
      }
    }
    pen.lineWidth = few ? 1.6 : 0.7;
    pen.globalAlpha = few ? 1 : 0.6;
    const paired = lines[0]?.who.length === 2;
    lines.forEach(({ who, values }, n) => {
      if (!who.every(seen)) return;
      const look = paired ? n + PAIRS : who[0];
      pen.strokeStyle = theme.color(look);
      pen.setLineDash(few ? dash(look) : []);
      pen.beginPath();
      line(
        pen,
        data.frames,
        (k) => span.x(data.time[k]),
        (k) => span.y(values[k]),
      );
      pen.stroke();
    });
    const names = paired ? lines.map(({ name }) => name) : [];
    if (keys.textContent === names.join("")) return;
    keys.replaceChildren(...names.map((name, n) => make("span", {}, swatch(n + PAIRS), name)));
    keys.querySelectorAll(".swatch").forEach((node) => drawSwatch(node));
  }

  // One frame
  function draw() {
    const { t } = state,
      place = data.locate(t),
      ages = data.stale(t);
    drawScene(t, place, ages);
    drawChart(t, place);
    if (strip) drawMarks(t);
    slider.value = t;
    const text = `${fixed(t, 2)} s`;
    slider.setAttribute("aria-valuetext", `${text} of ${fixed(data.end, 0)} s`);
    clock.textContent = `${text} / ${fixed(data.end, 0)} s`;
    readOut(t, place, ages);
    rules?.show(subject(), state.over >= 0, place, theme, t);
    model.get("ticked")?.(t);
  }

  function drawScene(t, place, ages) {
    const pen = begin(scene, view.size),
      { x, y } = data.channels,
      { frames } = data;
    pen.drawImage(still, 0, 0, view.size.width, view.size.height);
    if (data.obstacles?.moving) drawObstacles(pen, place);
    const from = data.locate(t - Number(trail.value)).k;
    const where = Array.from({ length: count }, (_, i) => [
      view.x(data.at("x", i, place)),
      view.y(data.at("y", i, place)),
    ]);
    const marked = rules?.root.open ? subject() : state.over >= 0 ? state.over : state.picked;
    if (seen(marked)) rules?.drawPath(pen, marked, theme, view);
    pen.lineWidth = few ? 1.8 : 0.9;
    if (trail.value !== "0") {
      for (let i = 0; i < count; i++) {
        if (!seen(i)) continue;
        pen.strokeStyle = theme.color(i);
        pen.beginPath();
        line(
          pen,
          place.k + 1 - from,
          (k) => view.x(x[i * frames + from + k]),
          (k) => view.y(y[i * frames + from + k]),
        );
        pen.lineTo(...where[i]);
        pen.stroke();
      }
    }
    drawLinks(pen, where, ages, marked);
    const arm = few ? 5 : 2.5;
    pen.lineWidth = few ? 1.8 : 1;
    for (let i = 0; i < count; i++) {
      if (!seen(i)) continue;
      const px = view.x(data.at("x_target", i, place)),
        py = view.y(data.at("y_target", i, place));
      pen.strokeStyle = theme.color(i);
      pen.beginPath();
      pen.moveTo(px - arm, py);
      pen.lineTo(px + arm, py);
      pen.moveTo(px, py - arm);
      pen.lineTo(px, py + arm);
      pen.stroke();
    }
    if (data.sonar && cones.checked) for (let i = 0; i < count; i++) if (seen(i)) drawCones(pen, i, where[i], place);
    for (let i = 0; i < count; i++) if (seen(i)) drawRobot(pen, i, where[i], t, place, i === marked);
    for (const [at, , x, y] of contacts) if (at <= t + 1e-9) drawContact(pen, view.x(x), view.y(y));
  }

  // A cross in a ring, told by its form; the paper's colour around it keeps it apart from what lies below
  function drawContact(pen, x, y) {
    pen.save();
    pen.setLineDash([]);
    for (const [wide, ink] of [
      [5, theme.paper],
      [2, theme.ink],
    ]) {
      pen.lineWidth = wide;
      pen.strokeStyle = ink;
      pen.beginPath();
      pen.arc(x, y, 7, 0, 7);
      for (const sign of [1, -1]) {
        pen.moveTo(x - 5, y - 5 * sign);
        pen.lineTo(x + 5, y + 5 * sign);
      }
      pen.stroke();
    }
    pen.restore();
  }

  // A patch of the floor: lines where it is slippery, a grid where it is rough, and its friction in words
  function drawPatch(pen, friction, points) {
    const { left, right, top, bottom } = view.frame,
      within = (value, low, high) => Math.min(Math.max(value, low), high);
    const xs = points.map(([x]) => view.x(x)),
      ys = points.map(([, y]) => view.y(y)),
      rough = friction > 1;
    pen.save();
    pen.beginPath();
    pen.rect(left, top, right - left, bottom - top);
    pen.clip();
    pen.beginPath();
    xs.forEach((x, n) => pen.lineTo(x, ys[n]));
    pen.closePath();
    pen.fillStyle = pen.strokeStyle = theme.color(rough ? 5 : 4);
    pen.globalAlpha = 0.12;
    pen.fill();
    pen.globalAlpha = 0.6;
    pen.lineWidth = 1;
    pen.setLineDash([]);
    pen.stroke();
    pen.clip();
    for (const kind of rough ? ["silence", "stall"] : ["silence"])
      hatch(pen, left, top, right - left, bottom - top, 8, kind);
    pen.restore();
    const text = `friction × ${Number(friction.toPrecision(3))}`,
      half = pen.measureText(text).width / 2 + 3;
    const x = within((Math.min(...xs) + Math.max(...xs)) / 2, left + half, right - half),
      y = within(Math.max(...ys), top + 16, bottom);
    pen.fillStyle = theme.paper;
    pen.fillRect(x - half, y - 16, 2 * half, 16);
    pen.fillStyle = theme.ink;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText(text, x, y - 8);
  }

  function drawObstacles(pen, place) {
    pen.save();
    pen.setLineDash([]);
    pen.strokeStyle = theme.quiet;
    data.obstacles.bodies.forEach(({ points, radius, solid }, b) => {
      const [x, y, turn] = data.body(b, place),
        c = Math.cos(turn),
        s = Math.sin(turn);
      pen.beginPath();
      if (radius) pen.arc(view.x(x), view.y(y), radius * view.scale, 0, 7);
      else for (const [px, py] of points) pen.lineTo(view.x(x + c * px - s * py), view.y(y + s * px + c * py));
      pen.globalAlpha = 0.35;
      pen.fillStyle = theme.quiet;
      if (solid) pen.fill();
      pen.globalAlpha = 1;
      pen.lineWidth = solid ? 1.2 : 3;
      pen.stroke();
    });
    pen.restore();
  }

  // A cone as far as its sonar reads; to its range, and faint, where it sees nothing
  function drawCones(pen, i, [px, py], place) {
    const { sensors, readings } = data.sonar,
      k = place.share >= 1 ? place.k + 1 : place.k;
    const { left, right, top, bottom } = view.frame;
    pen.save();
    pen.beginPath();
    pen.rect(left, top, right - left, bottom - top);
    pen.clip();
    pen.translate(px, py);
    pen.rotate(-data.at("heading", i, place));
    pen.strokeStyle = pen.fillStyle = theme.color(i);
    pen.lineWidth = 1;
    sensors[i].forEach((mounting, q) => {
      if (!mounting) return; // it does not carry this one
      const [x, y, axis, half, range] = mounting;
      const read = readings[(i * sensors[i].length + q) * data.frames + k],
        echo = Number.isFinite(read);
      pen.beginPath();
      pen.moveTo(x * view.scale, -y * view.scale);
      pen.arc(x * view.scale, -y * view.scale, (echo ? read : range) * view.scale, -axis - half, -axis + half);
      pen.closePath();
      pen.globalAlpha = echo ? 0.16 : 0.04;
      pen.fill();
      pen.globalAlpha = echo ? 0.8 : 0.2;
      pen.stroke();
    });
    pen.restore();
  }

  function drawLinks(pen, where, ages, marked) {
    if (links.value === "none") return;
    const halves = { fresh: [], stale: [] };
    for (const [i, j] of data.links) {
      if (!seen(i) || !seen(j)) continue;
      const age = ages.get(i * count + j),
        mine = i === marked || j === marked;
      if (age === Infinity || (links.value === "mine" && !mine) || (links.value === "stale" && age === undefined))
        continue;
      halves[age === undefined ? "fresh" : "stale"].push([i, j, age]);
    }
    pen.strokeStyle = theme.ink;
    pen.lineWidth = few ? 1 : 0.8;
    pen.globalAlpha = few ? 0.5 : 0.25;
    const half = (i, j) => {
      pen.moveTo(...where[i]);
      pen.lineTo((where[i][0] + where[j][0]) / 2, (where[i][1] + where[j][1]) / 2);
    };
    pen.beginPath();
    for (const [i, j] of halves.fresh) half(i, j);
    pen.stroke();
    pen.setLineDash([3, 4]);
    const strong = halves.stale.length > 100 ? 0.3 : few ? 0.8 : 0.6; // many lines must not hide the robots
    for (const [i, j, age] of halves.stale) {
      pen.globalAlpha = strong * Math.max(0.5, Math.exp(-(age - data.stale_after) / 8));
      pen.beginPath();
      half(i, j);
      pen.stroke();
    }
    pen.globalAlpha = 1;
    pen.setLineDash([]);
  }

  function drawRobot(pen, i, [px, py], t, place, marked) {
    const [long, across] = data.sizes[i].map((metres) => metres * view.scale * view.grown);
    const kind = data.fault(i, t),
      stopped = data.stopped(i, t),
      color = theme.color(i);
    const stands = Math.abs(data.at("v", i, place)) < STANDS && Math.abs(data.at("w", i, place)) < 10 * STANDS;
    pen.save();
    pen.translate(px, py);
    pen.save();
    pen.rotate(-data.at("heading", i, place));
    pen.beginPath();
    pen.rect(-long / 2, -across / 2, long, across);
    pen.fillStyle = stands || stopped || kind ? theme.paper : color;
    pen.strokeStyle = color;
    pen.lineWidth = few ? 2 : 1.2;
    pen.fill();
    pen.stroke();
    if (kind) {
      pen.save();
      pen.clip();
      pen.lineWidth = 1.2;
      hatch(pen, -long / 2, -across / 2, long, across, Math.max(3, long / 5), kind);
      pen.restore();
    }
    const [radius, half] = data.wheels[i].map((metres) => metres * view.scale * view.grown);
    pen.fillStyle = theme.ink;
    for (const side of [-half, half]) pen.fillRect(-radius, side - 0.2 * radius, 2 * radius, 0.4 * radius);
    pen.beginPath();
    for (const [ahead, aside] of [
      [0.44, 0],
      [-0.3, 0.24],
      [-0.3, -0.24],
    ])
      pen.lineTo(ahead * long, aside * across);
    pen.fillStyle = kind ? theme.ink : stands || stopped ? color : theme.paper;
    pen.fill();
    pen.restore();
    const ring = Math.hypot(long, across) / 2 + 3;
    pen.strokeStyle = theme.ink;
    pen.lineWidth = 1.4;
    const doing = stopped ? 0 : data.mode(i, place);
    if (doing > 0 && doing < GONE) {
      pen.save();
      pen.strokeStyle = theme.mode(doing);
      pen.setLineDash(MODE_DASHES[doing & 3]);
      pen.lineWidth = few ? 3 : 2;
      pen.beginPath();
      pen.arc(0, 0, ring + 3, 0, 7);
      pen.stroke();
      pen.restore();
    }
    if (marked) {
      pen.beginPath();
      pen.arc(0, 0, ring + (doing ? 7 : 1), 0, 7);
      pen.stroke();
    }
    if (stopped) {
      pen.beginPath();
      for (const sign of [1, -1]) {
        pen.moveTo(-ring, -sign * ring);
        pen.lineTo(ring, sign * ring);
      }
      pen.stroke();
    }
    const trouble = stopped ? "stopped" : kind ? words[kind] : doing && (few || marked) ? data.modes.words[doing] : "";
    if (few || marked || trouble) {
      const text = `${i + 1}${trouble ? `: ${trouble}` : ""}`;
      pen.font = "600 12px system-ui, 'DejaVu Sans', sans-serif";
      const wide = pen.measureText(text).width,
        side = px + ring + wide + 4 > view.size.width ? -ring - wide - 2 : ring - 1;
      pen.textBaseline = "bottom";
      pen.lineWidth = 3;
      pen.lineJoin = "round";
      pen.strokeStyle = theme.paper;
      pen.strokeText(text, side, -ring / 2);
      pen.fillStyle = theme.ink;
      pen.fillText(text, side, -ring / 2);
    }
    pen.restore();
  }

  function drawChart(t, place) {
    const pen = begin(plot, span.size),
      { frame } = span;
    pen.drawImage(chartStill, 0, 0, span.size.width, span.size.height);
    pen.strokeStyle = theme.ink;
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(span.x(t), frame.top);
    pen.lineTo(span.x(t), frame.bottom);
    pen.stroke();
    const paired = lines[0]?.who.length === 2,
      marked = state.over >= 0 ? state.over : state.picked;
    lines.forEach(({ who, values }, n) => {
      if (!who.every(seen) || (!few && who[0] !== marked)) return;
      const a = values[place.k],
        b = values[Math.min(place.k + 1, data.frames - 1)],
        value = a + place.share * (b - a);
      pen.fillStyle = theme.color(paired ? n + PAIRS : who[0]);
      pen.beginPath();
      pen.arc(span.x(t), span.y(value), 3.5, 0, 7);
      pen.fill();
    });
  }

  function readOut(t, place, ages) {
    const condition = (i) => {
      if (data.stopped(i, t)) return "stopped";
      const kind = data.fault(i, t);
      if (kind) return words[kind];
      const doing = data.mode(i, place);
      if (doing) return data.modes.words[doing];
      return Math.abs(data.at("v", i, place)) < STANDS && Math.abs(data.at("w", i, place)) < 10 * STANDS
        ? "standing"
        : "driving";
    };
    const heard = (i) => {
      const mine = data.links.filter(([to]) => to === i);
      const old = mine
        .filter(([, from]) => ages.has(i * count + from))
        .map(([, from]) => [from, ages.get(i * count + from)]);
      if (!mine.length) return "nobody";
      if (!old.length)
        return `${mine.length > 4 ? `all ${mine.length}` : mine.map(([, from]) => from + 1).join(", ")}: fresh`;
      const since = (age) => (age === Infinity ? "never heard" : `${fixed(age, 1)} s old`);
      const listed = old
        .slice(0, 4)
        .map(([from, age]) => `${from + 1}: ${since(age)}`)
        .join(", ");
      if (old.length > 4) return `${listed}, … (${old.length} of ${mine.length} stale)`;
      return listed + (old.length < mine.length ? ", others fresh" : "");
    };
    rows.forEach((row, n) => {
      const i = few ? n : state.picked;
      const values = ["x", "y", "heading", "v", "w"].map((channel) => fixed(data.at(channel, i, place), 2));
      if (data.channels.progress) values.push(fixed(data.at("progress", i, place), 3));
      values.push(condition(i));
      if (data.hears !== null) values.push(heard(i));
      if (!few) say(row.firstChild, `${i + 1}`);
      values.forEach((text, column) => say(row.children[column + 1], text));
      row.classList.toggle("picked", few && i === state.picked);
      row.classList.toggle("hidden", !seen(i));
    });
    const faulty = Array.from({ length: count }, (_, i) => i).filter((i) => data.fault(i, t) || data.stopped(i, t));
    const said = [`t = ${fixed(t, 2)} s`];
    if (data.channels.progress) {
      const known = Array.from({ length: count }, (_, i) => data.at("progress", i, place)).filter(Number.isFinite);
      if (known.length) said.push(`progress ${fixed(Math.min(...known), 3)} to ${fixed(Math.max(...known), 3)}`);
    }
    const named = faulty.slice(0, 6).map((i) => `robot ${i + 1}: ${condition(i)}`);
    said.push(faulty.length ? named.join(", ") + (faulty.length > 6 ? ", …" : "") : "no faults");
    const last = events.filter(([at]) => at <= t + 1e-9).at(-1);
    if (last) said.push(`${fixed(last[0], 2)} s, robot ${last[1] + 1}: ${last[2]} → ${last[3]} (${last[4]})`);
    const touched = contacts.filter(([at]) => at <= t + 1e-9).at(-1);
    if (touched) said.push(`contact at ${fixed(touched[0], 2)} s: ${touched[5]}`);
    if (ages.size) said.push(`${ages.size} of ${data.links.length} links are stale`);
    say(summary, said.join(" · "));
  }

  // Time
  let request = 0;
  function seek(t) {
    state.t = within(t);
    draw();
  }
  /** As seek, by a hand. */
  function reach(t) {
    seek(t);
    tell();
  }
  function toggle(on = !state.playing, hand = false) {
    state.playing = on;
    state.led = on && hand;
    state.before = null;
    play.textContent = on ? "Pause" : "Play";
    cancelAnimationFrame(request);
    if (!on) return;
    if (state.t >= data.end) seek(data.start);
    request = requestAnimationFrame(advance);
  }
  function advance(now) {
    state.before ??= now;
    // Whoever asked for less motion gets two pictures a second; a page that was hidden does not jump.
    if (!calm.matches || now - state.before >= 500) {
      seek(state.t + (Math.min(now - state.before, calm.matches ? 600 : 250) / 1000) * Number(speed.value));
      state.before = now;
      if (state.led) tell();
    }
    if (state.t >= data.end) toggle(false);
    else request = requestAnimationFrame(advance);
  }

  // Hands
  function show(i, on) {
    if (on) state.hidden.delete(i);
    else state.hidden.add(i);
    layout();
  }
  function pick(i) {
    state.picked = few && state.picked === i ? -1 : i;
    if (chosen) chosen.value = String(i);
    draw();
  }
  function nearest(event) {
    const area = scene.getBoundingClientRect(),
      place = data.locate(state.t);
    let best = -1,
      least = 24;
    for (let i = 0; i < count; i++) {
      if (!seen(i)) continue;
      const dx = view.x(data.at("x", i, place)) + area.left - event.clientX;
      const gap = Math.hypot(dx, view.y(data.at("y", i, place)) + area.top - event.clientY);
      if (gap < least) [best, least] = [i, gap];
    }
    return best;
  }
  const hover = (i) => {
    if (i === state.over) return;
    state.over = i;
    draw();
  };
  scene.addEventListener("pointermove", (event) => hover(nearest(event)));
  scene.addEventListener("pointerleave", () => hover(-1));
  scene.addEventListener("click", (event) => {
    const i = nearest(event);
    if (i >= 0) pick(i);
    else if (onTrail(event)) tell("strongest");
  });
  // A place on a robot's way leads to when it was there
  function onTrail(event) {
    const area = scene.getBoundingClientRect(),
      { x, y } = data.channels;
    const [px, py] = [event.clientX - area.left, event.clientY - area.top];
    let [best, when, least] = [-1, 0, 16];
    for (let i = 0; i < count; i++)
      for (let k = 0; seen(i) && k < data.frames; k++) {
        const gap = Math.hypot(view.x(x[i * data.frames + k]) - px, view.y(y[i * data.frames + k]) - py);
        if (gap < least) [best, when, least] = [i, data.time[k], gap];
      }
    if (best < 0) return false;
    state.over = -1;
    if (told) chooseRobot(best);
    seek(when);
    return true;
  }
  for (const [canvas, time] of [
    [plot, (x) => span.time(x)],
    [marks, (x) => strip.time(x)],
  ]) {
    const scrub = (event) => reach(time(event.clientX - canvas.getBoundingClientRect().left));
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      scrub(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) scrub(event);
    });
  }
  const hands = model.get("page") ? document : root;
  const onKey = (event) => {
    const on = event.target,
      type = on.tagName;
    if (event.ctrlKey || event.metaKey || event.altKey || type === "SELECT") return;
    const by = event.shiftKey ? 10 : 1;
    const times = { ArrowLeft: state.t - by, ArrowRight: state.t + by, Home: data.start, End: data.end };
    const letters = {};
    if (data.sonar)
      letters.s = () => {
        cones.checked = !cones.checked;
        draw();
      };
    if (events.length) Object.assign(letters, { n: () => jump(1), p: () => jump(-1) });
    if (contacts.length) letters.c = nextContact;
    if (rules && count > 1) letters.r = () => chooseRobot((Math.max(state.picked, 0) + 1) % count);
    const letter = letters[event.key.toLowerCase()];
    const hand = () => toggle(!state.playing, true);
    const act = event.key === " " ? hand : event.key in times ? () => reach(times[event.key]) : letter;
    // Space presses a button and ticks a box by itself; a scrolling table has its own arrows.
    if (!act || (event.key === " " && (type === "BUTTON" || on.type === "checkbox"))) return;
    event.preventDefault();
    act();
  };
  hands.addEventListener("keydown", onKey);
  const observer = new ResizeObserver(() => {
    if (el.clientWidth !== seenWidth) {
      seenWidth = el.clientWidth;
      layout();
    }
  });
  let seenWidth = el.clientWidth;
  observer.observe(el);
  dark.addEventListener("change", layout);
  const scheme = new MutationObserver(layout); // of a page that has a light and a dark theme of its own
  scheme.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
  calm.addEventListener("change", layout);
  layout();
  const remove = () => {
    toggle(false);
    observer.disconnect();
    hands.removeEventListener("keydown", onKey);
    dark.removeEventListener("change", layout);
    scheme.disconnect();
    calm.removeEventListener("change", layout);
    rules?.end();
    root.remove();
  };
  /** Show the model's run as it is now from a time on, at rest; false where it needs other parts. */
  const renew = (t) => {
    const run = model.get("run");
    if (partsOf(run) !== built) return false;
    toggle(false);
    const still = stillOf(run),
      kept = still === drawn;
    drawn = still;
    Object.assign(data, unpack(run));
    read();
    state.t = within(t);
    rules?.renew();
    if (!kept) layoutScene();
    redraw();
    return true;
  };
  return { remove, time: () => state.t, seek, renew };
}

export { unpacked };
export default { render };
