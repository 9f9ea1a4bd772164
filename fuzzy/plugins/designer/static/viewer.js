// The rule viewer: every rule's clauses cut at their degrees, its firing strength and its proposal, at a point to drag.
import {
  clamp,
  color,
  cut,
  element,
  endOf,
  line,
  put,
  quantity,
  rounded,
  said,
  say,
  shape,
  watch,
  whenSized,
  widthOf,
} from "./chart.js";
import { drag, framed, hold, stepped } from "./dragging.js";
import { clauseDegree, places } from "./membership.js";
import { consequent } from "./outputs.js";
import { columnsOf, paintFoot, strengthOf } from "./rulegrid.js";

const ROW = 56,
  FILL = 30,
  HEAD = 50,
  FOOT = 78, // px
  LABEL = 17; // px at the top of a row, for the names of terms
const ALL = 40, // rules up to which every row is drawn; of more only those in view
  BEYOND = 4; // rows above and below these
const HEDGE_WORDS = { 0.5: "somewhat ", 2: "very ", 3: "extremely ", 4: "very very " };
const clauseText = ({ term, negated, power }) =>
  `${negated ? "not " : ""}${power === 1 ? "" : (HEDGE_WORDS[power] ?? "")}${term}${power === 1 || HEDGE_WORDS[power] ? "" : `^${said(power)}`}`;

