// What the designer's modules share: elements, numbers as text, scales, ticks, axes and the model's news.

/** An HTML element; "on..." adds a listener, true and null set and leave out an attribute. */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  if (tag === "button") node.type = "button"; // it sends no form unless its attributes say so
  return filled(node, attributes, children);
}

/** An SVG element, in the same way. */
export function shape(tag, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.filter((child) => child !== null));
  return node;
}

/** The numbers of a drawing, by its svg: columns of a name and values; kept by whoever draws it. */
export const numbersOf = new WeakMap();

/** Set attributes that differ. */
export function put(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === false) node.removeAttribute(name);
    else if (node.getAttribute(name) !== String(value)) node.setAttribute(name, value);
  }
  return node;
}

/** Set a text that differs. */
export function say(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Give a node other children; those that are alike stay, and the page need not lay them out. None may have listeners. */
export function refill(node, ...children) {
  const old = [...node.childNodes];
  children.forEach((child, n) => {
    if (n >= old.length) node.append(child);
    else if (!old[n].isEqualNode(child)) old[n].replaceWith(child);
  });
  for (const extra of old.slice(children.length)) extra.remove();
}

/**
 * Put style sheets into the page, each once; done when they are in force, for what measures. They stand beside the module
 * at `base`, its import.meta.url.
 */
export async function styled(base, ...sheets) {
  const loaded = (href) =>
    new Promise((done, fail) => {
      const known = [...document.head.querySelectorAll("link[rel=stylesheet]")].find((link) => link.href === href);
      if (known?.sheet) return void done();
      const link = known ?? element("link", { rel: "stylesheet", href });
      link.addEventListener("load", done);
      link.addEventListener("error", () => fail(new Error(`the style sheet ${href} cannot be loaded`)));
      if (!known) document.head.append(link);
    });
  await Promise.all(sheets.map((sheet) => loaded(new URL(sheet, base).href)));
}

/** Draw before the next picture, however often it is asked for until then; `end` takes the wish back. */
export function framed(draw) {
  let request = 0;
  const soon = () => {
    request ||= requestAnimationFrame(() => {
      request = 0;
      draw();
    });
  };
  return { soon, end: () => cancelAnimationFrame(request) };
}

// Icons are drawn: not every system's typeface has the signs.
const ICONS = {
  plus: "M8 3v10M3 8h10",
  cross: "M4 4l8 8M12 4l-8 8",
  up: "M8 13V3M4 7l4-4 4 4",
  down: "M8 3v10M4 9l4 4 4-4",
  copy: "M6 5h7v9H6zM3 11V2h7",
  check: "M3 8l3 4 7-8",
  bin: "M3 4h10M6 4V2h4v2M4.5 4l.6 10h5.8l.6-10",
};

/** A button with a sign, and with words where `text` says so, which are its name then; else `label` is. */
export function button(icon, label, onclick, text = null) {
  const sign =
    icon &&
    shape(
      "svg",
      { viewBox: "0 0 16 16", width: 14, height: 14, "aria-hidden": "true", class: "fd-icon" },
      shape("path", { d: ICONS[icon] }),
    );
  const attributes = {
    class: text ? "fd-button" : "fd-button fd-square",
    "aria-label": text ? null : label,
    title: label,
    onclick,
  };
  return element("button", attributes, sign || null, text ? element("span", {}, text) : null);
}

/** A list to choose from; options are [value, text]. */
export function choices(label, options, chosen, react) {
  const select = element("select", { "aria-label": label, onchange: () => react(select.value) });
  offer(select, options, chosen);
  return select;
}

const OFFERS = new Map(), // options by their key: the lists of a long table are alike, and copies are made faster
  MOST_OFFERS = 100;

/** Give a list other options, where they differ. */
export function offer(select, options, chosen) {
  const key = JSON.stringify(options);
  if (select.dataset.options !== key) {
    select.dataset.options = key;
    if (OFFERS.size > MOST_OFFERS) OFFERS.clear();
    if (!OFFERS.has(key)) {
      const made = document.createDocumentFragment();
      made.append(...options.map(([value, text]) => element("option", { value }, text)));
      OFFERS.set(key, made);
    }
    select.replaceChildren(OFFERS.get(key).cloneNode(true));
  }
  if (select.value !== String(chosen)) select.value = String(chosen);
}

/** A list that has only its chosen option until it is used: hundreds of lists with all of theirs are slow to lay out. */
export function shortChoices(label, react) {
  const select = choices(label, [], "", react);
  let all = [];
  for (const name of ["focus", "pointerdown"]) select.addEventListener(name, () => offer(select, all, select.value));
  /** Give it other options, as offer() does. */
  select.offer = (options, chosen) => {
    all = options;
    const open = document.activeElement === select;
    offer(select, open ? options : options.filter(([value]) => value === String(chosen)), chosen);
  };
  return select;
}

let notes = 0; // ids must differ; nothing else is kept

/** Say in `note` why a field was refused, under the field; without one, `home` puts the note where it belongs. */
export function sayUnder(note, text, field, home) {
  note.id ||= `fd-note-${++notes}`;
  for (const old of document.querySelectorAll(`[aria-describedby="${note.id}"]`)) {
    old.removeAttribute("aria-describedby");
    old.removeAttribute("aria-invalid");
  }
  const under = text ? (field?.closest("label") ?? null) : null;
  if (under === null) home(note);
  else {
    if (note.parentElement !== under) under.append(note);
    put(field, { "aria-describedby": note.id, "aria-invalid": "true" });
  }
  note.hidden = text === "";
  say(note, text);
}

/** What a field for numbers takes, in a sentence. */
export function takes(input, name) {
  const { min, max, step } = input,
    kind = step === "1" ? "whole number" : "number";
  const least = min === "" ? "" : ` of at least ${min}`;
  return `${name} takes a ${kind}${max === "" ? least : ` from ${min} to ${max}`}.`;
}

// Numbers ------------------------------------------------------------------------------------------------------

// Rounding leaves about 1e-16 of what was summed; this much of a range is nothing that anybody set (fuzzy/shown.py).
const DUST = 1e-9;
const cleaned = (value, span) => (Math.abs(value) < DUST * span ? 0 : value);

/** A number as a label shows it: four significant digits, a true minus sign, no −0, no dust of a range `span` wide. */
export function said(value, digits = 4, span = 0) {
  if (value === null || !Number.isFinite(value)) return "–";
  const rounded = Number(cleaned(value, span).toPrecision(digits)) + 0,
    size = Math.abs(rounded);
  const text = size !== 0 && (size < 1e-4 || size >= 1e6) ? rounded.toExponential() : String(rounded);
  return text.replace(/-/g, "−");
}

/** A number as a field holds it, to be typed over: six digits and a hyphen as its sign. */
export const typed = (value, span = 0) =>
  Number.isFinite(value) ? String(Number(cleaned(value, span).toPrecision(6)) + 0) : "";

/** A value of a variable as a label shows it, with its unit and without dust. */
export const quantity = (value, { unit, low = 0, high = 0 }, digits = 4) =>
  said(value, digits, high - low) + (unit ? ` ${unit}` : "");
export const labelled = (variable) => (variable.unit ? `${variable.name} [${variable.unit}]` : variable.name);
export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));
export const color = (i) => `var(--ff-c${i % 7})`;

