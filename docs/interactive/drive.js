// A rule base steers a robot in the reader's browser, beside rules that stay and a nonlinear law, in the same noise.
import { begin } from "./alone.js";
import { packed, simulator } from "./simulator.js";
import {
  axes,
  boxed,
  button,
  choices,
  color,
  element,
  framed,
  keyed,
  line,
  put,
  said,
  say,
  scale,
  shape,
  watch,
  whenSized,
} from "../../fuzzy/plugins/designer/static/chart.js";

const LAWS = ["your rules", "correcting rules as they come", "Lyapunov"];
const SETTLED = 10; // s: how far off the robot is from then on is told
const KINDS = { i: "inputs", o: "outputs" };
const CROSS = "M0 -4V4M-4 0H4"; // px
const ROBOT = "M12 0L-7 7L-3 0L-7 -7Z"; // px, driving to the right

/** The text of a .fis file with the parameters of a design. */
export function fisText(text, design) {
  let terms = [];
  const lines = text.split("\n").map((each) => {
    const part = each.match(/^\[(Input|Output)(\d+)\]/);
    if (part) terms = design[`${part[1].toLowerCase()}s`][part[2] - 1].terms;
    return each.replace(/^(MF(\d+)=.*,)\[.*\]/, (_, head, n) => `${head}[${terms[n - 1].parameters.join(" ")}]`);
  });
  return lines.join("\n");
}

