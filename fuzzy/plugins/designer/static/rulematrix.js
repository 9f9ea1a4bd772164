// The rules as a matrix of two inputs: a cell is the consequent of the rule that asks for exactly its terms.
import { button, choices, clamp, element, framed, offer, put, say, said, whenSized, widthOf } from "./chart.js";
import { drag } from "./dragging.js";
import { between, byCell, colours, commonPair, keyOf, ordered, plain, proposed, touches } from "./matrixcells.js";

const HIGH = 40, // px of a cell
  NARROW = 58,
  WIDE = 150,
  HEAD = 40, // px of the columns' names
  BEYOND = 2, // cells around those in view that are drawn
  LISTED = 50, // rules below the matrix
  HOLD = 350; // ms that a finger rests before it fills instead of scrolling
const LOOK = "look",
  CLEAR = "clear"; // brushes, besides {term}
const ANY = "any";

/**
 * The matrix {node, show(), end()}. `edit(op, content)` sends an edit, `open(key)` leads to a rule among the sentences.
 */
export function ruleMatrix({ model, edit, open }) {
  const axes = [null, null], // the names of the inputs of rows and columns
    asked = new Map(); // what was asked for and not yet answered, by the cells' keys
  let fixed = {}, // the terms of the others, null for any
    output = null,
    brush = LOOK,
    at = [0, 0], // the cell with the focus, and where the range of cells began
    from = [0, 0],
    painted = null, // under the hand: the cells by their keys, [terms, row, column]
    scene = null,
    sizes = { head: 0, wide: NARROW };
  const cells = new Map(),
    heads = new Map(),
    lines = new Map();

  // Parts ----------------------------------------------------------------------------------------------------
  const rowsOf = choices("rows", [], "", (value) => axis(0, value)),
    columnsOf = choices("columns", [], "", (value) => axis(1, value)),
    outputOf = choices("output", [], "", (value) => {
      output = value;
      brush = LOOK;
      show();
    });
  const labelled = (text, select) => element("label", { class: "fd-choice" }, element("span", {}, text), select);
  const others = element("div", { class: "fd-others" });
  const strongest = button("", "show the rule that fires most at the point", toStrongest, "Strongest now");
  const palette = element("div", { class: "fd-palette", role: "radiogroup", "aria-label": "what a click fills in" });
  const fillAll = button("", "fill the selected cells (Enter)", () => fill(range()), "Fill selected");
  const corner = element("div", { class: "fd-mcorner", role: "columnheader" });
  const top = element("div", { class: "fd-mrow", role: "row", "aria-rowindex": 1 }, corner);
  const sheet = element("div", { class: "fd-msheet", role: "presentation" }, top);
  const scroll = element("div", { class: "fd-matrix", role: "grid", "aria-multiselectable": "true" }, sheet);
  const told = element("p", { class: "fd-mtold", role: "status" }),
    note = element("p", { class: "fd-note" }),
    apart = element("div", { class: "fd-apart" });
  const node = element(
    "div",
    { class: "fd-as-matrix" },
    element(
      "div",
      { class: "fd-bar" },
      labelled("rows", rowsOf),
      labelled("columns", columnsOf),
      others,
      labelled("output", outputOf),
      strongest,
    ),
    element("div", { class: "fd-bar" }, palette, fillAll),
    told,
    scroll,
    note,
    apart,
  );

  // What is shown --------------------------------------------------------------------------------------------
  const design = () => model.get("design");
  const named = (name) => design().inputs.find((v) => v.name === name);

  function axis(which, name) {
    if (axes[1 - which] === name) axes[1 - which] = axes[which];
    axes[which] = name;
    fixed = {};
    [at, from] = [
      [0, 0],
      [0, 0],
    ];
    show();
  }

  // The choices that the design still has; the others begin where its first plain rule is.
  function settle() {
    const { inputs, outputs, rules } = design(),
      names = inputs.map((v) => v.name);
    if (axes[0] === null) [axes[0], axes[1]] = commonPair(design()) ?? axes;
    if (!names.includes(axes[0])) axes[0] = names.find((n) => n !== axes[1]) ?? names[0];
    if (!names.includes(axes[1]) || axes[1] === axes[0]) axes[1] = names.find((n) => n !== axes[0]) ?? null;
    if (!outputs.some((v) => v.name === output)) output = outputs[0].name;
    if (typeof brush === "object" && !outputs.find((v) => v.name === output).terms.some((t) => t.name === brush.term))
      brush = LOOK;
    const first = rules.find((rule) => plain(rule) && proposed(rule, output) !== null);
    const kept = {};
    for (const { name, terms } of inputs) {
      if (axes.includes(name)) continue;
      const known = name in fixed && (fixed[name] === null || terms.some((t) => t.name === fixed[name]));
      kept[name] = known ? fixed[name] : (first?.when.find((c) => c.variable === name)?.term ?? null);
    }
    fixed = kept;
  }

  function build() {
    settle();
    const { inputs, outputs, rules } = design(),
      own = outputs.find((v) => v.name === output);
    const uses = (name) => rules.some((rule) => plain(rule) && !rule.when.some((c) => c.variable === name));
    const along = (name) => (name === null ? [null] : [...ordered(named(name)), ...(uses(name) ? [null] : [])]);
    const [rows, columns] = axes.map(along);
    const mine = rules.map((rule, i) => ({ rule, number: i + 1 })).filter((e) => proposed(e.rule, output) !== null);
    scene = {
      inputs,
      own,
      rows: rows.length ? rows : [null],
      columns: columns.length ? columns : [null],
      rules: byCell(design()),
      tints: colours(own, inputs),
      unshown: mine.filter(({ rule }) => !plain(rule)),
      mine,
      firing: new Map(),
      marked: new Map(),
    };
    [at, from] = [at, from].map(([r, c]) => [
      clamp(r, 0, scene.rows.length - 1),
      clamp(c, 0, scene.columns.length - 1),
    ]);
  }

  const termsAt = (r, c) => ({
    [axes[0]]: scene.rows[r],
    ...(axes[1] === null ? {} : { [axes[1]]: scene.columns[c] }),
    ...fixed,
  });
  const asking = (terms) => Object.fromEntries(Object.entries(terms).filter(([, term]) => term !== null));
  const nothing = (terms) => Object.values(terms).every((term) => term === null);
  /** The rules of a cell for the output, and what it shows. */
  function cellAt(r, c) {
    const terms = termsAt(r, c),
      id = keyOf(terms, scene.inputs),
      there = (scene.rules.get(id) ?? []).filter(({ rule }) => proposed(rule, output) !== null),
      first = there.find(({ rule }) => rule.enabled) ?? there[0] ?? null;
    if (!scene.marked.has(id)) scene.marked.set(id, scene.unshown.filter(({ rule }) => touches(rule, terms)).length);
    const now = first ? proposed(first.rule, output) : null;
    const under = painted?.get(id);
    const term = under ? (brush === CLEAR ? null : brush.term) : asked.has(id) ? asked.get(id) : now;
    const firing = Math.max(0, ...there.map(({ rule }) => scene.firing.get(rule.key) ?? 0));
    return { terms, id, there, first, term, now, firing, others: scene.marked.get(id), void: nothing(terms) };
  }
  const strength = (value) => (value > 0 && value < 0.005 ? "less than 0.01" : value.toFixed(2));
  const wordsOf = (terms) =>
    Object.entries(asking(terms))
      .map(([name, term]) => `${name} ${term}`)
      .join(", ") || "every input any";
  function describe({ terms, there, first, term, firing, others: count, void: none }) {
    if (none) return "A rule needs at least one clause.";
    const parts = [`${wordsOf(terms)}: ${term ?? "no rule"}`];
    if (there.length > 1) parts.push(`${there.length} rules, ${there.map((e) => e.number).join(", ")}`);
    else if (first) parts.push(`rule ${first.number}`);
    if (first && !first.rule.enabled) parts.push("off");
    if (first && first.rule.weight !== 1) parts.push(`weight ${said(first.rule.weight, 3)}`);
    if (firing > 0) parts.push(`fires ${strength(firing)}`);
    if (count) parts.push(`${count} more ${count === 1 ? "rule" : "rules"} about it below`);
    return parts.join("; ");
  }

  // Drawing --------------------------------------------------------------------------------------------------
  function measure() {
    const names = (list) => Math.max(...list.map((name) => widthOf(name ?? ANY, 13, 600)), 0);
    const head = clamp(
        Math.ceil(Math.max(names(scene.rows), ...axes.map((name) => widthOf(`${name ?? ""} →`, 12)))) + 16,
        56,
        130,
      ),
      least = Math.max(names(scene.columns), names(scene.own.terms.map((t) => t.name))) + 20,
      room = (scroll.clientWidth - head - 2) / scene.columns.length;
    sizes = { head, wide: Math.floor(clamp(room, clamp(least, NARROW, 110), WIDE)) };
    put(sheet, {
      style:
        `grid-template: ${HEAD}px repeat(${scene.rows.length}, ${HIGH}px) / ${head}px ` +
        `repeat(${scene.columns.length}, ${sizes.wide}px); width: ${head + sizes.wide * scene.columns.length}px`,
    });
  }
  function inView() {
    const span = (start, room, each, count) => [
      clamp(Math.floor(start / each) - BEYOND, 0, count),
      clamp(Math.ceil((start + room) / each) + BEYOND, 0, count),
    ];
    return [
      span(scroll.scrollTop, scroll.clientHeight, HIGH, scene.rows.length),
      span(scroll.scrollLeft, scroll.clientWidth, sizes.wide, scene.columns.length),
    ];
  }
  const chosen = (r, c) => {
    const within = (k, value) => value >= Math.min(at[k], from[k]) && value <= Math.max(at[k], from[k]);
    return within(0, r) && within(1, c);
  };
  const range = () => {
    const out = [];
    for (let r = Math.min(at[0], from[0]); r <= Math.max(at[0], from[0]); r++)
      for (let c = Math.min(at[1], from[1]); c <= Math.max(at[1], from[1]); c++) out.push([r, c]);
    return out;
  };

  function head(map, id, make, place, text) {
    let made = map.get(id);
    if (!made) map.set(id, (made = make()));
    put(made, { style: place, title: text });
    say(made, text);
    return made;
  }

  function cell(r, c) {
    const id = `${r},${c}`;
    let made = cells.get(id);
    if (!made) {
      const name = element("span", { class: "fd-mname" }),
        bar = element("i", { class: "fd-mbar" }),
        marks = element("span", { class: "fd-mmarks", "aria-hidden": "true" });
      made = { node: element("div", { role: "gridcell", "data-cell": id }, name, marks, bar), name, bar, marks };
      cells.set(id, made);
    }
    const shown = cellAt(r, c),
      tint = scene.tints.get(shown.term);
    const several = shown.there.length > 1,
      weight = shown.first && shown.first.rule.weight !== 1 ? `×${said(shown.first.rule.weight, 2)}` : "";
    const classes = ["fd-mcell"];
    if (shown.void) classes.push("fd-mvoid");
    else if (shown.term === null) classes.push("fd-mempty");
    if (shown.term !== null && shown.first && !shown.first.rule.enabled) classes.push("fd-moff");
    if (shown.firing > 0) classes.push("fd-mfires");
    if (chosen(r, c) && (at[0] !== from[0] || at[1] !== from[1])) classes.push("fd-mchosen");
    const look = tint ? `background: ${tint.back}; color: ${tint.ink};` : "";
    put(made.node, {
      class: classes.join(" "),
      style: `grid-area: ${r + 2} / ${c + 2}; ${look}`,
      "aria-label": describe(shown),
      "aria-colindex": c + 2,
      "aria-selected": String(chosen(r, c)),
      "aria-disabled": shown.void ? "true" : null,
      tabindex: at[0] === r && at[1] === c ? 0 : -1,
      "data-term": shown.term,
      "data-firing": shown.firing > 0 ? shown.firing : null,
    });
    say(made.name, shown.void ? "·" : (shown.term ?? "+"));
    say(made.marks, `${several ? `${shown.there.length} rules` : ""}${weight}${shown.others ? "◥" : ""}`);
    put(made.bar, { style: shown.firing > 0 ? `width: ${(100 * Math.min(1, shown.firing)).toFixed(1)}%` : null });
    return made.node;
  }

  function draw() {
    if (!scene || scroll.clientWidth === 0) return;
    const [[r0, r1], [c0, c1]] = inView(),
      used = new Set(),
      usedHeads = new Set(["corner"]),
      usedLines = new Set();
    for (let c = c0; c < c1; c++) {
      const make = () => element("div", { class: "fd-mhead fd-mtop", role: "columnheader" });
      const made = head(heads, `c${c}`, make, `grid-area: 1 / ${c + 2}`, scene.columns[c] ?? ANY);
      put(made, { "aria-colindex": c + 2 });
      if (made.parentNode !== top) top.append(made);
      usedHeads.add(`c${c}`);
    }
    // The cell with the focus stays wherever it stands, so that keys reach it.
    const wanted = [];
    for (let r = r0; r < r1; r++) wanted.push([r, Array.from({ length: c1 - c0 }, (_, k) => c0 + k)]);
    const active = wanted.find(([r]) => r === at[0]);
    if (!active) wanted.push([at[0], [at[1]]]);
    else if (!active[1].includes(at[1])) active[1].push(at[1]);
    for (const [r, columns] of wanted) {
      let row = lines.get(r);
      if (!row) {
        row = element("div", { class: "fd-mrow", role: "row", "aria-rowindex": r + 2 });
        lines.set(r, row);
      }
      const make = () => element("div", { class: "fd-mhead fd-mleft", role: "rowheader" });
      const made = head(heads, `r${r}`, make, `grid-area: ${r + 2} / 1`, scene.rows[r] ?? ANY);
      if (made.parentNode !== row) row.prepend(made);
      usedHeads.add(`r${r}`);
      usedLines.add(r);
      for (const c of columns) {
        const one = cell(r, c);
        if (one.parentNode !== row) row.append(one);
        used.add(`${r},${c}`);
      }
      if (row.parentNode !== sheet) sheet.append(row);
    }
    const drop = (map, kept, nodeOf) => {
      for (const [id, made] of map)
        if (!kept.has(id)) {
          nodeOf(made).remove();
          map.delete(id);
        }
    };
    drop(cells, used, (made) => made.node);
    drop(heads, usedHeads, (made) => made);
    drop(lines, usedLines, (made) => made);
  }

  function paintTold() {
    const many = range().length;
    const text = many > 1 ? `${many} cells selected` : describe(cellAt(...at));
    say(told, text);
    fillAll.hidden = many < 2 || brush === LOOK;
  }

  function paintPalette() {
    const entries = [
      [LOOK, "look", "a click selects and changes nothing"],
      ...scene.own.terms.map((term) => [{ term: term.name }, term.name, `fill in ${term.name}`]),
      [CLEAR, "clear", "a click removes the rule"],
    ];
    const is = (value) => JSON.stringify(value) === JSON.stringify(brush);
    const key = JSON.stringify([entries, [...scene.tints.values()]]);
    if (palette.dataset.entries !== key) {
      palette.dataset.entries = key;
      palette.replaceChildren(
        ...entries.map(([value, text, title]) => {
          const tint = typeof value === "object" ? scene.tints.get(value.term) : null;
          const one = element(
            "button",
            { role: "radio", class: "fd-brush", title, onclick: () => choose(value) },
            text,
          );
          if (tint) put(one, { style: `background: ${tint.back}; color: ${tint.ink}` });
          one.value = JSON.stringify(value);
          return one;
        }),
      );
    }
    for (const one of palette.children) {
      const checked = is(JSON.parse(one.value));
      put(one, { "aria-checked": String(checked), tabindex: checked ? 0 : -1 });
    }
  }
  function choose(value) {
    brush = value;
    paintPalette();
    paintTold();
  }
  palette.addEventListener("keydown", (event) => {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    const all = [...palette.children],
      next = all[(all.indexOf(document.activeElement) + by + all.length) % all.length];
    choose(JSON.parse(next.value));
    next.focus();
  });

  function paintBars() {
    const { inputs, outputs } = scene.inputs ? design() : { inputs: [], outputs: [] };
    const names = inputs.map((v) => [v.name, v.name]);
    offer(rowsOf, names, axes[0]);
    offer(columnsOf, names, axes[1] ?? "");
    columnsOf.parentElement.hidden = axes[1] === null;
    offer(
      outputOf,
      outputs.map((v) => [v.name, v.name]),
      output,
    );
    outputOf.parentElement.hidden = outputs.length < 2;
    const rest = inputs.filter((v) => !axes.includes(v.name));
    while (others.childElementCount > rest.length) others.lastChild.remove();
    rest.forEach((variable, k) => {
      if (!others.children[k]) {
        const select = choices("", [], "", (value) => {
          fixed[select.dataset.input] = value === "" ? null : JSON.parse(value);
          show();
        });
        others.append(labelled("", select));
      }
      const select = others.children[k].querySelector("select");
      select.dataset.input = variable.name;
      put(select, { "aria-label": `${variable.name} of the rules shown` });
      say(others.children[k].firstChild, variable.name);
      const options = ordered(variable).map((name) => [JSON.stringify(name), name]);
      offer(select, [["", ANY], ...options], fixed[variable.name] === null ? "" : JSON.stringify(fixed[variable.name]));
    });
    say(corner, axes[1] === null ? axes[0] : `${axes[0]} ↓\n${axes[1]} →`);
    put(corner, { title: axes[1] === null ? axes[0] : `rows: ${axes[0]}, columns: ${axes[1]}` });
    put(scroll, {
      "aria-label": `Rules for ${output}`,
      "aria-rowcount": scene.rows.length + 1,
      "aria-colcount": scene.columns.length + 1,
    });
  }

  // Rules that no cell shows, and those of which a cell shows only one
  function paintApart() {
    let here = 0;
    const several = [];
    for (let r = 0; r < scene.rows.length; r++)
      for (let c = 0; c < scene.columns.length; c++) {
        const there = cellRules(r, c);
        here += there.length;
        if (there.length > 1) several.push(...there);
      }
    const rules = `${scene.mine.length} ${scene.mine.length === 1 ? "rule" : "rules"} for ${output}`;
    const elsewhere = scene.mine.length - here - scene.unshown.length;
    say(
      note,
      `${here} of ${rules} stand here${elsewhere > 0 ? `, ${elsewhere} at other terms of the other inputs` : ""}. ` +
        "Type a consequent's first letter, select with Shift and arrows, Enter fills, Delete clears.",
    );
    const key = JSON.stringify([several, scene.unshown].map((list) => list.map((e) => [e.number, e.rule.text])));
    if (apart.dataset.rules === key) return;
    apart.dataset.rules = key;
    const part = (title, list) => {
      if (!list.length) return [];
      const item = ({ rule, number }) =>
        element(
          "li",
          {},
          element("button", { class: "fd-button fd-link", onclick: () => open(rule.key) }, `rule ${number}`),
          ` ${rule.text}`,
        );
      const more = list.length > LISTED ? [element("li", {}, `and ${list.length - LISTED} more`)] : [];
      return [element("h2", {}, title), element("ul", {}, ...list.slice(0, LISTED).map(item), ...more)];
    };
    apart.replaceChildren(
      ...part("Several rules for the same cell", several),
      ...part("Rules that no cell shows (“not”, hedges, “or”): ◥ marks the cells they are about", scene.unshown),
    );
  }
  const cellRules = (r, c) =>
    (scene.rules.get(keyOf(termsAt(r, c), scene.inputs)) ?? []).filter(({ rule }) => proposed(rule, output) !== null);

  // Hands ----------------------------------------------------------------------------------------------------
  const redraw = framed(draw);
  function go([r, c], extend = false, focus = true) {
    at = [clamp(r, 0, scene.rows.length - 1), clamp(c, 0, scene.columns.length - 1)];
    if (!extend) from = at;
    reveal();
    draw();
    if (focus) cells.get(at.join())?.node.focus({ preventScroll: true });
    paintTold();
  }
  function reveal() {
    const [top0, left0] = [at[0] * HIGH, at[1] * sizes.wide],
      [high, wide] = [scroll.clientHeight - HEAD, scroll.clientWidth - sizes.head];
    if (top0 < scroll.scrollTop) scroll.scrollTop = top0;
    else if (top0 + HIGH > scroll.scrollTop + high) scroll.scrollTop = top0 + HIGH - high;
    if (left0 < scroll.scrollLeft) scroll.scrollLeft = left0;
    else if (left0 + sizes.wide > scroll.scrollLeft + wide) scroll.scrollLeft = left0 + sizes.wide - wide;
  }
  function send(list, term) {
    const known = list.map(([r, c]) => cellAt(r, c)).filter((each) => !each.void);
    const news = known.filter((each) => each.now !== term || each.there.length > 1);
    if (!news.length) return;
    for (const each of news) asked.set(each.id, term);
    draw();
    edit("fill_rules", { variable: output, cells: news.map((each) => [asking(each.terms), term]) });
  }
  function fill(list) {
    if (brush === LOOK) say(told, "Choose a consequent first: type its first letter, or press it above.");
    else send(list, brush === CLEAR ? null : brush.term);
  }
  // The cell under a point of the screen; beyond the edge the nearest.
  function under(event) {
    const box = scroll.getBoundingClientRect();
    const y = event.clientY - box.top - HEAD + scroll.scrollTop,
      x = event.clientX - box.left - sizes.head + scroll.scrollLeft;
    return [
      clamp(Math.floor(y / HIGH), 0, scene.rows.length - 1),
      clamp(Math.floor(x / sizes.wide), 0, scene.columns.length - 1),
    ];
  }
  const paint = (list) => {
    for (const [r, c] of list) {
      const { id, void: none } = cellAt(r, c);
      if (!none) painted.set(id, [r, c]);
    }
  };
  let last = null;
  const begin = (event) => {
    last = under(event);
    if (brush !== LOOK) {
      painted = new Map();
      paint([last]);
    }
    go(last, brush === LOOK && event.shiftKey);
  };
  const follow = (event) => {
    const now = under(event);
    if (now.join() === last.join()) return;
    if (brush === LOOK) go(now, true);
    else {
      paint(between(last, now));
      at = from = now;
      redraw.soon();
    }
    last = now;
  };
  const finish = (cancelled) => {
    const list = painted ? [...painted.values()] : [];
    painted = null;
    if (list.length && !cancelled) fill(list);
    draw();
    paintTold();
    if (list.length) cells.get(at.join())?.node.focus({ preventScroll: true });
  };
  drag(sheet, {
    start(event) {
      if (event.pointerType === "touch" || !event.target.closest(".fd-mcell")) return false;
      begin(event);
    },
    move: follow,
    end: (_, cancelled) => finish(cancelled),
  });
  // A finger scrolls; a tap fills one cell, and a finger that rests first fills where it goes.
  let resting = 0,
    touching = false;
  sheet.addEventListener("click", (event) => {
    if (event.pointerType !== "touch" || !event.target.closest(".fd-mcell")) return;
    begin(event);
    finish(false);
  });
  const touchAt = (event) => ({ clientX: event.touches[0].clientX, clientY: event.touches[0].clientY });
  sheet.addEventListener(
    "touchstart",
    (event) => {
      clearTimeout(resting);
      if (event.touches.length !== 1 || !event.target.closest(".fd-mcell")) return;
      const where = touchAt(event);
      resting = setTimeout(() => {
        touching = true;
        begin(where);
      }, HOLD);
    },
    { passive: true },
  );
  sheet.addEventListener(
    "touchmove",
    (event) => {
      clearTimeout(resting);
      if (!touching) return;
      event.preventDefault();
      follow(touchAt(event));
    },
    { passive: false },
  );
  for (const name of ["touchend", "touchcancel"])
    sheet.addEventListener(name, (event) => {
      clearTimeout(resting);
      if (!touching) return;
      touching = false;
      event.preventDefault(); // no click follows
      finish(name === "touchcancel");
    });
  sheet.addEventListener("contextmenu", (event) => {
    if (!event.target.closest(".fd-mcell")) return;
    event.preventDefault();
    if (event.pointerType === "touch") return;
    const where = under(event);
    if (!chosen(...where)) go(where);
    send(range(), null);
  });

  scroll.addEventListener("keydown", (event) => {
    const [r, c] = at,
      page = Math.max(1, Math.floor((scroll.clientHeight - HEAD) / HIGH) - 1),
      far = event.ctrlKey || event.metaKey;
    const to = {
      ArrowUp: [r - 1, c],
      ArrowDown: [r + 1, c],
      ArrowLeft: [r, c - 1],
      ArrowRight: [r, c + 1],
      Home: [far ? 0 : r, 0],
      End: [far ? scene.rows.length - 1 : r, scene.columns.length - 1],
      PageUp: [r - page, c],
      PageDown: [r + page, c],
    }[event.key];
    const stop = () => {
      event.preventDefault();
      event.stopPropagation();
    };
    if (to && !event.altKey) {
      stop();
      go(to, event.shiftKey);
    } else if (far && event.key.toLowerCase() === "a") {
      stop();
      from = [0, 0];
      go([scene.rows.length - 1, scene.columns.length - 1], true);
    } else if (event.key === "Enter" || event.key === " ") {
      stop();
      fill(range());
    } else if (event.key === "Delete" || event.key === "Backspace") {
      stop();
      send(range(), null);
    } else if (event.key === "Escape" && painted === null) {
      if (brush !== LOOK) choose(LOOK);
      go(at);
    } else if (event.key.length === 1 && !far && !event.altKey) pick(event, stop);
  });
  // The next consequent that begins with a letter
  function pick(event, stop) {
    const letter = event.key.toLocaleLowerCase(),
      names = scene.own.terms.map((t) => t.name),
      held = typeof brush === "object" ? names.indexOf(brush.term) : -1;
    const next = names
      .map((_, k) => names[(held + 1 + k) % names.length])
      .find((name) => name.toLocaleLowerCase().startsWith(letter));
    if (next === undefined) return;
    stop();
    choose({ term: next });
    say(told, `Enter fills in ${next}.`);
  }
  scroll.addEventListener("scroll", () => redraw.soon(), { passive: true });
  sheet.addEventListener("pointerover", (event) => {
    const id = event.target.closest(".fd-mcell")?.dataset.cell;
    if (id && painted === null && from.join() === at.join()) say(told, describe(cellAt(...id.split(",").map(Number))));
  });
  sheet.addEventListener("pointerleave", () => scene && paintTold());

  function toStrongest() {
    const firing = new Map((model.get("viewer")?.rules ?? []).map((rule) => [rule.key, rule.firing]));
    let best = null;
    for (const { rule } of scene.mine)
      if (plain(rule) && (firing.get(rule.key) ?? 0) > (best ? firing.get(best.key) : 0)) best = rule;
    if (!best) {
      say(told, "No rule that a cell shows fires at the point.");
      return;
    }
    const terms = Object.fromEntries(best.when.map((c) => [c.variable, c.term]));
    for (const name of Object.keys(fixed)) fixed[name] = terms[name] ?? null;
    show();
    const where = (list, name) => Math.max(0, list.indexOf(terms[name] ?? null));
    go([where(scene.rows, axes[0]), axes[1] === null ? 0 : where(scene.columns, axes[1])]);
  }

  function paintFiring() {
    if (!scene) return;
    scene.firing = new Map((model.get("viewer")?.rules ?? []).map((rule) => [rule.key, rule.firing]));
    draw();
  }

  function show() {
    if (node.hidden || !node.isConnected) return;
    const had = scroll.contains(document.activeElement);
    build();
    paintBars();
    measure();
    paintFiring();
    paintPalette();
    paintApart();
    if (!painted) paintTold();
    if (had && !scroll.contains(document.activeElement)) cells.get(at.join())?.node.focus({ preventScroll: true });
  }

  const unsize = whenSized(scroll, () => {
    if (!scene) return void show();
    measure();
    draw();
  });
  return {
    node,
    show,
    /** Another design, or a refusal: what was asked for is answered. */
    answered() {
      asked.clear();
      redraw.soon();
    },
    firing: paintFiring,
    end() {
      redraw.end();
      clearTimeout(resting);
      unsize();
    },
  };
}
