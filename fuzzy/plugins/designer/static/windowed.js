// Of a long list only the rows in view are drawn, and some around them; empty elements keep the room of the others.
import { element, put } from "./chart.js";
import { framed } from "./dragging.js";

const ALL = 80; // rows up to which every one is drawn
const BEYOND = 240; // px above and below the window in which rows are drawn
const GUESS = 40; // px, a row's height before any has been measured
const BUDGET = 10; // ms in which rows are made for a frame; others follow in the next ones, so that the page answers
const AT_ONCE = 4; // rows for a frame at most: laying one out takes longer than making it
const SPARE = 60; // rows out of view that are kept to be used again

/**
 * The rows of `list`, an element. make() gives a row {node, take(id), show()}, which is used for one id after another;
 * show() is called when it is drawn, and for every drawn row when the ids are given anew. A row with the focus or with
 * a refused field is kept wherever it stands. `frame` is the element in which the list may scroll.
 */
export function windowed(list, make, frame) {
  const rows = new Map(),
    heights = new Map(),
    spare = [],
    gaps = [];
  let ids = [],
    places = new Map(),
    drawn = "", // the places that have a row
    sought = null;

  const guess = () => {
    let sum = 0;
    for (const height of heights.values()) sum += height;
    return heights.size ? sum / heights.size : GUESS;
  };
  const pinned = () => {
    const out = [sought].filter((id) => places.has(id));
    for (const [id, { node }] of rows)
      if (places.has(id) && (node.contains(document.activeElement) || node.querySelector("input[aria-invalid]")))
        out.push(id);
    return out;
  };

  // What is seen of the frame: its upper and lower end in the window
  function seen() {
    const { top, bottom } = frame.getBoundingClientRect();
    return [Math.max(0, top), Math.min(innerHeight, bottom)];
  }
  function inView() {
    if (ids.length <= ALL) return [0, ids.length];
    const each = guess(),
      [high, low] = seen();
    let from = 0,
      y = list.getBoundingClientRect().top;
    const height = (i) => heights.get(ids[i]) ?? each;
    while (from < ids.length && y + height(from) < high - BEYOND) y += height(from++);
    let to = from;
    while (to < ids.length && y < low + BEYOND) y += height(to++);
    return [Math.min(from, ids.length - 1), to];
  }

  // The rows that are wanted and not there, as far as there is time; those in the window come before those around it.
  function fill(wanted) {
    const missing = [...wanted].filter((i) => !rows.has(ids[i]));
    if (!missing.length) return;
    const each = guess(),
      top = list.getBoundingClientRect().top,
      [first, last] = seen().map((end) => (end - top) / each);
    const away = (i) => (ids[i] === sought ? -1 : Math.max(0, first - i, i - last));
    missing.sort((a, b) => away(a) - away(b) || a - b);
    const end = performance.now() + BUDGET;
    let made = 0;
    for (const i of missing) {
      if (away(i) >= 0 && ids.length > AT_ONCE && (made >= AT_ONCE || performance.now() > end)) {
        wanted.delete(i);
        continue;
      }
      const row = spare.pop() ?? make();
      row.take(ids[i]);
      rows.set(ids[i], row);
      row.show();
      made++;
    }
    if (missing.some((i) => !wanted.has(i))) scrolled();
  }

  function draw(afresh) {
    const [from, to] = inView(),
      wanted = new Set(pinned().map((id) => places.get(id)));
    for (let i = from; i < to; i++) wanted.add(i);
    for (const [id, row] of rows)
      if (!wanted.has(places.get(id))) {
        row.node.remove();
        rows.delete(id);
        if (spare.length < SPARE) spare.push(row);
      }
    if (afresh) for (const row of rows.values()) row.show();
    fill(wanted);
    const order = [...wanted].sort((a, b) => a - b),
      key = order.join();
    if (!afresh && key === drawn) return;
    drawn = key;
    const each = guess();
    // Without the gaps the rows stand in their order, so that none with the focus is moved.
    for (const node of gaps) node.remove();
    let at = list.firstChild,
      next = 0,
      used = 0;
    const place = (node) => {
      if (node === at) at = at.nextSibling;
      else list.insertBefore(node, at);
    };
    const gap = (end) => {
      if (next >= end) return;
      let room = 0;
      for (let i = next; i < end; i++) room += heights.get(ids[i]) ?? each;
      gaps[used] ??= element("div", { "aria-hidden": "true", role: "presentation", class: "fd-gap-of-rows" });
      put(gaps[used], { style: `height: ${room}px` });
      place(gaps[used++]);
    };
    for (const i of order) {
      gap(i);
      place(rows.get(ids[i]).node);
      next = i + 1;
    }
    gap(ids.length);
    for (const extra of gaps.splice(used)) extra.remove();
    if (ids.length <= ALL && order.length === ids.length) return;
    for (const i of order) {
      const height = rows.get(ids[i]).node.getBoundingClientRect().height;
      if (height > 0) heights.set(ids[i], height);
    }
  }

  const scrolled = framed(() => draw(false));
  const moved = () => scrolled();
  let width = -1; // only another width, or being shown, is news: the height is our own doing
  const observer = new ResizeObserver(() => {
    if (list.clientWidth === width) return;
    width = list.clientWidth;
    drawn = ""; // other heights
    moved();
  });
  observer.observe(list);
  document.addEventListener("scroll", moved, { capture: true, passive: true });
  addEventListener("resize", moved);

  return {
    /** The rows' ids in their order; what is drawn of them is shown afresh. */
    show(next) {
      ids = next;
      places = new Map(ids.map((id, i) => [id, i]));
      for (const id of heights.keys()) if (!places.has(id)) heights.delete(id);
      draw(true);
    },
    /** The row, if it is drawn. */
    row: (id) => rows.get(id),
    /** Draw the row and bring it into view; null where there is none. */
    reveal(id) {
      if (!places.has(id)) return null;
      sought = id;
      draw(false);
      sought = null;
      const row = rows.get(id);
      row.node.scrollIntoView({ block: "nearest" });
      return row;
    },
    /** The rows are drawn in another form: with other heights, and a few at a time. */
    forget() {
      heights.clear();
      drawn = "";
      for (const [id, row] of rows) {
        row.node.remove();
        rows.delete(id);
        spare.push(row);
      }
    },
    end() {
      scrolled.cancel();
      observer.disconnect();
      document.removeEventListener("scroll", moved, { capture: true });
      removeEventListener("resize", moved);
    },
  };
}
