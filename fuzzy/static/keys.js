// Keys that hold in a whole widget or page: undo and redo, and in a notebook those that the notebook must not hear.

/** Which of undo and redo a key press in `scope` asks for: {wished(event) -> "undo", "redo" or null, end()}. */
export function historyKeys(scope) {
  let edited = null; // the text field in which something was typed that is not taken over yet: its undo is its own
  const onInput = (event) => (edited = event.target),
    onTaken = () => (edited = null);
  scope.addEventListener("input", onInput);
  for (const kind of ["change", "focusout"]) scope.addEventListener(kind, onTaken);
  return {
    wished(event) {
      if (!(event.ctrlKey || event.metaKey) || event.altKey) return null;
      const typing = edited === event.target && event.target.matches?.("input:not([type=range]), textarea");
      const letter = event.key.toLowerCase();
      if (typing || !"zy".includes(letter)) return null;
      return letter === "y" || event.shiftKey ? "redo" : "undo";
    },
    end() {
      scope.removeEventListener("input", onInput);
      for (const kind of ["change", "focusout"]) scope.removeEventListener(kind, onTaken);
    },
  };
}

const APART = "data-lm-suppress-shortcuts"; // JupyterLab looks for no shortcut from an element that has it upwards
const TEXT = "input:not([type=range]):not([type=checkbox]), textarea";

/**
 * Keep keys that are pressed within `root` from the notebook round it, where "d d" deletes the cell. Chords with Ctrl
 * or ⌘ reach it still, as if pressed beside the widget, unless react(event) has taken them. Gives what ends this.
 */
export function keepKeys(root, react = () => false) {
  root.setAttribute(APART, "true");
  // JupyterLab's orders name what has the focus, so that the mark must stand there, not only further up.
  const mark = (event) => event.target.setAttribute(APART, "true"),
    unmark = (event) => event.target !== root && event.target.removeAttribute(APART);
  const onKey = (event) => {
    event.stopPropagation();
    if (event.defaultPrevented) return;
    if (react(event)) return event.preventDefault();
    const editing = event.target.matches?.(TEXT) && "acvxyz".includes(event.key.toLowerCase());
    if (!(event.ctrlKey || event.metaKey) || editing) return;
    if (!root.parentNode.dispatchEvent(new KeyboardEvent(event.type, event))) event.preventDefault();
  };
  const hands = { focusin: mark, focusout: unmark, keydown: onKey };
  for (const [kind, hand] of Object.entries(hands)) root.addEventListener(kind, hand);
  return () => {
    for (const [kind, hand] of Object.entries(hands)) root.removeEventListener(kind, hand);
  };
}
