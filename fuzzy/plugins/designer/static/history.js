// The drawer History: snapshots, each with a small picture, and the edits that can be undone or made again. Model:
// "history" { edits: [{ number, name, when, done }], forgotten }, "snapshots" { kept: [{ key, name, when, picture,
// summary }], problems, most, longest } or null until they are read, "compared" (a key) and "removed" ({ key, name }).
import { button, element, endOf, line, put, say, shape, watch } from "./chart.js";
import { tint } from "./field.js";

const WIDE = 92,
  TALL = 69; // px of a picture
const SHADES = 12;

const two = (number) => String(number).padStart(2, "0");
const clock = (date) => [date.getHours(), date.getMinutes(), date.getSeconds()].map(two).join(":");
const day = (date) => [date.getFullYear(), two(date.getMonth() + 1), two(date.getDate())].join("-");
const today = (date) => day(date) === day(new Date());

/** The time [ms] as one reads it: with the day where it is another one. */
function moment(when) {
  const date = new Date(when);
  return element(
    "time",
    { datetime: date.toISOString(), class: "fd-when" },
    today(date) ? clock(date) : `${day(date)} ${clock(date)}`,
  );
}

/** A surface as a few paths, one for each shade; over one input a curve. */
function picture({ z, shows }) {
  const known = z.flat().filter(Number.isFinite),
    low = Math.min(...known),
    span = Math.max(...known) - low || 1;
  const rows = z.length,
    columns = z[0].length;
  const drawing = shape("svg", {
    width: WIDE,
    height: TALL,
    viewBox: rows === 1 ? "-4 -4 108 108" : `0 0 ${columns} ${rows}`,
    preserveAspectRatio: "none",
    role: "img",
    "aria-label": shows,
    class: "fd-shot-picture",
  });
  if (rows === 1) {
    const xs = z[0].map((_, k) => (100 * k) / (columns - 1)),
      ys = z[0].map((value) => (value === null ? NaN : 100 - (100 * (value - low)) / span));
    drawing.append(
      shape("path", { d: line(xs, ys), fill: "none", stroke: "var(--ff-c0)", "vector-effect": "non-scaling-stroke" }),
    );
    return drawing;
  }
  const paths = Array.from({ length: SHADES }, () => "");
  const shade = (value) => (value === null ? -1 : Math.min(SHADES - 1, Math.floor((SHADES * (value - low)) / span)));
  for (const [r, row] of z.entries())
    for (let from = 0, to; from < columns; from = to) {
      const one = shade(row[from]);
      for (to = from + 1; to < columns && shade(row[to]) === one;) to++;
      if (one >= 0) paths[one] += `M${from} ${rows - r}h${to - from}v-1H${from}z`;
    }
  for (const [k, d] of paths.entries())
    if (d) drawing.append(shape("path", { d, fill: `rgb(${tint("viridis", k / (SHADES - 1))})` }));
  return drawing;
}

