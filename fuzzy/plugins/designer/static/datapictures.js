// Measured rows beside a system: histograms under the memberships, predicted against measured, residuals, errors and the
// worst rows. From what data_pictures in fuzzy/plugins/designer/datapictures.py makes; the panels Data and Train show it.
import {
  axes,
  choices,
  color,
  element,
  labelled,
  line,
  pixels,
  offer,
  put,
  quantity,
  said,
  say,
  scale,
  shape,
  ticks,
} from "./chart.js";
import { bars, tallest } from "./histogram.js";
import { degree, places } from "./membership.js";

const NEAR = 16; // px from a point within which a click means it
const KINDS = ["dp-first", "dp-second"]; // the looks of training and checking rows

/** The memberships of an input with the histogram of the rows on the same abscissa, and both in words. */
function coverage(variable, histogram, width) {
  const box = { left: 44, right: width - 14, top: 26, bottom: 116 },
    below = { ...box, top: 128, bottom: 188 };
  const x = scale(variable.low, variable.high, box.left, box.right),
    y = scale(0, 1, box.bottom, box.top),
    most = tallest(histogram);
  const over = axes(box, x, y, [null, "degree"], [0, 0.5, 1]);
  for (const text of over.querySelectorAll("text[text-anchor=middle]")) text.remove(); // they stand below the histogram
  const under = axes(below, x, scale(0, most, below.bottom, below.top), [labelled(variable), null], [0, most]);
  const curve = (term, k) => {
    const xs = places(term.parameters, variable.low, variable.high);
    const ys = xs.map((v) => y(degree(term.type, v, term.parameters)));
    return shape("path", { d: line(xs.map(x), ys), class: "dp-curve", style: `stroke: ${color(k)}` });
  };
  const picture = shape(
    "svg",
    {
      class: "pn-plot",
      role: "img",
      viewBox: `0 0 ${width} 234`,
      height: 234,
      "aria-label": `Memberships of ${variable.name}, and how many rows lie where. ${histogram.words}`,
    },
    over,
    under,
    bars(histogram, x, below.top, below.bottom),
    ...variable.terms.map(curve),
  );
  return element("div", {}, picture, element("p", { class: "pn-note" }, histogram.words));
}

/** A range round some values, a little wider than they are. */
function around(values, ...more) {
  let [low, high] = [Infinity, -Infinity];
  for (const v of [...values, ...more]) {
    if (!Number.isFinite(v)) continue;
    low = Math.min(low, v);
    high = Math.max(high, v);
  }
  if (!(low <= high)) return [0, 1];
  const room = high > low ? 0.04 * (high - low) : Math.abs(low) || 1;
  return [low - room, high + room];
}

/**
 * Points over two axes. The one under the pointer, or that the arrow keys walk to, is said below; a click or Enter looks
 * at its row: look(row). draw({title, names, xs, ys, ends, guide, kinds, about, rows, width}): ends are the ranges of the
 * axes, guide a line from one corner of them to another, about(k) the words of a point.
 */
