// The designer in a notebook: the page's modules under each other, with undo and redo above them.
import rules from "./rules.js";
import surface from "./surface.js";
import terms from "./terms.js";
import tree from "./tree.js";
import viewer from "./viewer.js";

const PARTS = [
  ["System", tree],
  ["Memberships", terms],
  ["Rules", rules],
  ["Viewer", viewer],
  ["Surface", surface],
];

function render({ model, el }) {
  const root = document.createElement("div"),
    bar = document.createElement("div");
  root.className = "fuzzy-editor";
  bar.setAttribute("role", "toolbar");
  bar.setAttribute("aria-label", "Design");
  bar.className = "fuzzy-editor-bar";
  const buttons = ["undo", "redo"].map((what) => {
    const button = document.createElement("button");
    button.type = "button";
    button.addEventListener("click", () => model.send({ do: what }));
    bar.append(button);
    return button;
  });
  function show() {
    for (const [i, what] of ["undo", "redo"].entries()) {
      const name = model.get("design")[what],
        word = what === "undo" ? "Undo" : "Redo";
      buttons[i].textContent = name ? `${word}: ${name}` : word;
      buttons[i].setAttribute("aria-disabled", String(!name));
    }
  }
  model.on("change:design", show);
  show();
  root.append(bar);
  el.append(root);
  const ends = PARTS.map(([title, part]) => {
    const details = document.createElement("details"),
      summary = document.createElement("summary"),
      place = document.createElement("div");
    details.open = true;
    summary.textContent = title;
    details.append(summary, place);
    root.append(details);
    return part.render({ model, el: place });
  });
  return () => {
    model.off("change:design", show);
    for (const end of ends) end?.();
    root.remove();
  };
}

export default { render };
