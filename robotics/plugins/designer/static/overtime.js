// A picture over the time of a run: curves of several runs, and a dot on each at the time that one looks at.
import {
  axes,
  line,
  numbersOf,
  put,
  refill,
  scale,
  shape,
  ticks,
} from "../../../../fuzzy/plugins/designer/static/chart.js";

const known = (value) => (value === null ? NaN : value);

/**
 * Draw curves over time into an svg; returns { at(time) } which moves the dots.
 *   title       of the vertical axis, with its unit
 *   duration    [s]
 *   size        { width, height }
 *   curves      [{ kind, run, time, values }], the last on top; `kind` is a class, values are numbers or null
 *   least       what the vertical axis spans at least, [low, high]
 *   under       a function of (x, y), what lies below the curves
 */
export function overTime(svg, { title, duration, size, curves, least, under = () => "", bounds = [] }) {
  const box = { left: 58, right: size.width - 10, top: 26, bottom: size.height - 44 };
  const values = [...curves.flatMap((each) => each.values), ...bounds].filter(Number.isFinite);
  let low = Math.min(least[0], ...values),
    high = Math.max(least[1], ...values);
  const margin = 0.06 * (high - low);
  [low, high] = [low - margin, high + margin];
  const x = scale(0, duration, box.left, box.right),
    y = scale(low, high, box.bottom, box.top);
  const drawn = shape("g", {}, shape("line", { x1: box.left, x2: box.right, y1: y(0), y2: y(0), class: "tr-zero" }));
  drawn.append(under(x, y));
  for (const { kind, run, time, values: each } of curves) {
    const d = line(
      time.map(x),
      each.map((value) => y(known(value))),
    );
    drawn.append(shape("path", { d, class: kind, ...(run ? { "data-run": run } : {}) }));
  }
  put(svg, { viewBox: `0 0 ${size.width} ${size.height}`, height: size.height });
  numbersOf.set(
    svg,
    curves.flatMap(({ run, kind, time, values: each }) => [
      ["time [s]", ...time],
      [`${title}, ${run ?? kind.replace(/^tr-/, "")}`, ...each],
    ]),
  );
  refill(
    svg,
    axes(box, x, y, ["time [s]", title], ticks(low, high, 5)),
    drawn,
    shape("line", { class: "tr-cursor", y1: box.top, y2: box.bottom }),
    shape("g", {}),
  );
  const [, , cursor, dots] = svg.children;

  function at(time) {
    put(cursor, { x1: x(time), x2: x(time) });
    dots.replaceChildren(
      ...curves
        .filter(({ run }) => run)
        .flatMap(({ kind, time: times, values: each }) => {
          const k = Math.min(times.length - 1, Math.round((time / duration) * (times.length - 1)));
          return Number.isFinite(known(each[k]))
            ? [shape("circle", { cx: x(times[k]), cy: y(each[k]), r: 4, class: kind })]
            : [];
        }),
    );
  }
  /** The time at a place on the screen. */
  const timeAt = (clientX) => {
    const { left, width } = svg.getBoundingClientRect();
    const share = (((clientX - left) / width) * size.width - box.left) / (box.right - box.left);
    return duration * Math.min(1, Math.max(0, share));
  };
  return { at, timeAt, y };
}

/** Let a hand drag time over a picture that `picture()` returns; `seek(time, settled)`: `settled` once it was a click. */
export function draggedTime(svg, picture, seek) {
  let from = null;
  svg.classList.add("tr-dragged");
  svg.addEventListener("pointerdown", (event) => {
    if (picture() === null || event.button !== 0) return;
    svg.setPointerCapture(event.pointerId);
    from = [event.clientX, event.clientY];
    seek(picture().timeAt(event.clientX, event.clientY), false);
  });
  svg.addEventListener("pointermove", (event) => {
    if (from !== null && event.buttons & 1) seek(picture().timeAt(event.clientX, event.clientY), false);
  });
  svg.addEventListener("pointerup", (event) => {
    const still = from !== null && Math.hypot(event.clientX - from[0], event.clientY - from[1]) < 4;
    from = null;
    if (still) seek(picture().timeAt(event.clientX, event.clientY), true);
  });
  svg.addEventListener("pointercancel", () => (from = null));
}