/** A value rounded to about a thousandth of the range: what a hand can mean, and no more digits. */
export function rounded(value, low, high) {
  const step = 10 ** Math.floor(Math.log10((high - low || 1) / 1000));
  return Number((Math.round(value / step) * step).toPrecision(12));
}

/** Round numbers from low to high, at most about `most`. */
export function ticks(low, high, most) {
  if (!(high > low)) return [low];
  const rough = (high - low) / Math.max(1, most),
    power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((m) => m >= rough * 0.999);
  const out = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + step * 1e-9; n++)
    out.push(Number((n * step).toPrecision(12)));
  return out;
}

/** A straight scale from [low, high] to pixels, with its inverse. */
export function scale(low, high, from, to) {
  const span = high - low || 1,
    f = (value) => from + ((value - low) / span) * (to - from);
  f.value = (pixel) => low + ((pixel - from) / (to - from)) * span;
  f.ends = [low, high];
  return f;
}

let pen = null;
/** The width of a line of text in pixels. */
export function widthOf(text, size = 12, weight = 400) {
  pen ??= document.createElement("canvas").getContext("2d");
  pen.font = `${weight} ${size}px system-ui, "Segoe UI", "DejaVu Sans", sans-serif`;
  return pen.measureText(text).width;
}

/** As much of a text as is `width` pixels wide. */
export function cut(text, width, size = 12, weight = 400) {
  if (widthOf(text, size, weight) <= width) return text;
  let rest = text;
  while (rest && widthOf(`${rest}…`, size, weight) > width) rest = rest.slice(0, -1);
  return `${rest.trimEnd()}…`;
}