function cloud(look) {
  const svg = shape("svg", { class: "pn-plot dp-cloud", role: "group" }),
    back = shape("g"),
    dots = KINDS.map((kind) => shape("path", { class: `dp-points ${kind}` }));
  const mark = shape("circle", { r: 6.5, class: "dp-mark" }),
    ring = shape("rect", { class: "dp-ring", rx: 3 }),
    slider = shape("g", { role: "slider", tabindex: 0, class: "dp-cursor" }, ring, mark);
  svg.append(back, ...dots, slider);
  const title = element("h4"),
    words = element("p", { class: "pn-note dp-said" });
  const node = element("div", {}, title, svg, words);
  let view = null,
    px = [],
    py = [],
    order = [],
    at = -1; // the point that is marked

  function show(k) {
    at = k;
    const row = k < 0 ? null : view.rows[k];
    mark.style.display = row === null ? "none" : "";
    if (row !== null) put(mark, { cx: px[k], cy: py[k] });
    const text = row === null ? "" : view.about(k);
    say(words, text);
    put(slider, {
      "aria-label": `${view.title}: a row`,
      "aria-valuemin": 1,
      "aria-valuemax": Math.max(1, order.length),
      "aria-valuenow": row === null ? 1 : order.indexOf(k) + 1,
      "aria-valuetext": text || "none chosen yet; the arrow keys choose, Enter looks at the row in the viewer",
    });
  }
  function near(event) {
    const box = svg.getBoundingClientRect(),
      share = view.width / box.width, // the picture may be drawn smaller than it is
      [x, y] = [(event.clientX - box.left) * share, (event.clientY - box.top) * share];
    let best = -1,
      least = NEAR ** 2;
    for (let k = 0; k < px.length; k++) {
      const away = (px[k] - x) ** 2 + (py[k] - y) ** 2;
      if (away < least) [best, least] = [k, away];
    }
    return best;
  }
  svg.addEventListener("pointermove", (event) => {
    const k = near(event);
    svg.style.cursor = k < 0 ? "" : "pointer";
    if (k >= 0) show(k);
  });
  svg.addEventListener("click", (event) => {
    const k = near(event);
    if (k < 0) return;
    show(k);
    look(view.rows[k]);
  });
  slider.addEventListener("keydown", (event) => {
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      if (at >= 0) look(view.rows[at]);
      return;
    }
    const now = order.indexOf(at),
      step = event.shiftKey ? 10 : 1,
      last = order.length - 1;
    const to = {
      ArrowLeft: now - step,
      ArrowDown: now - step,
      ArrowRight: now + step,
      ArrowUp: now + step,
      Home: 0,
      End: last,
    }[event.key];
    if (to === undefined || last < 0) return;
    event.preventDefault();
    show(order[Math.min(last, Math.max(0, to))]);
  });

  return {
    node,
    draw(next) {
      const before = at < 0 ? null : view.rows[at];
      view = next;
      const { width } = view,
        height = Math.min(300, Math.max(220, 0.6 * width));
      const box = { left: 62, right: width - 14, top: 26, bottom: height - 50 };
      const x = scale(...view.ends[0], box.left, box.right),
        y = scale(...view.ends[1], box.bottom, box.top);
      put(svg, { viewBox: `0 0 ${width} ${height}`, height, "aria-label": view.title });
      say(title, view.title);
      const [a, b] = view.guide;
      const guide = shape("path", { d: line([x(a[0]), x(b[0])], [y(a[1]), y(b[1])]), class: "dp-guide" });
      back.replaceChildren(axes(box, x, y, view.names, ticks(...view.ends[1], 6)), guide);
      px = pixels(view.xs, x);
      py = pixels(view.ys, y);
      const marks = ["", ""];
      px.forEach((u, k) => {
        const v = py[k];
        if (!Number.isFinite(u + v)) return;
        // A dot is a line without a length; a checking row is a cross.
        if (!view.kinds?.[k]) marks[0] += `M${u.toFixed(1)} ${v.toFixed(1)}h0`;
        else marks[1] += `M${(u - 3).toFixed(1)} ${(v - 3).toFixed(1)}l6 6m0 -6l-6 6`;
      });
      dots.forEach((path, n) =>
        put(path, { d: marks[n], class: `dp-points ${KINDS[n]}${px.length > 600 ? " dp-many" : ""}` }),
      );
      order = [...px.keys()].filter((k) => Number.isFinite(px[k] + py[k])).sort((i, j) => px[i] - px[j]);
      put(ring, { x: box.left, y: box.top, width: box.right - box.left, height: box.bottom - box.top });
      show(before === null ? -1 : view.rows.indexOf(before));
    },
  };
}

const cell = (tag, text, attributes = {}) => element(tag, attributes, text);

/** R², which is not 1 where there is any error. */
const share = (r2) => (r2 < 1 && r2 > 0.99995 ? "> 0.9999" : said(r2));

