// The rules as sentences, as a table and as a matrix; an error is underlined at the word, and the last good rule stays
// in force.
import {
  button,
  choices,
  clamp,
  element,
  endOf,
  offer,
  put,
  said,
  say,
  shortChoices,
  watch,
  whenShown,
  widthOf,
} from "./chart.js";
import { coloured, completing, namesOf } from "./completion.js";
import { numberField, pressing, problemLine } from "./dragging.js";
import { ruleMatrix } from "./rulematrix.js";
import { listed, orders } from "./ruleorder.js";
import { selectedRules } from "./selectedrules.js";
import { windowed } from "./windowed.js";

const HEDGES = [
  ["", 1],
  ["somewhat ", 0.5],
  ["very ", 2],
  ["extremely ", 3],
  ["very very ", 4],
];

const JOINTS = ["and", "or"].map((word) => [word, word]);

// "is not very" as a choice's value: [negated, power]
function manners(clause) {
  const list = [false, true].flatMap((no) =>
    HEDGES.map(([words, power]) => [JSON.stringify([no, power]), `is ${no ? "not " : ""}${words}`.trim()]),
  );
  const own = JSON.stringify([clause.negated, clause.power]);
  if (!list.some(([value]) => value === own))
    list.push([own, `is ${clause.negated ? "not " : ""}^${said(clause.power)}`]);
  return [list, own];
}