// Drawing ------------------------------------------------------------------------------------------------------

/** A path through points; a number that is none breaks the line. */
export function line(xs, ys) {
  let out = "",
    down = false;
  for (let k = 0; k < xs.length; k++) {
    const known = Number.isFinite(xs[k]) && Number.isFinite(ys[k]);
    if (known) out += `${down ? "L" : "M"}${xs[k].toFixed(2)} ${ys[k].toFixed(2)}`;
    down = known;
  }
  return out;
}

/** A picture that is drawn on: what it shows is said by its label. */
export const plot = (label = null) => shape("svg", { class: "pn-plot", role: "img", "aria-label": label });

/** Give a picture its height, and the width of what holds it; the box of its axes between these margins [px]. */
export function boxed(svg, height, { left = 62, right = 14, below = 44, held = svg.parentElement.clientWidth } = {}) {
  const width = Math.max(240, held);
  put(svg, { viewBox: `0 0 ${width} ${height}`, height });
  return { left, right: width - right, top: 26, bottom: height - below };
}

/** A line's look, and what it is. */
export const keyed = (kind, text, stroke = null) =>
  element(
    "span",
    {},
    shape(
      "svg",
      { width: 34, height: 10, "aria-hidden": "true" },
      shape("path", { d: "M1 5H33", class: kind, stroke }),
    ),
    text,
  );

/** Where values stand on a scale [px]; what is not known is no number. */
export const pixels = (values, scale) => values.map((value) => (value === null ? NaN : scale(value)));

/** A path through points of which each holds until the next. */
export function heldLine(xs, ys) {
  const across = xs.flatMap((x, k) => (k > 0 ? [x, x] : [x])),
    up = ys.flatMap((y, k) => (k > 0 ? [ys[k - 1], y] : [y]));
  return line(across, up);
}

const END = 13; // px right of a box that its numbers may take

/** The two axes of a box {left, right, top, bottom}: grid lines, numbers and names, into a group. */
export function axes(box, x, y, names, ys = null) {
  const group = shape("g", { class: "fd-axes", "aria-hidden": "true" });
  const across = ticks(...x.ends, Math.max(2, Math.floor((box.right - box.left) / 70)));
  for (const value of across) {
    const px = x(value);
    group.append(shape("line", { x1: px, x2: px, y1: box.top, y2: box.bottom, class: "fd-grid" }));
    // The last number may be wider than the room right of its line.
    const text = said(value),
      at = Math.min(px, box.right + END - widthOf(text, 12) / 2);
    group.append(shape("text", { x: at, y: box.bottom + 22, "text-anchor": "middle", class: "fd-tick" }, text));
  }
  for (const value of ys ?? ticks(...y.ends, Math.max(2, Math.floor((box.bottom - box.top) / 36)))) {
    const py = y(value);
    group.append(shape("line", { x1: box.left, x2: box.right, y1: py, y2: py, class: "fd-grid" }));
    // A number that is wider than the margin is not cut: it reaches into the picture.
    const text = said(value),
      at = Math.max(box.left - 12, widthOf(text, 12) + 2);
    group.append(shape("text", { x: at, y: py + 4, "text-anchor": "end", class: "fd-tick" }, text));
  }
  group.append(shape("line", { x1: box.left, x2: box.right, y1: box.bottom, y2: box.bottom, class: "fd-axis" }));
  const wide = box.right - box.left;
  if (names[0])
    group.append(
      shape(
        "text",
        { x: (box.left + box.right) / 2, y: box.bottom + 42, "text-anchor": "middle", class: "fd-name" },
        cut(names[0], wide, 12),
      ),
    );
  if (names[1])
    group.append(
      shape("text", { x: Math.max(2, box.left - 36), y: box.top - 12, class: "fd-name" }, cut(names[1], wide, 12)),
    );
  return group;
}

