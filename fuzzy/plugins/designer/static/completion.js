// The words of a rule's sentence: which ones may come next, and the terms among them in their colours.
import { color, element, put } from "./chart.js";

const MANNERS = ["not", "very", "somewhat", "extremely"];
const MOST = 12; // words that are offered
let count = 0; // ids must differ on a page

const KEYWORDS = ["if", "then", "and", "or", "is", "not", "with", "weight", "very", "somewhat", "extremely"];
// As fuzzy/rule.py: in quotation marks, doubled inside, unless it is a plain word.
const quoted = (name) =>
  /^[\p{L}_][\p{L}\p{N}_-]*$/u.test(name) && !KEYWORDS.includes(name.toLowerCase())
    ? name
    : `'${name.replaceAll("'", "''")}'`;
const bare = (word) => word.replace(/^'|'$/g, "").replaceAll("''", "'");

/** The words of a text: [word, from, to], a name between quotation marks being one. */
function wordsOf(text) {
  return [...text.matchAll(/'(?:[^']|'')*'?|[^\s']+/g)].map((found) => [
    found[0],
    found.index,
    found.index + found[0].length,
  ]);
}

/** Walk through a sentence: tell of each word what it is, {word, from, to, variable, term}; and what may come next. */
function walk(text, design) {
  let consequent = false,
    variable = null,
    last = "";
  const known = (name) => design[consequent ? "outputs" : "inputs"].find((each) => each.name === name);
  const parts = wordsOf(text).map(([word, from, to]) => {
    const name = bare(word);
    let term = -1;
    if (word === "then") [consequent, variable, last] = [true, null, "then"];
    else if (["if", "and", "or"].includes(word)) [variable, last] = [null, word];
    else if (word === "with") last = "with";
    else if (variable === null && known(name)) [variable, last] = [known(name), "variable"];
    else if (variable && (word === "is" || MANNERS.includes(word))) last = word === "is" ? "is" : "manner";
    else if (variable) {
      term = variable.terms.findIndex((each) => each.name === name);
      last = term < 0 ? last : "term";
    }
    return { from, to, term };
  });
  const names = (list) => list.map(({ name }) => ({ label: name, text: quoted(name) })),
    words = (...list) => list.map((word) => ({ label: word, text: word })),
    terms = variable ? names(variable.terms) : [];
  const next = {
    "": words("if"),
    if: names(design.inputs),
    and: names(design[consequent ? "outputs" : "inputs"]),
    or: names(design.inputs),
    then: names(design.outputs),
    variable: words("is"),
    is: consequent ? terms : [...terms, ...words(...MANNERS)],
    manner: [...terms, ...words("very")],
    term: consequent ? words("and", "with") : words("and", "or", "then"),
    with: [],
  }[last];
  return { parts, next };
}

const spelled = new WeakMap();

/** What sentences of a design are coloured by: the names of all its terms, as one text. */
export function namesOf(design) {
  if (!spelled.has(design)) {
    const names = [...design.inputs, ...design.outputs].map(({ name, terms }) => [name, terms.map((t) => t.name)]);
    spelled.set(design, JSON.stringify(names));
  }
  return spelled.get(design);
}

/** A sentence as nodes, its terms underlined in their colours. */
export function coloured(text, design) {
  const out = [];
  let at = 0;
  for (const { from, to, term } of walk(text, design).parts) {
    if (term < 0) continue;
    out.push(text.slice(at, from));
    out.push(
      element("span", { class: "fd-word", style: `text-decoration-color: ${color(term)}` }, text.slice(from, to)),
    );
    at = to;
  }
  return [...out, text.slice(at)];
}

/** What may follow the text: {begun, words}, `begun` being the part of a word that stands there already. */
export function following(text, design) {
  const [, from, to] = wordsOf(text).at(-1) ?? ["", 0, 0];
  const begun = to === text.length ? text.slice(from) : ""; // an open quotation mark reaches to the end
  const { next } = walk(text.slice(0, text.length - begun.length), design);
  const start = bare(begun).toLowerCase();
  const words = next.filter(({ label }) => label.toLowerCase().startsWith(start) && label !== bare(begun));
  return { begun, words: words.slice(0, MOST) };
}

/**
 * Offer words below a text field while one types at the end of a word: {node}. Arrows choose, Tab or Enter takes, Escape closes.
 */
export function completing(field, design, typed) {
  const id = `fd-offers-${++count}`;
  const node = element("ul", { class: "fd-offers", role: "listbox", id, "aria-label": "Words that fit", hidden: true });
  let offers = [],
    begun = "",
    at = -1;
  put(field, { "aria-autocomplete": "list", "aria-controls": id });

  function close() {
    node.hidden = true;
    offers = [];
    at = -1;
    put(field, { "aria-activedescendant": null });
  }
  function offer() {
    const to = field.selectionStart;
    if (to !== field.selectionEnd || /^\S/.test(field.value.slice(to))) return close();
    const found = following(field.value.slice(0, to), design());
    [begun, offers, at] = [found.begun, found.words, -1];
    node.hidden = offers.length === 0;
    node.replaceChildren(
      ...offers.map(({ label }, k) =>
        element(
          "li",
          { role: "option", id: `${id}-${k}`, onpointerdown: (event) => (event.preventDefault(), take(k)) },
          label,
        ),
      ),
    );
  }
  function choose(k) {
    at = (k + offers.length) % offers.length;
    [...node.children].forEach((each, n) => put(each, { "aria-selected": String(n === at) }));
    put(field, { "aria-activedescendant": `${id}-${at}` });
  }
  function take(k) {
    const to = field.selectionStart,
      before = `${field.value.slice(0, to - begun.length)}${offers[k].text} `;
    field.value = before + field.value.slice(to); // a blank too many within it goes when the sentence is taken
    field.setSelectionRange(before.length, before.length);
    typed();
    offer();
  }
  field.addEventListener("input", offer);
  field.addEventListener("blur", close);
  // Before the field's own keys: what is taken here is no word of theirs.
  field.addEventListener(
    "keydown",
    (event) => {
      if (node.hidden || event.ctrlKey || event.metaKey || event.altKey) return;
      const taken = event.key === "Tab" && begun !== "" && !event.shiftKey ? Math.max(at, 0) : at;
      if (event.key === "ArrowDown") choose(at + 1);
      else if (event.key === "ArrowUp") choose(at - 1);
      else if (["Tab", "Enter"].includes(event.key) && taken >= 0) take(taken);
      else if (event.key === "Escape") close();
      else return;
      event.preventDefault();
      event.stopImmediatePropagation();
    },
    { capture: true },
  );
  return { node };
}
