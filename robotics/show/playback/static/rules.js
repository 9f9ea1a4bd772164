// The rules that fire: for one robot the strongest of each rule base, as sentences with bars, and its path by rule.
// What they are was found by robotics/show/playback/player.py; nothing is inferred here.

import { fixed } from "./pen.js";
import { ruleStrip } from "./rulestrip.js";

const NONE = 0,
  UNKNOWN = 65535; // in place of a rule's number: none fires; an input is not a number
const APART = 26; // px between the numbers along a path
const LONG = 70; // letters: longer rules get room for two lines
const SPANS = 300; // of time in the strip, at most

// The strongest rules of a rule base at a frame: [{ rule, strength }], rule from 1
function strongest({ rules, count, frames }, base, robot, k) {
  const first = ((base * count + robot) * frames + k) * rules.top;
  return Array.from({ length: rules.top }, (_, n) => ({
    rule: rules.numbers[first + n],
    strength: rules.strengths[first + n] / 255,
  }));
}

// The spans of frames in which one rule of a rule base is a robot's strongest: [{ rule, from, to }]
function spans(data, base, robot) {
  const found = [];
  for (let k = 0; k < data.frames; k++) {
    const [{ rule }] = strongest(data, base, robot, k);
    if (found.at(-1)?.rule === rule) found.at(-1).to = k;
    else found.push({ rule, from: k, to: k });
  }
  return found;
}

// The rules of a rule base that are ever a robot's strongest, each with its place among them by how long it is that
function looks(data, base) {
  const lasts = new Map();
  for (let i = 0; i < data.count; i++)
    for (const { rule, from, to } of spans(data, base, i)) lasts.set(rule, (lasts.get(rule) ?? 0) + to - from + 1);
  const rules = [...lasts.keys()].filter((rule) => rule !== NONE && rule !== UNKNOWN);
  rules.sort((a, b) => lasts.get(b) - lasts.get(a) || a - b);
  return new Map(rules.map((rule, n) => [rule, n]));
}

// The rules that are among a robot's strongest, and their shares in the answer over time, as ruleStrip takes them
function ruling(data, base, robot) {
  const { rules, count, frames, time } = data,
    { top } = rules;
  const spans_ = Math.min(SPANS, frames);
  const ends = Array.from({ length: spans_ + 1 }, (_, n) => Math.round((n * frames) / spans_));
  const rows = new Map();
  for (let n = 0; n < spans_; n++)
    for (let k = ends[n]; k < ends[n + 1]; k++)
      for (let m = 0; m < top; m++) {
        const place = ((base * count + robot) * frames + k) * top + m,
          rule = rules.numbers[place];
        if (rule === NONE || rule === UNKNOWN) continue;
        if (!rows.has(rule)) rows.set(rule, new Float32Array(spans_));
        rows.get(rule)[n] += rules.shares[place] / 255 / (ends[n + 1] - ends[n]);
      }
  const whole = (shares) => shares.reduce((sum, value) => sum + value, 0);
  const sorted = [...rows].sort((a, b) => whole(b[1]) - whole(a[1]) || a[0] - b[0]);
  return {
    edges: ends.map((k) => time[Math.min(k, frames - 1)]),
    rows: sorted.map(([rule, shares]) => ({
      rule,
      text: rules.bases[base].rules[rule - 1],
      shares: Array.from(shares),
    })),
  };
}

// The colour of a rule with such a place: as many as there are colours have their own, the others are alike
const colorOf = (theme, look) => (look < theme.colors ? theme.color(look) : theme.quiet);

/**
 * The panel, or null where the run has no rules.
 *   make, choice  make an element; make a labelled select [label, select]
 *   pick(robot)   a robot was chosen in the panel
 *   draw()        something else shall be drawn
 *   seek(time)    a time was chosen in the strip
 *   task          of the rule base that is shown first, if it is there; null: the last one
 *   open          open(rule, task): a rule was chosen in the strip; null: rules lead nowhere
 */