/** Rows for labels that must not meet: the row of each {x, width}, from 0; they move a little sideways to fit in. */
export function rowsOf(labels, low, high, gap = 8) {
  const ends = [];
  const order = labels.map((label, i) => [label, i]).sort((a, b) => a[0].x - b[0].x);
  const out = new Array(labels.length);
  for (const [label, i] of order) {
    const left = clamp(label.x - label.width / 2, low, Math.max(low, high - label.width));
    let row = ends.findIndex((end) => left >= end + gap);
    if (row < 0) row = ends.length;
    ends[row] = left + label.width;
    out[i] = { row, x: left + label.width / 2 };
  }
  return out;
}

// News ------------------------------------------------------------------------------------------------------

/** Call f when some of the model's values change, once for those that change together; returns what ends it. */
export function watch(model, names, f) {
  let waiting = false,
    ended = false;
  const now = () => {
    waiting = false;
    if (!ended) f();
  };
  const soon = () => {
    if (!waiting) queueMicrotask(now);
    waiting = true;
  };
  for (const name of names) model.on(`change:${name}`, soon);
  return () => {
    ended = true;
    for (const name of names) model.off(`change:${name}`, soon);
  };
}

/** Call f now, whenever the width of `node` changes, and when it is shown again; returns what ends it. */
export function whenSized(node, f) {
  let width = -1;
  const observer = new ResizeObserver(() => {
    if (node.clientWidth === width) return;
    width = node.clientWidth;
    if (width) f();
  });
  observer.observe(node);
  return () => observer.disconnect();
}

const measured = new WeakMap();
/**
 * The height that a picture may take below what stands above it on the canvas, however much is said below why [px];
 * endless where it is on no canvas of its own. It is measured anew for another `key`: each measuring lays the page out.
 */
export function heightLeft(node, key) {
  const [known, left] = measured.get(node) ?? [];
  const now = `${key} ${innerHeight}`;
  if (known === now) return left;
  const view = node.closest(".shell-view"),
    group = view?.closest(".shell-group");
  if (!group || view.clientHeight === 0) return Infinity; // in a notebook, or hidden
  let room = Infinity;
  if (getComputedStyle(view).overflowY === "auto") {
    const why = parseFloat(getComputedStyle(group.lastElementChild).maxHeight) / 100, // at most
      above = node.getBoundingClientRect().top + view.scrollTop - group.getBoundingClientRect().top;
    room = group.clientHeight * (1 - why) - above;
  }
  measured.set(node, [now, room]);
  return room;
}

/** Call f whenever `node` is shown after it was hidden; returns what ends it. */
export function whenShown(node, f) {
  let shown = false;
  const observer = new ResizeObserver(() => {
    const now = node.clientWidth > 0;
    if (now && !shown) f();
    shown = now;
  });
  observer.observe(node);
  return () => observer.disconnect();
}

/** What ends a module: all its `ends`, and the root goes. */
export const endOf =
  (root, ...ends) =>
  () => {
    for (const end of ends) end();
    root.remove();
  };

/**
 * Draw a module now, and again before the next picture whenever one of these values or its width changes; returns what
 * ends it: further `ends`, and the root goes.
 */
export function keepDrawn(model, names, root, draw, ...ends) {
  const { soon, end } = framed(draw);
  ends.push(end, watch(model, names, soon), whenSized(root, soon));
  draw();
  return endOf(root, ...ends);
}