export function render({ model, el }) {
  const root = element("div", { class: "fd fd-rules" }),
    key = pressing();
  const edit = (op, content, name = null) => model.send({ edit: op, ...content, gesture: name });
  let form = "sentences",
    waiting = null, // what has the focus once the design is the next: {id, label}
    added = null, // the keys before a rule was added, which then has the focus
    sought = null, // the number of the last link that led to a rule
    places = new Map(), // by the rules' keys, in the design
    ids = [], // the keys of what is shown
    shownAt = new Map(), // their places there
    vocabulary = ""; // the names that a table offers

  const views = ["Sentences", "Table", "Matrix"].map((name) =>
    element(
      "button",
      { class: "fd-tab", "data-view": name.toLowerCase(), onclick: () => take(name.toLowerCase()) },
      name,
    ),
  );
  function take(name) {
    form = name;
    shownRows.forget();
    paint();
  }
  const search = element("input", {
    type: "text",
    "aria-label": "find rules with these words",
    placeholder: "find: words of a rule",
    class: "fd-search",
    autocomplete: "off",
    spellcheck: "false",
    oninput: () => paint(),
    onkeydown: (event) => {
      if (event.key !== "Escape") return;
      search.value = "";
      paint();
    },
  });
  const firing = element("input", { type: "checkbox", onchange: () => paint() });
  const order = choices("sort", [["", "as written"]], "", () => paint());
  const everyRule = element("input", {
    type: "checkbox",
    "aria-label": "select all rules that are shown",
    onchange: () => (everyRule.checked ? selection.all() : selection.clear()),
  });
  const list = element("div", { class: "fd-list", "aria-label": "Rules" });
  // Where the table has room, one line of headings for all rules; each choice has its own name all the same.
  const headings = element("div", { class: "fd-headings" });
  const frame = element("div", { class: "fd-sheet" }, headings, list);
  const count = element("p", { class: "fd-note" });
  const problem = problemLine(model, root);
  const bar = element(
    "div",
    { class: "fd-actions" },
    button(
      "plus",
      "add a rule for the first combination of terms that has none",
      () => {
        added = new Set(places.keys());
        edit("add_rule", { after: model.get("design").rules.at(-1)?.key ?? null });
      },
      "Add rule",
    ),
    button(
      "plus",
      "add a rule for each combination of terms that has none",
      () => edit("add_all_rules", {}),
      "Add all combinations",
    ),
  );
  const found = [
    search,
    element("label", { class: "fd-check" }, firing, "fires now"),
    element("label", { class: "fd-check" }, "sort", order),
  ];
  const selection = selectedRules({
    model,
    edit,
    shown: () => ids,
    movable: () => order.value === "",
    changed: () => paint(),
  });
  const matrix = ruleMatrix({
    model,
    edit,
    open(id) {
      take("sentences");
      goTo(id);
    },
  });
  const counted = element("div", { class: "fd-counted" }, element("label", { class: "fd-check" }, everyRule), count);
  const hints = element(
    "p",
    { class: "fd-note" },
    "Enter accepts a sentence, Escape gives the last good one back, and Alt with an up or down arrow moves the rule. " +
      "Ctrl+A selects all rules, Shift those between.",
  );
  root.append(
    element(
      "div",
      { class: "fd-bar" },
      element("div", { class: "fd-tabs", role: "group", "aria-label": "Show rules as" }, ...views),
      ...found,
    ),
    counted,
    selection.node,
    frame,
    matrix.node,
    bar,
    problem.node,
    hints,
  );
  el.append(root);

  const rules = () => model.get("design").rules;
  const place = (id) => places.get(id) ?? -1;
  // To the place of the neighbour that is shown.
  function move(id, by) {
    const neighbour = ids[ids.indexOf(id) + by];
    if (order.value !== "" || (neighbour === undefined && selection.size() < 2)) return;
    waiting = { id, label: document.activeElement?.dataset?.part ?? null };
    if (selection.has(id) && selection.size() > 1) return void selection.move(by);
    edit("move_rule", { key: id, to: place(neighbour) });
  }

  // The sentence: a text field over the same text, which carries the underline and gives the height.
  function sentence(own) {
    const under = element("div", { class: "fd-under", "aria-hidden": "true" });
    const field = element("textarea", { rows: 1, spellcheck: "false", "data-part": "text", autocomplete: "off" });
    const told = element("p", { class: "fd-wrong", role: "alert" });
    told.id = `fd-${Math.random().toString(36).slice(2)}`;
    let shown = { text: "", problem: null },
      drawn = "", // what was coloured last, by which names
      sent = null; // what stood there when it was sent, until it is answered
    const mark = () => {
      const text = field.value,
        wrong = text === shown.text ? shown.problem : null,
        now = wrong ? "" : `${text} ${namesOf(model.get("design"))}`;
      if (now !== "" && now === drawn) return;
      drawn = now;
      if (!wrong) {
        under.replaceChildren(...coloured(text, model.get("design")), " ");
        return;
      }
      // Where a word is missing, the place before it is marked.
      const end = Math.max(wrong.end, wrong.start + 1),
        start = Math.min(wrong.start, Math.max(0, text.length - 1));
      under.replaceChildren(
        text.slice(0, start),
        element("mark", {}, text.slice(start, end) || " "),
        `${text.slice(end)} `,
      );
    };
    const take = () => {
      const text = field.value.replace(/\s+/g, " ").trim();
      if (text === shown.text) return;
      sent = field.value;
      edit("rule_text", { key: own(), text });
    };
    const offers = completing(field, () => model.get("design"), mark);
    field.addEventListener("input", mark);
    field.addEventListener("change", take);
    field.addEventListener("keydown", (event) => {
      if (event.key === "Enter") {
        event.preventDefault();
        // Told to the page too: what was typed is taken, and undo is the design's again.
        field.dispatchEvent(new Event("change", { bubbles: true }));
      }
      if (event.key === "Escape") {
        field.value = shown.problem?.good ?? shown.text;
        mark();
        take(); // a sentence that is wrong was taken already: the good one takes its place
      }
    });
    const show = (rule, number) => {
      const before = shown.text;
      shown = { text: rule.text, problem: rule.problem };
      // What is being written is not overwritten by news of other rules, nor by the answer to what was sent before.
      const writing = field.value !== (before === rule.text ? before : (sent ?? field.value));
      if (document.activeElement !== field || !writing) field.value = rule.text;
      if (before !== rule.text) sent = null;
      put(field, {
        "aria-label": `rule ${number}`,
        "aria-invalid": rule.problem ? "true" : null,
        "aria-describedby": rule.problem ? told.id : null,
      });
      say(told, rule.problem ? rule.problem.message : "");
      mark();
    };
    return {
      node: element(
        "div",
        { class: "fd-sentence" },
        element("div", { class: "fd-over" }, under, field),
        offers.node,
        told,
      ),
      show,
    };
  }

  // The table's cells: a manner and a term for each input, the connective, a term for each output.
  function cells(own) {
    const node = element("div", { class: "fd-cells" });
    let parts = [],
      form = "";
    const mine = () => rules()[place(own())];
    const clause = (name) =>
      mine().when.find((each) => each.variable === name) ?? { variable: name, term: null, negated: false, power: 1 };
    const build = (design) => {
      parts = [];
      const cell = (head, ...inside) =>
        element(
          "div",
          { class: "fd-cell", role: "cell" },
          element("span", { class: "fd-head", "aria-hidden": "true" }, head),
          ...inside,
        );
      const ins = design.inputs.map(({ name }) => {
        const how = shortChoices(`${name}, manner`, (value) => {
          const [negated, power] = JSON.parse(value);
          edit("rule_clause", { ...clause(name), key: own(), negated, power });
        });
        const term = shortChoices(`${name}, term`, (value) =>
          edit("rule_clause", { ...clause(name), key: own(), term: value || null }),
        );
        how.dataset.part = `how ${name}`;
        term.dataset.part = `term ${name}`;
        parts.push({ name, how, term });
        return cell(name, element("div", { class: "fd-pair" }, how, term));
      });
      const joint = shortChoices("connective", (value) => edit("rule_connective", { key: own(), connective: value }));
      joint.dataset.part = "connective";
      parts.joint = joint;
      const outs = design.outputs.map(({ name }) => {
        const term = shortChoices(`${name}, consequent`, (value) =>
          edit("rule_then", { key: own(), variable: name, term: value || null }),
        );
        term.dataset.part = `then ${name}`;
        parts.push({ name, then: term });
        return cell(`then ${name}`, term);
      });
      node.replaceChildren(...ins, cell("joined by", joint), ...outs);
    };
    const show = (rule, number, design) => {
      const now = JSON.stringify([design.inputs.map((v) => v.name), design.outputs.map((v) => v.name)]);
      if (now !== form) {
        form = now;
        build(design);
      }
      for (const { name, how, term, then } of parts) {
        const variable = [...design.inputs, ...design.outputs].find((v) => v.name === name),
          terms = variable.terms.map((t) => [t.name, t.name]);
        if (then) {
          then.offer([["", "–"], ...terms], rule.then.find((each) => each.variable === name)?.term ?? "");
          continue;
        }
        const own = rule.when.find((each) => each.variable === name);
        term.offer([["", "any"], ...terms], own?.term ?? "");
        how.offer(...manners(own ?? { negated: false, power: 1 }));
        how.disabled = !own;
        put(term, { class: own ? null : "fd-any" });
      }
      parts.joint.offer(JOINTS, rule.connective);
      parts.joint.disabled = rule.when.length < 2;
      put(node, { role: "presentation", "data-row": number });
    };
    return { node, show };
  }

  // A row, of one rule after another
  function line() {
    let id = null;
    const own = () => id;
    const picked = element("input", { type: "checkbox", class: "fd-pick", "data-part": "pick" });
    picked.addEventListener("click", (event) => selection.pick(id, picked.checked, event.shiftKey));
    const on = element("input", {
      type: "checkbox",
      role: "switch",
      class: "fd-inforce",
      title: "in force",
      "data-part": "enabled",
      onchange: () => edit("rule_enabled", { key: id, enabled: on.checked }),
    });
    const number = element("span", { class: "fd-number-of" }),
      share = element("span", { class: "fd-weight", title: "weight" });
    const weight = numberField(
      "weight",
      () => [0, 1],
      (value, event, field) => edit("rule_weight", { key: id, weight: value, field }, key(event)),
    );
    weight.input.dataset.part = "weight";
    const words = { up: "move up", down: "move down", copy: "copy", bin: "delete" };
    const tools = {
      up: button("up", "", () => move(id, -1)),
      down: button("down", "", () => move(id, 1)),
      copy: button("copy", "", () => edit("copy_rule", { key: id })),
      bin: button("bin", "", () => {
        const next = rules()[place(id) + 1] ?? rules()[place(id) - 1];
        waiting = next ? { id: next.key, label: "bin" } : null;
        edit("remove_rule", { key: id });
      }),
    };
    for (const [part, tool] of Object.entries(tools)) tool.dataset.part = part;
    const text = sentence(own),
      table = cells(own);
    // Over the row itself, and only while one points at the dots or is in it by keyboard: it hides no other rule.
    const more = element("button", { class: "fd-more-of", tabindex: -1 }, "⋯");
    const dots = element(
      "div",
      { class: "fd-dots" },
      more,
      element("div", { class: "fd-tools" }, weight.node, ...Object.values(tools)),
    );
    const node = element(
      "div",
      { class: "fd-rule" },
      element("div", { class: "fd-switch" }, element("label", {}, picked, number), on, share, dots),
      text.node,
      table.node,
    );
    node.addEventListener(
      "keydown",
      (event) => {
        if (!event.altKey || !["ArrowUp", "ArrowDown"].includes(event.key)) return;
        event.preventDefault();
        event.stopPropagation();
        move(id, event.key === "ArrowUp" ? -1 : 1);
      },
      true,
    );
    let drawn = "";
    const show = () => {
      const design = model.get("design"),
        rule = design.rules[place(id)],
        n = place(id) + 1,
        at = shownAt.get(id),
        asTable = form === "table";
      const state = JSON.stringify([
        rule,
        n,
        form,
        [at, ids.length, order.value, selection.has(id)],
        asTable ? vocabulary : 0,
      ]);
      if (state === drawn) return;
      drawn = state;
      picked.checked = selection.has(id);
      put(picked, { "aria-label": `select rule ${n}` });
      on.checked = rule.enabled;
      weight.input.disabled = on.disabled = rule.unread; // a line of the file, of which only the text can be changed
      put(on, { "aria-label": `${n}, rule in force` });
      say(number, `${n}`);
      // A sentence states its weight itself.
      say(share, asTable && rule.weight !== 1 ? `× ${said(rule.weight, 3)}` : "");
      put(node, {
        class: `fd-rule${rule.enabled || rule.unread ? "" : " fd-off"}${rule.problem ? " fd-bad" : ""}${picked.checked ? " fd-picked" : ""}`,
        "data-key": rule.key,
        role: asTable ? "row" : "listitem",
        "aria-label": `rule ${n}`,
        "aria-rowindex": asTable ? at + 2 : null,
        "aria-posinset": asTable ? null : at + 1,
        "aria-setsize": asTable ? null : ids.length,
      });
      for (const part of [node.firstChild, text.node]) put(part, { role: asTable ? "cell" : null });
      text.node.hidden = asTable && !rule.problem;
      table.node.hidden = !asTable || rule.unread;
      text.show(rule, n);
      if (asTable) table.show(rule, n, design);
      weight.show(rule.weight, id);
      put(more, { "aria-label": `tools of rule ${n}` });
      put(weight.input, { "aria-label": `weight of rule ${n}`, "aria-valuemin": 0, "aria-valuemax": 1 });
      for (const [part, tool] of Object.entries(tools))
        put(tool, { "aria-label": `${words[part]} rule ${n}`, title: `${words[part]} rule ${n}` });
      tools.up.disabled = at === 0 || order.value !== "";
      tools.down.disabled = at === ids.length - 1 || order.value !== "";
    };
    const take = (next) => {
      id = next;
      drawn = "";
    };
    return { node, take, show };
  }

  const shownRows = windowed(list, line, frame);

  // What is found: the rules with all the words, of these those that fire; and what one is writing in.
  function choose() {
    const held = list.contains(document.activeElement)
      ? document.activeElement.closest("[data-key]")?.dataset.key
      : undefined;
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const wish = { words, fires: firing.checked, order: order.value, held };
    reorder(listed(model.get("design"), model.get("viewer"), wish));
  }
  function reorder(next) {
    ids = next;
    shownAt = new Map(ids.map((id, i) => [id, i]));
  }

  // Keys of the list: what is selected, by Ctrl+A, arrows on the boxes, Delete and Escape
  const box = (id) => shownRows.reveal(id)?.node.querySelector("[data-part=pick]");
  list.addEventListener("keydown", (event) => {
    const field = event.target,
      id = Number(field.closest("[data-key]")?.dataset.key),
      onBox = field.dataset.part === "pick";
    const stop = () => {
      event.preventDefault();
      event.stopPropagation();
    };
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "a" && !event.altKey) {
      // In a sentence its text first
      if (field.selectionStart !== undefined && field.selectionEnd - field.selectionStart < field.value?.length) {
        if (field.type !== "checkbox") return;
      }
      stop();
      selection.all();
    } else if (onBox && event.key === "Delete") {
      stop();
      if (!selection.has(id)) return;
      const next =
        ids.slice(shownAt.get(id)).find((key) => !selection.has(key)) ?? ids.findLast((key) => !selection.has(key));
      waiting = next === undefined ? null : { id: next, label: "pick" };
      selection.drop();
    } else if (onBox && event.key === "Escape") {
      stop();
      selection.clear();
    } else if (onBox && !event.altKey && ["ArrowUp", "ArrowDown"].includes(event.key)) {
      stop();
      const next = ids[shownAt.get(id) + (event.key === "ArrowUp" ? -1 : 1)];
      if (next === undefined) return;
      if (event.shiftKey) {
        if (!selection.has(id)) selection.pick(id, true, false);
        selection.pick(next, true, true);
      }
      box(next)?.focus({ preventScroll: true });
    }
  });

  // A link, or a rule that was added, takes the focus to the rule.
  function goTo(id) {
    if (form === "matrix") take("sentences");
    if (!shownAt.has(id)) {
      search.value = "";
      firing.checked = false;
      choose();
      shownRows.show(ids);
    }
    const row = shownRows.reveal(id)?.node,
      part = row?.querySelector(form === "table" ? "select:not(:disabled)" : "textarea");
    if (part?.checkVisibility()) part.focus({ preventScroll: true });
    return Boolean(part?.checkVisibility());
  }

  // A column of the table is as wide as its longest word: were it the rows' own matter, all of them would be laid out
  // anew for each that comes into view.
  const column = ({ name, terms }, least, more) => {
    const words = Math.max(...terms.map((term) => widthOf(term.name, 14.4)), widthOf(name, 13) - more + 16);
    return clamp(Math.ceil(words) + more, least, 260);
  };
  let headed = "";
  function paintHeadings({ inputs, outputs }) {
    const names = [...inputs.map((v) => v.name), "joined by", ...outputs.map((v) => `then ${v.name}`)];
    if (headed === vocabulary) return;
    headed = vocabulary;
    const wide = [...inputs.map((v) => column(v, 136, 96)), 68, ...outputs.map((v) => column(v, 104, 42))];
    const columns = wide.map((px, i) => (i === inputs.length ? `${px}px` : `minmax(${px}px, 1fr)`));
    root.style.setProperty("--columns", columns.join(" "));
    root.style.setProperty("--least", `${wide.reduce((a, b) => a + b, 0) + 8 * wide.length + 138}px`);
    const head = (text) => element("span", { class: "fd-head", title: text }, text);
    put(headings, { role: "row", "aria-rowindex": 1 });
    const named = (text) => put(head(text), { role: "columnheader" });
    headings.replaceChildren(
      named("rule"),
      element("div", { class: "fd-cells", role: "presentation" }, ...names.map(named)),
    );
  }

  function paint() {
    const design = model.get("design"),
      focused = document.activeElement,
      asTable = form === "table";
    places = new Map(design.rules.map((rule, i) => [rule.key, i]));
    vocabulary = JSON.stringify([...design.inputs, ...design.outputs].map((v) => [v.name, v.terms.map((t) => t.name)]));
    root.classList.toggle("fd-as-table", asTable);
    paintHeadings(design);
    for (const view of views) put(view, { "aria-pressed": String(view.dataset.view === form) });
    offer(order, orders(design), order.value);
    if (order.selectedIndex < 0) order.value = "";
    const asMatrix = form === "matrix";
    for (const part of [...found, counted, frame, hints]) part.hidden = asMatrix;
    matrix.node.hidden = !asMatrix;
    choose();
    selection.show();
    if (asMatrix) selection.node.hidden = true;
    everyRule.checked = ids.length > 0 && ids.every(selection.has);
    everyRule.indeterminate = !everyRule.checked && selection.size() > 0;
    put(frame, { role: asTable ? "table" : null, "aria-label": asTable ? "Rules" : null });
    // Without a row there is nothing in it to focus, by which keys could scroll it.
    put(frame, { "aria-rowcount": asTable ? ids.length + 1 : null, tabindex: asTable && !ids.length ? 0 : null });
    put(list, { role: asTable ? "rowgroup" : "list" });
    if (asMatrix) matrix.show();
    else shownRows.show(ids);
    const off = design.rules.filter((rule) => !rule.enabled && !rule.unread).length,
      unread = design.rules.filter((rule) => rule.unread).length,
      wrong = design.rules.filter((rule) => rule.problem).length - unread;
    const all = design.rules.length === 1 ? "1 rule" : `${design.rules.length} rules`;
    const words = [
      ids.length === design.rules.length ? all : `${ids.length} of ${all}`,
      ...(off ? [`${off} off`] : []),
      ...(unread ? [`${unread} of the file cannot be read: mend or delete ${unread === 1 ? "it" : "them"}`] : []),
      ...(wrong ? [`${wrong} with an error; its last good form is in force`] : []),
    ];
    say(count, words.join(", "));
    // A rule that was moved takes the focus with it; one that was deleted leaves it to its neighbour.
    if (root.contains(focused) && document.activeElement !== focused) focused.focus();
    if (waiting) {
      const node = shownRows.row(waiting.id)?.node,
        part = node && [...node.querySelectorAll("[data-part]")].find((each) => each.dataset.part === waiting.label);
      if (part && (document.activeElement === document.body || root.contains(document.activeElement))) {
        const free = part.disabled ? part.parentNode.querySelector("button:not(:disabled)") : part;
        if (document.activeElement !== free) free?.focus();
      }
      waiting = null;
    }
    const fresh = added && design.rules.find((rule) => !added.has(rule.key));
    if (fresh) {
      added = null;
      goTo(fresh.key);
    }
    const link = model.get("sought");
    if (link && link.number !== sought && goTo(link.key)) sought = link.number;
  }

  const ends = [
    watch(model, ["design", "problem"], matrix.answered), // before it is painted
    watch(model, ["design", "sought"], paint),
    watch(model, ["viewer"], () => {
      if (form === "matrix") matrix.firing();
      else if (firing.checked || order.value === "firing") paint();
    }),
    watch(model, ["problem"], () => {
      if (model.get("problem")) added = null;
      problem.show();
    }),
    whenShown(list, paint), // a link may lead here before the tab is shown
    () => shownRows.end(),
    () => matrix.end(),
  ];
  paint();
  return endOf(root, ...ends);
}

export default { render };
