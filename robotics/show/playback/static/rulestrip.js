// Which rule ruled when: a line for each rule, shaded over time by its share in the answer, and a cursor at the time that
// one looks at. A line's number and words lead to the rule; what they are was found in Python.

const AXIS = 5; // times below the strip, at most about
const APART = 45; // px between two of them

function made(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}

/** A rule's sentence with what it does before why, for a line that is cut. */
function inShort(text) {
  const found = /^if (.*) then (.*)$/.exec(text);
  return found ? `${found[2]} ← ${found[1]}` : text;
}

/** The place of a time among spans that begin at `edges`, the last of which ends them. */
function spanAt(edges, time) {
  let low = 0,
    high = edges.length - 2;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (edges[middle] <= time + 1e-6) low = middle;
    else high = middle - 1;
  }
  return low;
}

function times(from, to, most) {
  const rough = (to - from) / most,
    power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((m) => m >= rough * 0.999);
  const found = [];
  for (let n = Math.ceil(from / step); n * step <= to + 1e-9; n++) found.push(Number((n * step).toFixed(6)));
  return found;
}

/**
 * The strip, hidden until it is given something.
 *   seek(time)  a hand chose a time [s]
 *   open(rule)  a hand chose a rule, by its number from 1; null: rules lead nowhere
 * update({ edges, rows: [{ rule, text, shares }] }) draws it, shares in [0, 1] or null; at(time) moves its cursor.
 */
export function ruleStrip({ seek, open }) {
  const grid = made("div", { class: "rs-grid" }),
    cursor = made("div", { class: "rs-cursor", "aria-hidden": "true" }),
    axis = made("div", { class: "rs-axis", "aria-hidden": "true" }),
    told = made("p", { class: "rs-told" });
  const head = made("p", { class: "rs-head" }, "Which rule ruled when: the darker, the larger its share in the answer");
  const node = made("section", { class: "rs-strip", "aria-label": "Which rule ruled when" }, head, grid, told);
  node.hidden = true;
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  let data = null,
    lines = [],
    now = 0;

  const within = (time) => Math.min(data.edges.at(-1), Math.max(data.edges[0], time));
  const timeAt = (event) => {
    const { left, width } = lines[0].canvas.getBoundingClientRect();
    return within(data.edges[0] + ((data.edges.at(-1) - data.edges[0]) * (event.clientX - left)) / width);
  };
  const share = (row) => row.shares[spanAt(data.edges, now)];
  const percent = (value) => (value === null ? "–" : `${Math.round(100 * value)} %`);

  function paint() {
    const ink = getComputedStyle(node).getPropertyValue("--ff-c0").trim();
    for (const { canvas, row } of lines) {
      const pen = canvas.getContext("2d");
      pen.clearRect(0, 0, canvas.width, 1);
      pen.fillStyle = ink;
      row.shares.forEach((value, k) => {
        pen.globalAlpha = value ?? 0;
        if (value) pen.fillRect(k, 0, 1, 1);
      });
    }
  }

  function lineOf(row) {
    const canvas = made("canvas", { class: "rs-shares", width: row.shares.length, height: 1, "aria-hidden": "true" }),
      value = made("span", { class: "rs-now" });
    const words = `${row.rule}: ${row.text}`,
      does = `${row.rule}: ${inShort(row.text)}`,
      name = open === null ? made("span", {}, does) : made("button", { type: "button", "aria-label": words }, does);
    name.className = "rs-name";
    name.title = words;
    if (open !== null) name.addEventListener("click", () => open(row.rule));
    return { row, canvas, value, name };
  }

  function update(given) {
    data = given;
    node.hidden = !given?.rows.length;
    if (node.hidden) return;
    lines = given.rows.map(lineOf);
    const [from, to] = [given.edges[0], given.edges.at(-1)];
    const unit = made("span", { class: "rs-unit" }, "time [s]");
    const plot = made("div", {
      class: "rs-plot",
      role: "slider",
      tabindex: "0",
      "aria-label": "Time, over the rules' shares",
      "aria-valuemin": from,
      "aria-valuemax": to,
    });
    plot.append(...lines.map(({ canvas }) => canvas), cursor);
    plot.addEventListener("pointerdown", (event) => {
      plot.setPointerCapture(event.pointerId);
      seek(timeAt(event));
    });
    plot.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) seek(timeAt(event));
      say(event);
    });
    plot.addEventListener("pointerleave", () => say(null));
    plot.addEventListener("keydown", (event) => {
      const by = ((to - from) / 200) * (event.shiftKey ? 10 : 1);
      const goal = { ArrowLeft: now - by, ArrowRight: now + by, Home: from, End: to }[event.key];
      if (goal === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      seek(within(goal));
    });
    grid.style.setProperty("--rs-rows", lines.length);
    grid.replaceChildren(
      made("div", { class: "rs-names" }, ...lines.map(({ name }) => name), unit),
      made("div", { class: "rs-middle" }, plot, axis),
      made("div", { class: "rs-values" }, ...lines.map(({ value }) => value)),
    );
    const most = Math.max(2, Math.min(AXIS, Math.floor(plot.clientWidth / APART)));
    axis.replaceChildren(
      ...times(from, to, most).map((time) => {
        const tick = made("span", {}, String(time).replace("-", "−"));
        tick.style.left = `${(100 * (time - from)) / (to - from)}%`;
        return tick;
      }),
    );
    paint();
    at(now);
  }

  /** What stands under the pointer: rule, time and share. */
  function say(event) {
    const over =
      event === null ? -1 : lines.findIndex(({ canvas }) => canvas.getBoundingClientRect().bottom > event.clientY);
    if (over < 0) {
      told.textContent = "";
      return;
    }
    const time = timeAt(event),
      value = data.rows[over].shares[spanAt(data.edges, time)];
    told.textContent = `${time.toFixed(1)} s: ${percent(value)} of the answer by rule ${data.rows[over].rule}: ${data.rows[over].text}`;
  }

  function at(time) {
    now = time;
    if (node.hidden) return;
    const [from, to] = [data.edges[0], data.edges.at(-1)];
    cursor.style.left = `${(100 * (within(time) - from)) / (to - from)}%`;
    let best = null;
    for (const { row, value, name } of lines) {
      const mine = share(row),
        text = percent(mine);
      if (value.textContent !== text) value.textContent = text;
      name.classList.toggle("rs-rules", mine >= 0.005);
      if (best === null || (mine ?? -1) > (share(best) ?? -1)) best = row;
    }
    const plot = cursor.parentNode;
    plot.setAttribute("aria-valuenow", time);
    plot.setAttribute("aria-valuetext", `${time.toFixed(1)} s: rule ${best.rule} with ${percent(share(best))}`);
  }

  dark.addEventListener("change", paint);
  const scheme = new MutationObserver(paint); // as in player.js
  scheme.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
  const end = () => {
    dark.removeEventListener("change", paint);
    scheme.disconnect();
  };
  return { node, update, at, end };
}
