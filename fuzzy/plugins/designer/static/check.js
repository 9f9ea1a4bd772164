// What the rule base is checked for, as "fuzzy check" lists it: each finding leads to its rules or terms. Model:
// "findings", null until they are known.
import { element, endOf, say, watch } from "./chart.js";

const SIGNS = { error: "✕", warning: "▲", note: "i" };
const WORDS = { error: "error", warning: "warning", note: "note" };
const MOST = 200; // findings that are listed
const LINKS = 12; // of one finding

const counted = (number, word) => `${number} ${word}${number === 1 ? "" : "s"}`;

export function render({ model, el }) {
  const root = element("div", { class: "fd fd-check-list" }),
    told = element("p", { class: "fd-note", role: "status" }),
    list = element("ol", { class: "fd-list", "aria-label": "Findings" });
  root.append(told, list);
  el.append(root);

  const link = ({ text, ...place }) =>
    element(
      "button",
      {
        class: "fd-button fd-link",
        onclick: () =>
          model.send(
            place.rule === undefined ? { look: "select", ...place, show: true } : { look: "rule", key: place.rule },
          ),
      },
      text,
    );

  function paint() {
    const findings = model.get("findings");
    if (findings === null) {
      say(told, "The rules are being checked …");
      return;
    }
    const numbers = Object.keys(WORDS).map((severity) => findings.filter((each) => each.severity === severity).length);
    const parts = Object.values(WORDS).flatMap((word, n) => (numbers[n] ? [counted(numbers[n], word)] : []));
    say(told, findings.length ? `${parts.join(", ")}; the gravest come first.` : "Nothing is wrong with the rules.");
    list.replaceChildren(
      ...findings
        .slice(0, MOST)
        .map(({ severity, sentence, places }) =>
          element(
            "li",
            { class: `fd-finding fd-finding-${severity}` },
            element("span", { class: "fd-sign", "aria-hidden": "true" }, SIGNS[severity]),
            element(
              "div",
              {},
              element("p", {}, `${WORDS[severity]}: ${sentence}`),
              element("div", { class: "fd-links" }, ...places.slice(0, LINKS).map(link)),
            ),
          ),
        ),
    );
    if (findings.length > MOST) list.append(element("li", {}, `and ${findings.length - MOST} more`));
  }

  const end = watch(model, ["findings"], paint);
  paint();
  return endOf(root, end);
}

export default { render };