/** The errors of every output, each in its unit. */
function figuresTable(figures) {
  const split = figures.some(({ kind }) => kind),
    skipped = figures.some(({ without }) => without);
  const heads = ["output", ...(split ? ["rows"] : []), "number", "RMSE", "mean |error|", "largest |error|", "R²"];
  if (skipped) heads.push("no prediction");
  const body = figures.map((row) =>
    element(
      "tr",
      {},
      cell("th", row.output, { scope: "row" }),
      ...(split ? [cell("td", row.kind)] : []),
      cell("td", String(row.rows)),
      ...["rmse", "mae", "max"].map((name) => cell("td", row[name] === undefined ? "–" : quantity(row[name], row))),
      cell("td", row.r2 === undefined ? "–" : row.r2 === null ? "– (constant)" : share(row.r2)),
      ...(skipped ? [cell("td", String(row.without))] : []),
    ),
  );
  return element(
    "table",
    { class: "dp-table" },
    element("thead", {}, element("tr", {}, ...heads.map((text) => cell("th", text, { scope: "col" })))),
    element("tbody", {}, ...body),
  );
}

/** The worst rows; `look`, where there is one, leads to the viewer. */
function worstTable(pictures, look) {
  const { output, inputs, worst, kinds } = pictures,
    split = kinds.length > 1;
  const heads = [
    "line",
    ...(split ? ["rows"] : []),
    ...inputs.map(labelled),
    ...["measured", "predicted", "residual"].map((name) => labelled({ name, unit: output.unit })),
  ];
  const body = worst.map((row) => {
    const title = look ? `look at line ${row.line} in the viewer` : null;
    const first = look
      ? element("button", { class: "dp-look", title, "aria-label": title }, String(row.line))
      : String(row.line);
    return element(
      "tr",
      { onclick: look ? () => look(row.row) : null, class: look ? "dp-leads" : "" },
      element("th", { scope: "row" }, first),
      ...(split ? [cell("td", row.kind)] : []),
      ...[...row.x, row.measured, row.predicted, row.residual].map((v) => cell("td", said(v))),
    );
  });
  return element(
    "table",
    { class: "dp-table dp-worst" },
    element("thead", {}, element("tr", {}, ...heads.map((text) => cell("th", text, { scope: "col" })))),
    element("tbody", {}, ...body),
  );
}

/**
 * All pictures of rows: {node, draw(view)}. hands: {look(row), output(number)}; view: {pictures, points, residual, terms
 * (the inputs with their terms, or null), along (the name of what residuals are drawn over at last), outputs ([number,
 * name] of those with measured values), looks (whether a row leads to the viewer), width}.
 */
