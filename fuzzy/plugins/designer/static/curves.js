// The membership functions of an input: curves with their names on them, handles to drag, and the current point.
import {
  axes,
  clamp,
  color,
  cut,
  element,
  labelled,
  line,
  put,
  quantity,
  rounded,
  rowsOf,
  scale,
  shape,
  widthOf,
} from "./chart.js";
import { drag, gesture, pressing, stepped } from "./dragging.js";
import { strip } from "./histogram.js";
import { degree, handles, lowerDegree, places, shifted } from "./membership.js";

const ROW = 19; // px, a line of labels
const STRIP = 44; // px, a histogram of measured rows

/**
 * The chart of an input. hands: {select(term), move(term, parameters, gesture, pressed), release(), point(value,
 * pressed), releasePoint()}. Returns {node, draw(view)}, view: {functions, variable, histogram (or null),
 * compared, selected, point, width}.
 */
export function membershipChart(hands) {
  const svg = shape("svg", { class: "fd-chart", role: "group" });
  const layers = Object.fromEntries(
    ["back", "rows", "old", "curves", "names", "now", "handles"].map((name) => [
      name,
      shape("g", { class: `fd-${name}` }),
    ]),
  );
  svg.append(...Object.values(layers));
  const key = pressing();
  let view = null,
    drawnFor = "",
    frame = "", // what its axes
    names = "", // and its names were drawn for
    box,
    x,
    y,
    specs = [];
  const grips = [];

  const inUniverse = (value) => rounded(value, view.variable.low, view.variable.high);
  const pixel = (event) => event.clientX - svg.getBoundingClientRect().left;
  const chosen = () => view.variable.terms.find((term) => term.name === view.selected);
  const span = () => view.variable.high - view.variable.low;
  const tidy = (parameters, before) =>
    parameters.map((p, i) => (p === before[i] || Math.abs(p) === Infinity ? before[i] : fine(p, before[i])));
  // Places are rounded to what a hand can mean; slopes and steepness have no unit of x and keep three digits.
  const fine = (value) =>
    Math.abs(value) < 20 * span() ? inUniverse(value) || Number(value.toPrecision(3)) : Number(value.toPrecision(3));

  function moved(spec, term, to) {
    const parameters = spec.move(clamp(inUniverse(to), ...spec.range), span() / 1000);
    const out = tidy(parameters, term.parameters);
    // Rounding may not cross a neighbour, nor pass the last digit of one that is not round itself.
    return out.map((p, i) => (i === spec.index && !spec.name.match(/width|slope|steep/) ? clamp(p, ...spec.range) : p));
  }

  // A handle: dragged, or moved by the arrow keys; with Alt the whole curve moves.
  function grip(i) {
    const node = shape(
      "g",
      { class: "fd-grip", role: "slider", tabindex: 0 },
      shape("circle", { r: 17, class: "fd-reach" }),
      shape("path", { class: "fd-dot" }),
    );
    let held = null;
    drag(node, {
      start(event) {
        const term = chosen(),
          spec = specs[i],
          outside = spec.x < view.variable.low || spec.x > view.variable.high;
        held = { term, spec, name: gesture(), off: outside ? 0 : pixel(event) - x(spec.x) };
        node.focus();
      },
      move(event) {
        // A hand beyond the plot takes the vertex to its edge; number fields and keys reach farther.
        const { low, high } = view.variable,
          to = clamp(x.value(pixel(event) - held.off), Math.min(low, held.spec.x), Math.max(high, held.spec.x));
        hands.move(held.term.name, moved(held.spec, held.term, to), held.name, true);
      },
      end(_, cancelled) {
        if (cancelled) hands.move(held.term.name, held.term.parameters, held.name, true);
        hands.release();
      },
    });
    node.addEventListener("keydown", (event) => {
      const term = chosen(),
        spec = specs[i],
        { low, high } = view.variable;
      const to = stepped(event, spec.x, low, high);
      if (to === null) return;
      const parameters = event.altKey ? wholly(term, to - spec.x) : moved(spec, term, to);
      hands.move(term.name, parameters, key(event), false);
    });
    return node;
  }

  const wholly = (term, by) => tidy(shifted(view.functions[term.type], term.parameters, by), term.parameters);

  // Anywhere on a curve or its name: choose it, and move it as a whole.
  let whole = null;
  drag(svg, {
    start(event) {
      const name = event.target.closest("[data-term]")?.dataset.term;
      if (name === undefined) return false;
      hands.select(name);
      whole = {
        term: view.variable.terms.find((term) => term.name === name),
        at: pixel(event),
        name: gesture(),
        far: false,
      };
    },
    move(event) {
      const by = pixel(event) - whole.at;
      whole.far ||= Math.abs(by) > 3; // a click is no move
      if (whole.far)
        hands.move(
          whole.term.name,
          wholly(whole.term, inUniverse((by / (box.right - box.left)) * span())),
          whole.name,
          true,
        );
    },
    end(_, cancelled) {
      if (cancelled && whole.far) hands.move(whole.term.name, whole.term.parameters, whole.name, true);
      hands.release();
    },
  });

  const marker = shape("g", { class: "fd-point", role: "slider", tabindex: 0 });
  const marks = {
    line: shape("line"),
    reach: shape("rect", { class: "fd-reach" }),
    head: shape("path"),
    dots: shape("g"),
  };
  marker.append(marks.reach, marks.line, marks.head);
  layers.now.append(marker, marks.dots);
  let grabbed = 0;
  drag(marker, {
    start(event) {
      grabbed = pixel(event) - x(clamp(view.point, view.variable.low, view.variable.high));
      marker.focus();
    },
    move(event) {
      hands.point(clamp(inUniverse(x.value(pixel(event) - grabbed)), view.variable.low, view.variable.high), true);
    },
    end() {
      hands.releasePoint();
    },
  });
  marker.addEventListener("keydown", (event) => {
    const { low, high } = view.variable,
      to = stepped(event, view.point, low, high);
    if (to !== null) hands.point(clamp(inUniverse(to), low, high), false);
  });

  function curve(term, extra) {
    const { low, high } = view.variable,
      xs = places(term.parameters, low, high);
    const ys = xs.map((value) => degree(term.type, value, term.parameters));
    return { xs, ys, path: line(xs.map(x), ys.map(y)), ...extra };
  }

  function draw(next) {
    view = next;
    // Python's answer to a drag is what stands here.
    const key = JSON.stringify({ ...view, functions: null });
    if (key === drawnFor) return;
    drawnFor = key;
    const { variable, width, selected } = view,
      narrow = width < 560,
      { low, high } = variable;
    box = { left: 44, right: width - 14, top: 0, bottom: 0 };
    x = scale(low, high, box.left, box.right);
    y = scale(0, 1, 1, 0);
    const drawn = variable.terms.map((term, i) => curve(term, { term, color: color(i), bold: term.name === selected }));
    const labels = drawn.map(({ term, xs, ys, bold }) => {
      const top = Math.max(...ys),
        first = ys.indexOf(top),
        last = ys.lastIndexOf(top);
      const text = cut(term.name, 150, 13, 600);
      // A function that has no formula here has no curve; its name stands in the middle.
      const middle = x(((xs[first] ?? low) + (xs[last] ?? high)) / 2);
      return { text, x: middle, top, width: widthOf(text, 13, bold ? 600 : 500) };
    });
    const rows = rowsOf(labels, box.left, box.right, 12),
      count = Math.max(1, ...rows.map(({ row }) => row + 1));
    box.top = 26 + count * ROW;
    box.bottom = box.top + (narrow ? 170 : width > 1000 ? 290 : 230);
    y = scale(0, 1, box.bottom, box.top);
    const foot = box.bottom + 50,
      height = view.histogram ? foot + STRIP + 12 : foot;
    put(svg, {
      width,
      height,
      viewBox: `0 0 ${width} ${height}`,
      "aria-label": `Membership functions of ${variable.name}`,
    });
    // Texts are slow to lay out: those that a drag leaves as they are stay.
    const framed = JSON.stringify([box, low, high, labelled(variable)]);
    if (framed !== frame) {
      frame = framed;
      layers.back.replaceChildren(
        axes(box, x, y, [labelled(variable), null], [0, 0.5, 1]),
        shape("text", { x: 8, y: 14, class: "fd-name", "aria-hidden": "true" }, "degree"),
      );
    }
    const namedFor = JSON.stringify([framed, labels, rows, selected, variable.terms.map(({ name }) => name)]),
      renamed = namedFor !== names;
    names = namedFor;
    const below = { left: box.left, right: box.right, top: foot + 4, bottom: foot + 4 + STRIP };
    layers.rows.replaceChildren(view.histogram ? strip(view.histogram, x, below) : "");
    const before = view.compared?.terms ?? [];
    layers.old.replaceChildren(...before.map((term) => shape("path", { d: curve(term).path, class: "fd-compared" })));
    layers.curves.replaceChildren();
    if (renamed) layers.names.replaceChildren();
    const lastly = [...drawn.keys()].sort((a, b) => Number(drawn[a].bold) - Number(drawn[b].bold));
    for (const i of lastly) {
      const each = drawn[i],
        { term, bold } = each,
        path = line(each.xs.map(x), each.ys.map(y));
      // Of a type-2 term the footprint of uncertainty, down to its lower function.
      const foot = term.lower && each.xs.map(lowerDegree(term, view.functions[term.type], low, high)),
        below = foot && line(each.xs.map(x), foot.map(y));
      if (path && (bold || below))
        layers.curves.append(
          shape("path", {
            d: below
              ? path + line([...each.xs].reverse().map(x), [...foot].reverse().map(y)).replace("M", "L") + "Z"
              : `${path}L${box.right} ${box.bottom}L${box.left} ${box.bottom}Z`,
            style: `fill: ${each.color}`,
            class: bold ? "fd-under" : "fd-under fd-faint",
            "data-footprint": below ? term.name : null,
          }),
        );
      if (below) layers.curves.append(shape("path", { d: below, style: `stroke: ${each.color}`, class: "fd-lower" }));
      layers.curves.append(
        shape("path", {
          d: path,
          style: `stroke: ${each.color}`,
          class: bold ? "fd-curve fd-bold" : "fd-curve",
          "data-curve": term.name,
        }),
      );
      layers.curves.append(
        shape("path", { d: path, class: "fd-hit", "data-term": term.name }, shape("title", {}, term.name)),
      );
      if (!renamed) continue;
      const at = rows[i],
        base = box.top - 14 - at.row * ROW,
        half = labels[i].width / 2,
        peak = labels[i].x;
      // A name that stands higher is led to its peak, behind the names below it.
      if (at.row && Number.isFinite(labels[i].top))
        layers.names.prepend(
          shape("path", {
            class: "fd-leader",
            d: line([clamp(peak, at.x - half, at.x + half), peak, peak], [base + 4, box.top - 8, y(labels[i].top)]),
            style: `stroke: ${each.color}`,
          }),
        );
      layers.names.append(
        shape(
          "g",
          { "data-term": term.name, class: bold ? "fd-label fd-bold" : "fd-label" },
          shape("rect", { x: at.x - half - 6, y: base - 15, width: 2 * half + 12, height: ROW, class: "fd-reach" }),
          shape("text", { x: at.x, y: base, "text-anchor": "middle" }, labels[i].text),
          shape("line", {
            x1: at.x - half,
            x2: at.x + half,
            y1: base + 4,
            y2: base + 4,
            style: `stroke: ${each.color}`,
          }),
        ),
      );
    }
    drawPoint();
    drawGrips();
  }

  function drawPoint() {
    const { low, high, name, terms } = view.variable,
      at = clamp(view.point, low, high),
      px = x(at);
    put(marks.line, { x1: px, x2: px, y1: box.top - 8, y2: box.bottom });
    put(marks.reach, { x: px - 9, y: box.top - 10, width: 18, height: box.bottom - box.top + 22 });
    put(marks.head, { d: `M${px - 6} ${box.bottom + 10}h12L${px} ${box.bottom}z` });
    put(marker, {
      "aria-label": `current ${name}`,
      "aria-valuemin": low,
      "aria-valuemax": high,
      "aria-valuenow": at,
      "aria-valuetext": quantity(view.point, view.variable),
    });
    const dot = (term, i) =>
      shape("circle", {
        cx: px,
        cy: y(degree(term.type, view.point, term.parameters)),
        r: 3.5,
        style: `fill: ${color(i)}`,
      });
    const drawn = (term) => !Number.isNaN(degree(term.type, view.point, term.parameters));
    marks.dots.replaceChildren(...terms.map((term, i) => (drawn(term) ? dot(term, i) : "")));
  }

  function drawGrips() {
    const term = chosen(),
      { low, high } = view.variable;
    specs = term ? handles(term.type, view.functions[term.type], term.parameters) : [];
    while (grips.length < specs.length) {
      grips.push(grip(grips.length));
      layers.handles.append(grips.at(-1));
    }
    for (const extra of grips.splice(specs.length)) extra.remove();
    specs.forEach((spec, i) => {
      const side = spec.x < low ? -1 : spec.x > high ? 1 : 0,
        px = x(clamp(spec.x, low, high)),
        py = y(spec.y);
      // A vertex outside the universe waits at the edge, as an arrow that points to where it is.
      const form = side
        ? `M${-side * 6} -7L${side * 7} 0L${-side * 6} 7z`
        : "M-6.5 0a6.5 6.5 0 1 0 13 0a6.5 6.5 0 1 0 -13 0z";
      const [from, to] = [Math.max(spec.range[0], low), Math.min(spec.range[1], high)];
      put(grips[i], {
        transform: `translate(${px} ${py})`,
        style: `--grip: ${color(view.variable.terms.indexOf(term))}`,
        "aria-label": `${term.name}: ${spec.name}`,
        "aria-valuenow": spec.x,
        "aria-valuemin": Math.min(from, spec.x),
        "aria-valuemax": Math.max(to, spec.x),
        "aria-valuetext": quantity(term.parameters[spec.index], spec.name.match(/slope|steep/) ? {} : view.variable),
        "data-handle": spec.name,
      });
      put(grips[i].lastChild, { d: form });
    });
  }

  return { node: element("div", { class: "fd-plot" }, svg), draw };
}
