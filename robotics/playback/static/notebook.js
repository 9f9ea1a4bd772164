// The player in a notebook: with the class that its looks stand under, its name, and its keys kept to itself.
import { keepKeys } from "../../../fuzzy/designer/static/keys.js";
import player from "./player.js";

function render({ model, el }) {
  const root = document.createElement("div");
  root.className = "fleet-player";
  root.setAttribute("role", "group");
  root.setAttribute("aria-label", `Player: ${model.get("run").title}`);
  el.append(root);
  const ends = [player.render({ model, el: root }), keepKeys(root)];
  return () => {
    for (const end of ends) end();
    root.remove();
  };
}

export default { render };