export function render({ model, el }) {
  const root = element("div", { class: "fd fd-viewer" }),
    place = hold((message) => model.send(message));
  const own = `fd${Math.random().toString(36).slice(2)}`; // for the names of clips, which the page shares
  const fired = element("input", { type: "checkbox", onchange: () => build() });
  const sorted = element("input", { type: "checkbox", onchange: () => build() });
  const head = shape("svg", { class: "fd-headline", role: "group", "aria-label": "Input point" });
  const body = shape("svg", { class: "fd-grid-of-rules", role: "img" });
  const foot = shape("svg", { class: "fd-footline", role: "img", "data-glance": true });
  const back = shape("g"),
    front = shape("g");
  head.append(back, front);
  // Beside another picture it shows what fires, and says which rule counts most.
  const short = model.get("short") === true;
  fired.checked = sorted.checked = short;
  const because = element("p", { class: "fd-because", hidden: !short });
  const told = element("output", { class: "fd-told" }),
    words = element("pre", { class: "fd-words", tabindex: 0, role: "region", "aria-label": "Explanation" });
  const scroll = element(
    "div",
    { class: "fd-scroll", tabindex: 0, role: "region", "aria-label": "Rules at the point" },
    head,
    body,
    foot,
  );
  root.append(
    element(
      "div",
      { class: "fd-bar" },
      told,
      element(
        "div",
        { class: "fd-checks" },
        element("label", { class: "fd-check", hidden: short }, sorted, "strongest first"),
        element("label", { class: "fd-check" }, fired, short ? "only what fires" : "only rules that fire"),
      ),
    ),
    because,
    element(
      "div",
      { class: "fd-split" },
      scroll,
      element("div", { class: "fd-side" }, element("h2", {}, "In words"), words),
    ),
  );
  el.append(root);

  let width = 0,
    columns = [],
    parts = [],
    sliders = [],
    shown = [], // the rules that have a row, in the rows' order
    drawn = [0, 0], // of these, which are drawn
    held = false, // is the point under the hand?
    looked = ""; // the point that the rows were last brought into view for
  const design = () => model.get("design"),
    viewer = () => model.get("viewer");
  const point = () => place.value("point", model.get("point"));
  const used = (i) => {
    const v = design().inputs[i];
    return design().choices?.out_of_range === "clip" ? clamp(point()[i], v.low, v.high) : point()[i];
  };
  const inForce = () => design().rules.filter((rule) => rule.enabled);
  const results = () => new Map((viewer()?.rules ?? []).map((rule) => [rule.key, rule]));
  const keysOf = (rules) => rules.map((rule) => rule.key).join();
  function ordered(byKey) {
    const strength = (rule) => byKey.get(rule.key)?.firing ?? 0;
    const rules = inForce().filter((rule) => !fired.checked || strength(rule) > 0);
    return sorted.checked ? rules.sort((a, b) => strength(b) - strength(a)) : rules;
  }
  function inView() {
    if (shown.length <= ALL) return [0, shown.length];
    const top = scroll.scrollTop / ROW,
      rows = scroll.clientHeight / ROW;
    return [clamp(Math.floor(top) - BEYOND, 0, shown.length), clamp(Math.ceil(top + rows) + BEYOND, 0, shown.length)];
  }
  // At another point the strongest rule is brought into view, where none that fires is.
  function bringIntoView(byKey) {
    const at = JSON.stringify(viewer()?.point ?? null);
    if (held || at === looked || at === "null") return;
    looked = at;
    const firing = shown.map((rule) => byKey.get(rule.key)?.firing ?? 0),
      strongest = firing.indexOf(Math.max(...firing)),
      room = scroll.clientHeight - HEAD - FOOT,
      seen = (r) => r * ROW >= scroll.scrollTop - 1 && (r + 1) * ROW <= scroll.scrollTop + room + 1;
    if (strongest < 0 || firing.some((value, r) => value > 0 && seen(r)) || !(firing[strongest] > 0)) return;
    scroll.scrollTop = Math.max(0, strongest * ROW - Math.max(0, room - ROW) / 2);
  }

  function move(i, value, pressed) {
    const v = design().inputs[i],
      now = [...point()];
    now[i] = clamp(rounded(value, v.low, v.high), v.low, v.high);
    if (now[i] === point()[i]) return;
    place.take("point", now, { look: "point", point: now }, model.get("point"), pressed);
    paint();
  }
  // Anywhere in an input's column
  for (const area of [head, body]) {
    let i = -1;
    drag(area, {
      start(event) {
        const at = event.clientX - area.getBoundingClientRect().left;
        i = columns.findIndex((column) => column.kind === "input" && at >= column.from - 6 && at <= column.to + 6);
        if (i < 0 || (event.pointerType === "touch" && area === body)) return false; // a finger scrolls the rules
        sliders[i].focus({ preventScroll: true });
        held = true;
        move(i, columns[i].x.value(at), true);
      },
      move(event) {
        move(i, columns[i].x.value(event.clientX - area.getBoundingClientRect().left), true);
      },
      end() {
        held = false;
        place.release();
        paint();
      },
    });
  }

  // What changes with the design: curves, names, frames
  function build() {
    if (width === 0) return;
    const { inputs, outputs } = design(),
      [frames, total] = columnsOf(design(), width),
      rules = ordered(results());
    columns = frames;
    shown = rules;
    const high = Math.max(1, rules.length) * ROW;
    for (const [svg, height] of [
      [head, HEAD],
      [body, high],
      [foot, FOOT],
    ])
      put(svg, { width: total, height, viewBox: `0 0 ${total} ${height}` });
    body.total = total;
    buildHead(inputs, outputs);
    buildRows();
    paint();
  }

  // The rows in view
  function buildRows() {
    const { inputs, outputs } = design(),
      { total } = body,
      rank = new Map(design().rules.map((rule, i) => [rule.key, i + 1]));
    drawn = inView();
    const clips = shape("defs"),
      curves = [],
      written = [];
    parts = shown.slice(...drawn).map((rule, n) => {
      const r = drawn[0] + n,
        top = r * ROW,
        base = top + ROW - 8,
        part = { rule, top, base, clauses: [], stems: [], free: [] };
      curves.push(shape("line", { x1: 0, x2: total, y1: top + ROW - 0.5, y2: top + ROW - 0.5, class: "fd-between" }));
      const name = shape(
        "text",
        { x: 2, y: base - 10, class: "fd-rank" },
        `${rank.get(rule.key)}`,
        shape("title", {}, rule.text),
      );
      curves.push(name);
      if (rule.weight !== 1)
        curves.push(shape("text", { x: 2, y: base + 3, class: "fd-tick fd-small" }, `×${said(rule.weight, 2)}`));
      if (rule.connective === "or" && rule.when.length > 1)
        curves.push(shape("text", { x: 2, y: base - 23, class: "fd-tick fd-small" }, "or"));
      inputs.forEach((variable, i) => {
        const column = columns[i],
          clause = rule.when.find((each) => each.variable === variable.name),
          wide = column.to - column.from;
        curves.push(shape("line", { x1: column.from, x2: column.to, y1: base, y2: base, class: "fd-base" }));
        const t = variable.terms.findIndex((term) => term.name === clause?.term);
        if (t < 0) {
          const why = shape("title", {}, `any ${variable.name}: this rule does not ask for it`),
            any = shape("text", { y: base - 11, "text-anchor": "middle", class: "fd-none" }, "any", why);
          curves.push(any);
          part.free.push([any, i]);
          return;
        }
        const { type, parameters } = variable.terms[t],
          xs = places(parameters, variable.low, variable.high, 81);
        const ys = xs.map((value) => base - FILL * clauseDegree(clause, type, value, parameters)),
          path = line(xs.map(column.x), ys);
        const clip = shape("rect", { x: column.from, width: wide, y: base, height: 0 }),
          id = `${own}-${r}-${i}`;
        clips.append(shape("clipPath", { id }, clip));
        curves.push(
          shape("path", {
            d: `${path}L${column.to} ${base}L${column.from} ${base}Z`,
            class: "fd-cut",
            style: `fill: ${color(t)}`,
            "clip-path": `url(#${id})`,
          }),
          shape("path", { d: path, class: "fd-thin", style: `stroke: ${color(t)}` }),
        );
        written.push(
          shape(
            "text",
            {
              x: column.from + 1,
              y: top + 12,
              class: "fd-clause",
            },
            cut(clauseText(clause), wide - 4, 11),
            shape("title", {}, clauseText(clause)),
          ),
        );
        part.clauses.push({ clip, base, i, clause, type, parameters });
      });
      const firing = columns[inputs.length];
      part.bar = shape("rect", { x: firing.from, y: base - 19, height: 14, class: "fd-firing", "data-rule": rule.key });
      part.number = shape("text", { y: base - 8, class: "fd-tick" });
      curves.push(
        shape("line", { x1: firing.from, x2: firing.from, y1: base - 24, y2: base, class: "fd-base" }),
        part.bar,
        part.number,
      );
      outputs.forEach((variable, j) => {
        const column = columns[inputs.length + 1 + j],
          then = rule.then.find((each) => each.variable === variable.name);
        const t = variable.terms.findIndex((term) => term.name === then?.term);
        curves.push(shape("line", { x1: column.from, x2: column.to, y1: base, y2: base, class: "fd-base" }));
        if (t < 0) {
          curves.push(
            shape(
              "text",
              { x: (column.from + column.to) / 2, y: base - 11, "text-anchor": "middle", class: "fd-none" },
              "–",
            ),
          );
          return;
        }
        const stem = shape("line", { y1: base, y2: base - FILL, class: "fd-stem" }),
          share = shape("line", { y1: base, class: "fd-share" }),
          text = shape("text", { y: top + 12, class: "fd-clause" });
        curves.push(stem, share);
        written.push(text);
        part.stems.push({ stem, share, text, base, j, term: variable.terms[t], column });
      });
      return part;
    });
    // The lines leave the rows' upper rims to the names.
    const lines = inputs.map(() => shape("path", { class: "fd-now-line" }));
    body.replaceChildren(clips, ...curves, ...lines, ...written);
    body.lines = lines;
    if (!shown.length)
      body.append(
        shape("text", { x: 8, y: 27, class: "fd-none" }, fired.checked ? "no rule fires here" : "no rules in force"),
      );
  }

  function buildHead(inputs, outputs) {
    if (sliders.length !== inputs.length) {
      sliders = inputs.map((_, i) => {
        const node = shape(
          "g",
          { class: "fd-point", role: "slider", tabindex: 0 },
          shape("path", { d: "M-7 -11h14L0 0z" }),
        );
        node.addEventListener("keydown", (event) => {
          const { low, high } = design().inputs[i],
            to = stepped(event, point()[i], low, high);
          if (to !== null) move(i, to, false);
        });
        return node;
      });
    }
    const title = (column, first) =>
      shape(
        "text",
        { x: column.from, y: 15, class: "fd-name fd-strong" },
        cut(first, column.to - column.from, 12, 600),
        shape("title", {}, first),
      );
    head.values = columns.map((column) =>
      shape("text", { x: column.from, y: 31, class: column.to - column.from < 70 ? "fd-tick fd-small" : "fd-tick" }),
    );
    const titles = columns.map((column, c) =>
      title(
        column,
        c < inputs.length ? inputs[c].name : c === inputs.length ? "firing" : outputs[c - inputs.length - 1].name,
      ),
    );
    // The sliders stay in the page, and with them the focus.
    back.replaceChildren(...titles, ...head.values);
    if (front.childElementCount !== sliders.length) front.replaceChildren(...sliders);
  }

  // What changes with the point: at once the degrees, when Python has answered the firing and the output
  function paint() {
    if (width === 0) return;
    const { inputs, outputs } = design(),
      byKey = results(),
      at = viewer();
    // Rows do not change places under the hand.
    if (!held && keysOf(ordered(byKey)) !== keysOf(shown)) {
      build();
      return;
    }
    bringIntoView(byKey);
    if (JSON.stringify(inView()) !== JSON.stringify(drawn)) buildRows();
    inputs.forEach((variable, i) => {
      const value = point()[i],
        inside = clamp(value, variable.low, variable.high),
        px = columns[i].x(inside);
      put(body.lines[i], { d: parts.map(({ top, base }) => `M${px} ${top + LABEL}V${base}`).join("") });
      put(sliders[i], {
        transform: `translate(${px} ${HEAD - 1})`,
        "aria-label": variable.name,
        "aria-valuemin": variable.low,
        "aria-valuemax": variable.high,
        "aria-valuenow": inside,
        "aria-valuetext": quantity(value, variable),
      });
      const whole = `= ${quantity(value, variable)}`,
        fits = widthOf(whole, 12) <= columns[i].to - columns[i].from + 8;
      say(head.values[i], fits ? whole : said(value, 3, variable.high - variable.low));
    });
    for (const { rule, clauses, stems, free, bar, number } of parts) {
      // "any" stands where the input's line does not pass.
      for (const [text, i] of free) {
        const { from, to, x } = columns[i];
        put(text, { x: from + (x(point()[i]) > (from + to) / 2 ? 0.22 : 0.78) * (to - from) });
      }
      const degrees = clauses.map(({ clip, base, i, clause, type, parameters }) => {
        const value = clauseDegree(clause, type, used(i), parameters),
          height = FILL * (Number.isFinite(value) ? value : 0);
        put(clip, { y: base - height, height });
        return value;
      });
      const known = byKey.get(rule.key),
        least = known?.least ?? null, // of a type-2 system, of which Python tells both
        firing = least === null ? strengthOf(rule, degrees, design().choices) : known.firing,
        column = columns[inputs.length],
        wide = Math.max(0, column.x(clamp(firing, 0, 1)) - column.from);
      put(bar, { width: wide, "data-firing": firing });
      put(number, { x: column.from + wide + 5 });
      const figures = [least, firing].filter((value) => value !== null);
      say(number, figures.map((value) => (value > 0 && value < 0.005 ? "<0.01" : value.toFixed(2))).join("–"));
      for (const { stem, share, text, base, j, term, column: c } of stems) {
        const value =
            known?.proposed?.[j] ??
            consequent(
              term,
              inputs.map((_, i) => used(i)),
            ),
          px = c.x(value),
          part = known?.share?.[j] ?? 0;
        put(stem, { x1: px, x2: px });
        put(share, { x1: px, x2: px, y2: base - FILL * part });
        put(text, { x: c.from });
        const short = said(value, 3, c.ends[1] - c.ends[0]),
          figure = ` = ${short}`,
          name = cut(term.name, c.to - c.from - widthOf(figure, 11), 11);
        say(text, name === term.name || name.length > 4 ? name + figure : short);
      }
    }
    paintFoot(foot, columns, at, design());
    say(words, at?.words ?? "");
    const between = (v, [low, high]) => ` (${quantity(low, { ...v, unit: "" })} to ${quantity(high, v)})`;
    const answer = outputs.map(
      (v, j) =>
        `${v.name} = ${at?.output?.[j] === null || at?.output?.[j] === undefined ? "not a number" : quantity(at.output[j], v)}${at && at.fired?.[j] === false ? " (no rule fires)" : ""}${at?.interval?.[j] ? between(v, at.interval[j]) : ""}`,
    );
    say(told, answer.join(",  "));
    if (short) say(because, strongest(at));
    put(body, {
      "aria-label": `${shown.length} rules at ${inputs.map((v, i) => `${v.name} ${quantity(point()[i], v)}`).join(", ")}`,
    });
  }

  /** The rule that counts most, in its own words. */
  function strongest(at) {
    const share = ({ share: shares }) => Math.max(0, ...shares.filter(Number.isFinite));
    const best = (at?.rules ?? []).reduce((a, b) => (a && share(a) >= share(b) ? a : b), null);
    const place = design().rules.findIndex((rule) => rule.key === best?.key);
    if (place < 0 || !(share(best) > 0)) return "No rule fires here.";
    return `Rule ${place + 1} counts most, ${Math.round(100 * share(best))} %: ${design().rules[place].text}`;
  }

  const scrolled = framed(() => {
    if (width > 0 && JSON.stringify(inView()) !== JSON.stringify(drawn)) paint();
  });
  scroll.addEventListener("scroll", () => scrolled());
  const ends = [
    scrolled.cancel,
    watch(model, ["design"], () => build()),
    watch(model, ["viewer", "point"], () => {
      place.settle("point", model.get("point"));
      paint();
    }),
    whenSized(scroll, () => {
      width = scroll.clientWidth;
      build();
    }),
  ];
  return endOf(root, ...ends, place.drop);
}

export default { render };
