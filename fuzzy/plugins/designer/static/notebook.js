// The designer in a notebook: the page's modules as two groups of tabs, with undo and redo above them.
import { element, put, say } from "./chart.js";
import { historyKeys, keepKeys } from "../../../static/keys.js";
import rules from "./rules.js";
import surface from "./surface.js";
import terms from "./terms.js";
import tree from "./tree.js";
import viewer from "./viewer.js";

const OFTEN = 200; // ms between two edits that the notebook is told of, so that marimo runs the cells that use them

const GROUPS = [
  [
    "Edit the design",
    [
      ["Memberships", terms],
      ["Rules", rules],
    ],
  ],
  [
    "Look at it",
    [
      ["Viewer", viewer],
      ["Surface", surface],
    ],
  ],
];

/** Tabs over views, of which each is made when it is first looked at; `ends` gets what takes them away. */
function group(label, tabs, model, ends) {
  const list = element("div", { role: "tablist", "aria-label": label, class: "fuzzy-editor-tabs" });
  const pairs = tabs.map(([title, part], k) => {
    const view = element("div", { role: "tabpanel", "aria-label": title, class: "fuzzy-editor-view", hidden: true });
    const tab = element("button", { role: "tab", onclick: () => choose(k) }, title);
    list.append(tab);
    return { tab, view, part };
  });
  function choose(chosen, focus = false) {
    for (const [k, { tab, view, part }] of pairs.entries()) {
      put(tab, { "aria-selected": String(k === chosen), tabindex: k === chosen ? 0 : -1 });
      view.hidden = k !== chosen;
      if (k === chosen && !view.dataset.made) {
        view.dataset.made = "yes";
        ends.push(part.render({ model, el: view }));
      }
    }
    if (focus) pairs[chosen].tab.focus();
  }
  list.addEventListener("keydown", (event) => {
    const at = pairs.findIndex(({ tab }) => tab === event.target),
      to = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: -1 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    choose((to + pairs.length) % pairs.length, true);
  });
  const node = element(
    "section",
    { "aria-label": label, class: "fuzzy-editor-group" },
    list,
    ...pairs.map(({ view }) => view),
  );
  return { node, begin: () => choose(0) };
}

function render({ model, el }) {
  const ends = [];
  const buttons = ["undo", "redo"].map((what) => element("button", { onclick: () => model.send({ do: what }) }));
  const anew = element("button", { onclick: () => model.send({ do: "anew" }) }, "Start from the cell's");
  const notice = element("span", { role: "status" });
  let timer = 0;
  function tell() {
    timer = 0;
    model.set("seen", model.get("design").revision);
    model.save_changes();
  }
  function show() {
    if (model.get("seen") !== model.get("design").revision) timer ||= setTimeout(tell, OFTEN);
    const told = model.get("notice");
    say(notice, told?.says ?? "");
    anew.hidden = !told?.anew;
    for (const [i, what] of ["undo", "redo"].entries()) {
      const name = model.get("design")[what],
        word = what === "undo" ? "Undo" : "Redo";
      say(buttons[i], name ? `${word}: ${name}` : word);
      put(buttons[i], { "aria-disabled": String(!name) });
    }
  }
  const bar = element(
    "div",
    { role: "toolbar", "aria-label": "Design", class: "fuzzy-editor-bar" },
    ...buttons,
    notice,
    anew,
  );
  const branches = element("div"),
    system = element("details", {}, element("summary", {}, "System"), branches);
  const groups = GROUPS.map(([label, tabs]) => group(label, tabs, model, ends));
  const both = element("div", { class: "fuzzy-editor-groups" }, ...groups.map(({ node }) => node));
  const root = element("div", { class: "fuzzy-editor" }, bar, system, both);
  el.append(root);
  const history = historyKeys(root);
  ends.push(
    history.end,
    keepKeys(root, (event) => {
      const wish = history.wished(event);
      if (wish) model.send({ do: wish });
      return wish !== null;
    }),
  );
  for (const event of ["change:design", "change:notice"]) model.on(event, show);
  show();
  ends.push(tree.render({ model, el: branches }));
  for (const { begin } of groups) begin(); // in the page, where they can be measured
  return () => {
    clearTimeout(timer);
    for (const event of ["change:design", "change:notice"]) model.off(event, show);
    for (const end of ends) end?.();
    root.remove();
  };
}

export default { render };
