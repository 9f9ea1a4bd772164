// The player in a notebook: with the class that its looks stand under, its name, and its keys kept to itself.
// The time that it shows is the widget's `time`, both ways.
import { keepKeys } from "../../../../fuzzy/static/keys.js";
import player from "./player.js";

const OFTEN = 200; // ms between two times that are told to Python

/** The model as the player takes it, which tells Python the time that is shown. */
function timed(model) {
  const guarded = new Map();
  let telling = false,
    timer = 0;
  const save = () => {
    timer = 0;
    model.save_changes();
  };
  const ticked = (t) => {
    if (t === model.get("time")) return;
    telling = true;
    model.set("time", t);
    telling = false;
    timer ||= setTimeout(save, OFTEN);
  };
  const end = () => {
    if (timer) clearTimeout(timer);
  };
  const own = {
    get: (name) => (name === "ticked" ? ticked : model.get(name)),
    on(event, listener) {
      guarded.set(listener, () => telling || listener());
      model.on(event, guarded.get(listener));
    },
    off: (event, listener) => model.off(event, guarded.get(listener)),
  };
  return { own, end };
}

function render({ model, el }) {
  const root = document.createElement("div");
  root.className = "fleet-player";
  root.setAttribute("role", "group");
  root.setAttribute("aria-label", `Player: ${model.get("run").title}`);
  el.append(root);
  const { own, end: still } = timed(model);
  const ends = [player.render({ model: own, el: root }), keepKeys(root), still];
  return () => {
    for (const end of ends) end();
    root.remove();
  };
}

export default { render };