export function rulesPanel(data, { make, choice, pick, draw, seek, open, task = null }) {
  if (!data.rules) return null;
  const { bases, top } = data.rules,
    shown = bases.length > 2 ? Math.min(2, top) : top;
  const numbered = Array.from({ length: data.count }, (_, i) => [String(i), String(i + 1)]);
  const [robotLabel, robot] = choice("Rules of robot", numbered, "0", () => pick(Number(robot.value)));
  // Where a rule base supervises others it stands last.
  const tasks = [["-1", "no rule base"], ...bases.map(({ task }, b) => [String(b), task])];
  const mine = bases.findIndex((base) => base.task === task),
    shownFirst = mine < 0 ? bases.length - 1 : mine;
  const [colorLabel, color] = choice("Its path shows", tasks, String(shownFirst), () => draw());
  const title = make("summary", {});
  const parts = bases.map(({ task, inputs, rules }) => {
    const asked = make("p", { class: "fp-asked" });
    const rows = Array.from({ length: shown }, () => {
      const bar = make("span", { class: "fp-bar", "aria-hidden": "true" }),
        dot = make("span", { class: "fp-dot", "aria-hidden": "true" }),
        said = make("span", {});
      return { row: make("li", {}, bar, dot, said), bar, dot, said };
    });
    const list = make("ol", {}, ...rows.map(({ row }) => row));
    const head = make("summary", {}, task);
    const long = rules.some((rule) => rule.length > LONG);
    const part = make("details", { open: true, class: "fp-base" }, head, ...(data.rules.values ? [asked] : []), list);
    part.classList.toggle("fp-long", long);
    return { part, rows, asked, inputs };
  });
  const based = () => Math.max(0, Number(color.value)),
    strip = ruleStrip({ seek, open: open && ((rule) => open(rule, bases[based()].task)) });
  let drawn = null, // what the strip shows: rule base and robot
    request = 0,
    now = 0;
  const root = make(
    "details",
    { class: "fp-rules", open: true },
    title,
    make("div", { class: "controls" }, ...(data.count > 1 ? [robotLabel] : []), colorLabel),
    ...parts.map(({ part }) => part),
    strip.node,
  );
  const along = new Map();
  let values, colored;
  /** Read the data, which are another run's now. */
  function renew() {
    ({ values } = data.rules);
    colored = bases.map((_, b) => looks(data, b));
    along.clear();
    drawn = null;
  }
  renew();
  let first = 0; // the number of a rule base's first input among all
  const places = bases.map(({ inputs }) => (first += inputs.length) - inputs.length);
  const put = (node, text) => {
    if (node.textContent !== text) node.textContent = text;
  };

  // What the rules of robot i are at a place in time
  function show(i, over, place, theme, time) {
    const k = place.share >= 1 ? Math.min(place.k + 1, data.frames - 1) : place.k;
    put(title, `Rules that decide now: robot ${i + 1}${over ? " (under the cursor)" : ""}`);
    if (!over) robot.value = String(i);
    if (!root.open) return;
    now = time;
    if (!over && drawn !== `${based()} ${i}`) {
      drawn = `${based()} ${i}`;
      cancelAnimationFrame(request); // a frame later: a new run's picture does not wait for it
      request = requestAnimationFrame(() => {
        strip.update(ruling(data, based(), i));
        strip.at(now);
      });
    }
    strip.at(time);
    parts.forEach(({ part, rows, asked, inputs }, b) => {
      if (!part.open) return;
      const told = (input, n) => {
        const value = values[places[b] + n][i * data.frames + k];
        return `${input[0]} ${fixed(value, Math.abs(value) < 10 ? 3 : 1)} ${input[1]}`.trim();
      };
      if (values) put(asked, inputs.map(told).join(", "));
      const best = strongest(data, b, i, k);
      rows.forEach(({ row, bar, dot, said }, n) => {
        const { rule, strength } = best[n];
        const none = rule === NONE || rule === UNKNOWN;
        const why = rule === UNKNOWN ? "no answer: an input is not a number" : "no rule fires";
        row.classList.toggle("none", none);
        row.dataset.rule = none ? "" : rule;
        put(said, none ? (n === 0 ? why : "") : `${fixed(strength, 2)} rule ${rule}: ${bases[b].rules[rule - 1]}`);
        bar.style.width = `${100 * strength}%`;
        const look = Number(color.value) === b ? colored[b].get(rule) : undefined;
        dot.style.background = look === undefined ? "transparent" : colorOf(theme, look);
      });
    });
  }

  // The path of robot i as a band in the colour of the strongest rule, with its number wherever another one begins
  function drawPath(pen, i, theme, view) {
    const base = Number(color.value);
    if (base < 0 || !root.open) return;
    const key = base * data.count + i;
    if (!along.has(key)) along.set(key, spans(data, base, i));
    const { x, y } = data.channels,
      px = (k) => view.x(x[i * data.frames + k]),
      py = (k) => view.y(y[i * data.frames + k]);
    pen.save();
    pen.setLineDash([]);
    pen.lineWidth = 7;
    pen.lineJoin = "round";
    pen.globalAlpha = 0.55;
    for (const { rule, from, to } of along.get(key)) {
      const look = colored[base].get(rule);
      if (look === undefined) continue;
      pen.strokeStyle = colorOf(theme, look);
      pen.beginPath();
      for (let k = from; k <= Math.min(to + 1, data.frames - 1); k++) pen.lineTo(px(k), py(k));
      pen.stroke();
    }
    pen.globalAlpha = 1;
    pen.font = "600 11px system-ui, 'DejaVu Sans', sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.lineWidth = 3;
    pen.strokeStyle = theme.paper;
    pen.fillStyle = theme.ink;
    const taken = [];
    for (const { rule, from, to } of along.get(key)) {
      if (!colored[base].has(rule)) continue;
      // In the middle of the way that the rule decides, a little beside it
      const middle = (from + to) >> 1,
        next = Math.min(middle + 1, data.frames - 1),
        turn = Math.atan2(py(next) - py(next - 1), px(next) - px(next - 1));
      const at = [px(middle) - 13 * Math.sin(turn), py(middle) + 13 * Math.cos(turn)];
      if (taken.some(([ax, ay]) => Math.hypot(at[0] - ax, at[1] - ay) < APART)) continue;
      taken.push(at);
      pen.strokeText(String(rule), ...at);
      pen.fillText(String(rule), ...at);
    }
    pen.restore();
  }

  for (const node of [root, ...parts.map(({ part }) => part)]) node.addEventListener("toggle", draw);
  const end = () => {
    cancelAnimationFrame(request);
    strip.end();
  };
  return { root, show, drawPath, renew, end };
}