export function dataPictures(hands) {
  const notes = element("div"),
    key = element("div", { class: "pn-keys" }),
    figures = element("div", { class: "dp-scroll" }),
    cover = element("div", { class: "dp-grid" }),
    worst = element("div", { class: "dp-scroll" });
  const output = choices("Output", [], "", (value) => hands.output(Number(value))),
    outputField = element("label", {}, element("span", {}, "Output"), output);
  let over = 0, // the input that residuals are drawn over
    view = null;
  const input = choices("Residual over", [], "", (value) => {
    over = Number(value);
    draw(view);
  });
  const look = (row) => view.looks && hands.look(row);
  const parity = cloud(look),
    residuals = cloud(look),
    course = cloud(look);
  const hint = element("p", { class: "pn-note" }, "A click on a point, or Enter, looks at its row in the viewer.");
  put(parity.node.querySelector("svg"), { "data-glance": "" });
  const points = element(
    "div",
    {},
    element("div", { class: "pn-row" }, outputField, element("label", {}, element("span", {}, "Residual over"), input)),
    hint,
    element("div", { class: "dp-grid" }, parity.node, residuals.node, course.node),
  );
  const section = (title, ...content) => element("section", { class: "dp-part" }, element("h3", {}, title), ...content);
  const errors = section("Errors", figures),
    clouds = section("Predicted and measured", key, points),
    rows = section("The ten worst rows", worst),
    spread = section("Where the rows lie", cover);
  const node = element("div", { class: "dp-pictures" }, notes, errors, clouds, rows, spread);

  function drawPoints({ pictures, points: p, residual, along, width }) {
    const { inputs, output: of } = pictures,
      unit = (name) => labelled({ name, unit: of.unit });
    const predicted = residual.map((r, k) => (r === null ? null : p.measured[k] - r));
    over = Math.min(over, inputs.length - 1);
    offer(
      input,
      inputs.map(({ name }, i) => [i, name]),
      over,
    );
    const about = (k) =>
      `line ${p.line[k]}${p.checking?.[k] ? ", checking" : ""}: measured ${quantity(p.measured[k], of)}, predicted ${quantity(predicted[k], of)}, residual ${quantity(residual[k], of)}`;
    const common = { kinds: p.checking, about, rows: p.row, width };
    const both = around(p.measured, ...around(predicted));
    parity.draw({
      ...common,
      title: `${of.name}: predicted over measured`,
      names: [unit(`measured ${of.name}`), unit(`predicted ${of.name}`)],
      xs: p.measured,
      ys: predicted,
      ends: [both, both],
      guide: [
        [both[0], both[0]],
        [both[1], both[1]],
      ],
    });
    const tall = around(residual, 0);
    const levels = (ends) => [
      [ends[0], 0],
      [ends[1], 0],
    ];
    const name = unit("measured − predicted");
    for (const [picture, title, xs, axis] of [
      [residuals, inputs[over].name, p.x[over], labelled(inputs[over])],
      [course, along.name, p.along, labelled(along)],
    ]) {
      const ends = around(xs);
      picture.draw({
        ...common,
        title: `Residual over ${title}`,
        names: [axis, name],
        xs,
        ys: residual,
        ends: [ends, tall],
        guide: levels(ends),
      });
    }
  }

  function draw(next) {
    view = next;
    const { pictures, terms, outputs } = view;
    node.hidden = !pictures;
    if (!pictures) return;
    notes.replaceChildren(...pictures.words.map((text) => element("p", { class: "pn-note" }, text)));
    const known = pictures.histograms.flatMap((h) => (terms ?? []).filter((v) => v.name === h.name).map((v) => [v, h]));
    spread.hidden = known.length === 0;
    // As the style sheet's columns: each of its width.
    const half = node.clientWidth >= 736 ? (node.clientWidth - 26) / 2 : node.clientWidth,
      width = Math.max(240, half);
    cover.replaceChildren(...known.map(([variable, h]) => coverage(variable, h, width)));
    const measured =
      pictures.output !== null && view.points !== null && view.residual?.length === view.points.row.length;
    for (const part of [errors, clouds, rows]) part.hidden = !measured;
    const sample = (n, text) =>
      element(
        "span",
        {},
        shape(
          "svg",
          { width: 14, height: 14, "aria-hidden": "true" },
          shape("path", { d: n ? "M4 4l6 6m0 -6l-6 6" : "M7 7h0", class: `dp-points ${KINDS[n]}` }),
        ),
        text,
      );
    key.hidden = pictures.kinds.length < 2;
    key.replaceChildren(...pictures.kinds.map((text, n) => sample(n, text)));
    if (!measured) return;
    figures.replaceChildren(figuresTable(pictures.figures));
    outputField.hidden = outputs.length < 2;
    hint.hidden = !view.looks;
    offer(output, outputs, pictures.output.number);
    drawPoints({ ...view, width });
    const focused = [...worst.querySelectorAll("button")].indexOf(document.activeElement);
    worst.replaceChildren(worstTable(pictures, view.looks ? hands.look : null));
    if (focused >= 0) worst.querySelectorAll("button")[focused]?.focus();
    for (const box of [figures, worst]) {
      // What scrolls must be reached by keys.
      const scrolls = box.scrollWidth > box.clientWidth;
      put(box, { tabindex: scrolls ? 0 : null, role: scrolls ? "group" : null });
      put(box, { "aria-label": scrolls ? (box === worst ? "The ten worst rows" : "Errors") : null });
    }
  }
  return { node, draw };
}