/** What a link says: the choices, each within its bounds, and the design of its rule base with the changed terms. */
export function stated(data, link) {
  const given = new URLSearchParams(link.replace(/^#/, "")),
    state = { base: "tracking", path: "sine", seed: "1", noise: 3, latency: 30 };
  for (const [name, known] of Object.entries({ base: data.bases, path: data.paths, seed: data.draws }))
    if (Object.hasOwn(known, given.get(name))) state[name] = given.get(name);
  for (const [name, { max, step }] of Object.entries(data.sliders)) {
    const value = Number(given.get(name) ?? NaN);
    if (value >= 0 && value <= max) state[name] = Math.round(value / step) * step;
  }
  const design = structuredClone(data.bases[state.base].design);
  for (const [name, text] of given) {
    const [, kind, variable, term] = name.match(/^([io])(\d+)\.(\d+)$/) ?? [],
      own = design[KINDS[kind]]?.[variable]?.terms[term],
      values = text.split(",").map(Number);
    const ordered = kind === "o" || values.every((value, k) => k === 0 || value >= values[k - 1]);
    if (own?.parameters.length === values.length && values.every(Number.isFinite) && ordered) own.parameters = values;
  }
  return { ...state, design };
}

/** The link that says it. */
export function linked(data, { design, ...state }) {
  const parts = new URLSearchParams(state);
  for (const [kind, variables] of Object.entries(KINDS))
    data.bases[state.base].design[variables].forEach((variable, v) =>
      variable.terms.forEach(({ parameters }, t) => {
        const now = design[variables][v].terms[t].parameters.join();
        if (now !== parameters.join()) parts.set(`${kind}${v}.${t}`, now);
      }),
    );
  return `#${parts.toString().replaceAll("%2C", ",")}`;
}

/** Put the page into an element. */
export async function drive(el, data) {
  const sim = await simulator(data);
  const time = Float64Array.from({ length: data.samples }, (_, k) => k * data.period),
    last = time.at(-1),
    settled = Math.round(SETTLED / data.period);
  let state = stated(data, location.hash),
    model = null,
    others = "", // the choices under which the laws that stay have driven
    runs = [],
    road = null, // where the reference is, and the picture's bounds
    width = 0, // px
    now = last,
    playing = 0;

  // Parts
  const soon = framed(() => paint()).soon;
  const chosen = (name, value) => {
    state[name] = value;
    soon();
  };
  const select = (words, name, options, react) => {
    const list = choices(words, options, state[name], react);
    return element("label", {}, element("span", {}, words), list);
  };
  const slider = (words, unit, limits, value, react) => {
    const text = (number) => `${said(number, 3)} ${unit}`,
      told = element("span", { class: "drive-value" }, text(value));
    const input = element("input", { type: "range", min: 0, ...limits, value, "aria-label": words });
    const show = (number) => (say(told, text(number)), put(input, { "aria-valuetext": text(number) }));
    input.addEventListener("input", () => (show(Number(input.value)), react(Number(input.value))));
    show(value);
    return { node: element("label", {}, element("span", {}, words), input, told), input, show };
  };
  const controls = element("div", { class: "drive-controls", role: "group", "aria-label": "What is driven" });
  const titles = (of) => Object.entries(of).map(([key, { title }]) => [key, title]);
  const clock = slider("Time", "s", { max: last, step: data.period }, last, (value) => ((now = value), mark()));
  const play = button(null, "drive on the picture, in the robot's time", () => (playing ? stop() : start()), "Play");
  const picture = shape("svg", { role: "img", "aria-label": "The reference from above, and the path under each law" }),
    chart = shape("svg", { role: "img", "aria-label": "How far the robot is from its reference, over time" });
  const told = LAWS.map(() => element("span"));
  const key = element("div", { class: "drive-key" }, ...LAWS.map((_, n) => keyed("drive-line", told[n], color(n))));
  const file = element("a", { href: "#", class: "drive-file" });
  file.addEventListener("click", () => {
    const text = fisText(data.bases[state.base].text, model.get("design"));
    put(file, { download: `${state.base}.fis`, href: `data:text/plain;charset=utf-8,${encodeURIComponent(text)}` });
  });
  const back = button(null, "the rules as they came", () => begun(data.bases[state.base].design), "Start over");
  const rules = element("div", { class: "alone" });
  const top = element(
    "div",
    { class: "drive-top" },
    picture,
    element("div", { class: "drive-clock" }, play, clock.node),
    key,
  );
  const below = element("p", {}, back, " ", file, " and open it in the designer: ", element("code"));
  el.append(controls, top, rules, below, chart);

  // The choices stand in the page anew when a link is followed.
  function chose() {
    const sliders = Object.entries(data.sliders).map(([name, { words, unit, max, step }]) =>
      slider(words, unit, { max, step }, state[name], (value) => chosen(name, value)),
    );
    controls.replaceChildren(
      select("Rule base", "base", titles(data.bases), (base) => {
        state.base = base;
        begun(data.bases[base].design);
      }),
      select("Path", "path", titles(data.paths), (path) => chosen("path", path)),
      select(
        "Noise's seed",
        "seed",
        Object.keys(data.draws).map((seed) => [seed, seed]),
        (seed) => chosen("seed", seed),
      ),
      ...sliders.map(({ node }) => node),
    );
  }

  function begun(design) {
    const { point, selected } = data.bases[state.base];
    rules.replaceChildren();
    const values = { functions: data.functions, point, selected, compared: null, histograms: [], problem: null };
    model = begin(rules, { ...values, design: structuredClone(design) }, ["Membership functions"]);
    watch(model, ["design"], paint);
    say(file, `Download ${state.base}.fis`);
    say(below.querySelector("code"), `fuzzy design ${state.base}.fis`);
    paint();
  }

  // Drive, draw
  const column = (rows, width, n) => Float64Array.from({ length: data.samples }, (_, k) => rows[width * k + n]);
  /** A run under a law: where the robot is, how far off [mm], and that in words. */
  function run(law, base, design) {
    const given = { ...state, noise: state.noise / 1000, latency: state.latency / 1000 };
    const trace = sim.drive(law, given, base && packed(base, design)),
      [x, y, heading] = [0, 1, 2].map((n) => column(trace, 3, n)),
      aims = sim.aims(state.path);
    const off = x.map((at, k) => 1000 * Math.hypot(at - aims[5 * k], y[k] - aims[5 * k + 1])),
      late = off.subarray(settled),
      most = Math.max(...late),
      mean = late.reduce((sum, each) => sum + each, 0) / late.length,
      end = x.findIndex(Number.isNaN);
    const after = `${said(mean, 3)} mm, at most ${said(most, 3)} mm`,
      words = end < 0 ? after : `stopped at ${said((end - 1) * data.period, 3)} s`;
    return { time, x, y, heading, off, most, words };
  }
  let remembered = 0;
  function paint() {
    const design = model.get("design"),
      published = data.bases.correcting,
      under = JSON.stringify([state.path, state.seed, state.noise, state.latency]);
    if (others !== under) {
      const [ax, ay] = [0, 1].map((n) => column(sim.aims(state.path), 5, n)),
        ends = [ax, ay].flatMap((row, n) => {
          const all = [...row, data.paths[state.path].start[n]];
          return [Math.min(...all) - 0.4, Math.max(...all) + 0.4];
        });
      road = { ax, ay, bounds: ends };
      runs = [null, run("correcting", published, published.design), run("lyapunov", null)];
      others = under;
    }
    runs[0] = run(state.base, data.bases[state.base], design);
    draw();
    clearTimeout(remembered); // browsers refuse more than some links in a second
    remembered = setTimeout(() => history.replaceState(null, "", linked(data, { ...state, design })), 250);
  }

  const layers = new Map();
  /** The parts of a picture that stay while its axes do: {x, y, paths, marks, runs that are drawn}. */
  function layer(svg, box, x, y, names, mark) {
    const key = JSON.stringify([box, x.ends, y.ends]);
    if (layers.get(svg)?.key !== key) {
      const { left, top, right, bottom } = box,
        id = `drive-${names[0][0]}`;
      const frame = shape("rect", { x: left, y: top, width: right - left, height: bottom - top });
      const paths = LAWS.map((_, n) => shape("path", { class: "drive-line", stroke: color(n) })),
        marks = LAWS.map((_, n) => shape("path", { d: mark, fill: color(n), stroke: color(n) }));
      const aim = shape("path", { class: "drive-line drive-aim" });
      const inside = shape("g", { "clip-path": `url(#${id})` }, aim, ...[...paths].reverse(), ...[...marks].reverse());
      svg.replaceChildren(shape("clipPath", { id }, frame), axes(box, x, y, names), inside);
      layers.set(svg, { key, x, y, aim, paths, marks, runs: [] });
    }
    return layers.get(svg);
  }
  function trace({ x, y, paths, runs: drawn }, across, up) {
    runs.forEach((each, n) => {
      if (drawn[n] !== each) put(paths[n], { d: line(each[across].map(x), each[up].map(y)) });
      drawn[n] = each;
    });
  }

  function draw() {
    if (!width || !runs[0]) return;
    const { ax, ay, bounds } = road,
      [west, east, south, north] = bounds,
      perMetre = Math.min((width - 76) / (east - west), 240 / (north - south));
    const box = boxed(picture, Math.round((north - south) * perMetre) + 74, { held: width }),
      half = (box.right - box.left) / perMetre / 2,
      x = scale((west + east) / 2 - half, (west + east) / 2 + half, box.left, box.right),
      y = scale(south, north, box.bottom, box.top);
    const map = layer(picture, box, x, y, ["x [m]", "y [m]"], ROBOT);
    if (!map.runs.length) put(map.aim, { d: line(ax.map(x), ay.map(y)) });
    trace(map, "x", "y");
    const most = Math.max(20, ...runs.map((each) => each.most || 0)),
      power = 10 ** Math.floor(Math.log10(most)),
      high = [1, 2, 5, 10].map((m) => m * power).find((m) => m >= most);
    const own = boxed(chart, 190, { held: width }),
      [across, up] = [scale(0, last, own.left, own.right), scale(0, high, own.bottom, own.top)];
    trace(layer(chart, own, across, up, ["time [s]", "off the reference [mm]"], CROSS), "time", "off");
    runs.forEach(({ words }, n) => say(told[n], `${LAWS[n]}: ${words}`));
    mark();
  }

  // Where the robots are now; between two periods on the straight line
  function mark() {
    const place = Math.min(now / data.period, data.samples - 1.001),
      k = Math.floor(place),
      between = (row) => row[k] + (place - k) * (row[k + 1] - row[k]);
    runs.forEach(({ x, y, heading, off }, n) => {
      const turn = (-between(heading) * 180) / Math.PI,
        there = Number.isFinite(turn),
        move = (of, px, py, more = "") =>
          put(of.marks[n], {
            display: there ? null : "none",
            transform: there && `translate(${of.x(px)} ${of.y(py)})${more}`,
          });
      move(layers.get(picture), between(x), between(y), ` rotate(${turn})`);
      move(layers.get(chart), now, between(off));
    });
  }

  function start() {
    const since = performance.now() - 1000 * (now >= last ? 0 : now);
    const step = (at) => {
      now = Math.max(0, (at - since) / 1000);
      clock.input.value = now;
      clock.show(Math.floor(10 * now) / 10);
      mark();
      if (now >= last) stop();
      else playing = requestAnimationFrame(step);
    };
    playing = requestAnimationFrame(step);
    say(play.lastChild, "Pause");
  }
  function stop() {
    cancelAnimationFrame(playing);
    playing = 0;
    now = Math.min(now, last);
    say(play.lastChild, "Play");
  }

  addEventListener("hashchange", ({ newURL }) => {
    state = stated(data, new URL(newURL).hash);
    chose();
    begun(state.design);
  });
  whenSized(el, () => {
    width = el.clientWidth;
    draw();
    el.dataset.ready = "";
  });
  chose();
  begun(state.design);
}