export function render({ model, el }) {
  const send = (content) => model.send(content);
  const name = element("input", { type: "text", autocomplete: "off", placeholder: "time and last edit" });
  const form = element(
    "form",
    {
      class: "fd-shot-form",
      onsubmit: (event) => {
        event.preventDefault();
        send({ snapshot: "take", name: name.value });
        name.value = "";
      },
    },
    element("label", { class: "fd-field" }, element("span", {}, "Name of a snapshot"), name),
    element("button", { type: "submit", class: "fd-button" }, "Take a snapshot"),
  );
  const limits = element("p", { class: "fd-note" }),
    damaged = element("ul", { class: "fd-problem fd-shot-damaged" }),
    removed = element("p", { class: "fd-shot-removed", role: "status" }),
    shots = element("ul", { class: "fd-shots", "aria-label": "Snapshots" }),
    edits = element("ol", { class: "fd-edits", "aria-label": "Edits, the newest first" });
  const root = element(
    "div",
    { class: "fd fd-history" },
    element("h2", {}, "Snapshots"),
    form,
    limits,
    damaged,
    removed,
    shots,
    element("h2", {}, "Edits"),
    element("p", { class: "fd-note" }, "Go to any of them: nothing is lost until the next edit."),
    edits,
  );
  el.append(root);

  // Snapshots ------------------------------------------------------------------------------------------------
  let renamed = null; // the key of the one whose name is being typed
  let focus = null; // [key, action] of the button that gets the focus when the list has been made anew

  function nameOf({ key, name: present }) {
    if (renamed !== key) return element("p", { class: "fd-shot-name" }, present);
    const field = element("input", {
      type: "text",
      value: present,
      required: true,
      maxlength: model.get("snapshots").longest,
      "aria-label": `name of the snapshot ${present}`,
      class: "fd-shot-field",
    });
    let over = false; // Escape gives the focus away, which is no second answer
    const end = (accept, stay = true) => {
      if (over) return;
      over = true;
      const text = field.value.trim();
      renamed = null;
      if (stay) focus = [key, "rename"];
      if (accept && text && text !== present) send({ snapshot: "rename", key, name: text });
      showShots();
    };
    field.addEventListener("keydown", (event) => {
      if (event.key === "Enter") (event.preventDefault(), end(true));
      else if (event.key === "Escape") (event.stopPropagation(), end(false));
    });
    field.addEventListener("blur", () => end(true, false));
    return field;
  }

  function shot(one) {
    const { key, name: present } = one,
      compared = model.get("compared") === key;
    const act = (word, action, react, pressed = null) =>
      element(
        "button",
        {
          class: "fd-button",
          "data-action": action,
          "aria-label": `${word} ${present}`,
          "aria-pressed": pressed === null ? null : String(pressed),
          onclick: react,
        },
        word,
      );
    return element(
      "li",
      { class: "fd-shot", "data-key": key },
      one.picture
        ? picture(one.picture)
        : element("span", { class: "fd-shot-picture", role: "img", "aria-label": "no picture" }),
      element(
        "div",
        { class: "fd-shot-words" },
        nameOf(one),
        element(
          "p",
          { class: "fd-note" },
          moment(one.when),
          ` · ${one.summary}${one.picture ? ` · ${one.picture.shows}` : ""}`,
        ),
        element(
          "div",
          { class: "fd-links" },
          act("Open", "open", () => send({ snapshot: "open", key })),
          act("Compare", "compare", () => send({ snapshot: "compare", key: compared ? null : key }), compared),
          act("Rename", "rename", () => {
            renamed = key;
            showShots();
            const field = shots.querySelector(".fd-shot-field");
            field?.focus();
            field?.select();
          }),
          act("Download", "download", () => send({ snapshot: "download", key })),
          act("Remove", "remove", () => {
            const keys = model.get("snapshots").kept.map((each) => each.key),
              at = keys.indexOf(key);
            focus = [keys[at + 1] ?? keys[at - 1] ?? null, "remove"];
            send({ snapshot: "remove", key });
          }),
        ),
      ),
    );
  }

  function showShots() {
    const all = model.get("snapshots"),
      gone = model.get("removed");
    if (all === null) return say(limits, "The snapshots are being read …");
    put(name, { maxlength: all.longest });
    say(
      limits,
      `A snapshot keeps the design as it is, beside the file in .fuzzy-design; at most ${all.most} are kept of a file` +
        (all.kept.length ? `, ${all.kept.length} now.` : "."),
    );
    damaged.replaceChildren(...all.problems.map((sentence) => element("li", {}, sentence)));
    damaged.hidden = all.problems.length === 0;
    if (gone === null) removed.replaceChildren();
    else if (removed.dataset.key !== gone.key || !removed.firstChild)
      removed.replaceChildren(
        `The snapshot “${gone.name}” is removed. `,
        button(null, "Undo", () => send({ snapshot: "back", key: gone.key }), "Undo"),
      );
    removed.dataset.key = gone?.key ?? "";
    // What is being typed stays as it is.
    if (renamed !== null && shots.querySelector(".fd-shot-field")) return;
    const had = shots.contains(document.activeElement)
      ? [document.activeElement.closest("[data-key]").dataset.key, document.activeElement.dataset.action]
      : null;
    shots.replaceChildren(...all.kept.map(shot));
    const wanted = focus ?? had;
    focus = null;
    if (wanted === null) return;
    const target = wanted[0] && shots.querySelector(`[data-key="${wanted[0]}"] [data-action="${wanted[1]}"]`);
    (target || name).focus();
  }

  // Edits ----------------------------------------------------------------------------------------------------
  let at = 0; // the entry that Tab reaches

  function showEdits() {
    const { edits: all, forgotten } = model.get("history"),
      first = forgotten ? "before these: older edits cannot be undone" : "as opened";
    const entries = [{ number: null, name: first, when: null, done: true }, ...all].reverse(),
      present = entries.findIndex(({ done }) => done);
    const had = edits.contains(document.activeElement);
    // Rows stay, so that the focus does.
    while (edits.children.length > entries.length) edits.lastChild.remove();
    while (edits.children.length < entries.length)
      edits.append(element("li", {}, element("button", { class: "fd-edit" })));
    for (const [k, { number, name: words, when, done }] of entries.entries()) {
      const node = edits.children[k].firstChild,
        key = JSON.stringify([number, words, when]);
      put(node, { "aria-current": k === present ? "step" : null, "data-done": done ? "yes" : "no" });
      if (node.dataset.shown === key) continue;
      node.dataset.shown = key;
      node.onclick = () => {
        at = k;
        send({ do: "go", to: number });
      };
      node.replaceChildren(when === null ? element("span", { class: "fd-when" }) : moment(when), words);
    }
    if (!had) at = present;
    reach(Math.min(at, entries.length - 1), had);
  }
  function reach(k, take) {
    at = k;
    for (const [n, { firstChild }] of [...edits.children].entries()) put(firstChild, { tabindex: n === k ? 0 : -1 });
    if (take) edits.children[k].firstChild.focus();
  }
  edits.addEventListener("keydown", (event) => {
    const last = edits.children.length - 1,
      to = { ArrowDown: Math.min(last, at + 1), ArrowUp: Math.max(0, at - 1), Home: 0, End: last }[event.key];
    if (to === undefined || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    reach(to, true);
  });
  edits.addEventListener("focusin", (event) => {
    const k = [...edits.children].findIndex(({ firstChild }) => firstChild === event.target);
    if (k >= 0 && k !== at) reach(k, false);
  });

  const ends = [watch(model, ["snapshots", "compared", "removed"], showShots), watch(model, ["history"], showEdits)];
  showShots();
  showEdits();
  return endOf(root, ...ends);
}

export default { render };
