// The hands on the designer's modules: dragging, keys, fields, and what is shown until Python has answered.
import { element, put, rounded, say, typed } from "./chart.js";

/**
 * At most one call an animation frame, with the latest arguments; flush() makes the waiting one now. With `atOnce` the
 * first one waits for no frame.
 */
export function framed(f, atOnce = false) {
  let request = 0,
    latest = null;
  const call = () => {
    if (latest === null) return;
    const waiting = latest;
    latest = null;
    f(...waiting);
  };
  const now = () => {
    cancelAnimationFrame(request);
    request = 0;
    call();
  };
  const later = (...given) => {
    latest = given;
    if (request) return;
    request = requestAnimationFrame(now);
    if (atOnce) call();
  };
  later.flush = now;
  later.cancel = () => {
    cancelAnimationFrame(request);
    request = 0;
    latest = null;
  };
  return later;
}

/** A name for one gesture: all its messages are one edit in the history. */
export const gesture = () => `g${Date.now().toString(36)}-${Math.random().toString(36).slice(2, 10)}`;

/**
 * What is under the hand, until Python has answered: a value that is shown at once, sent at most once a frame, and
 * not overwritten by answers to what was sent earlier. `send` takes a message.
 */
export function hold(send) {
  let key = null,
    value = null,
    sent = [],
    down = false,
    timer = 0;
  const post = framed((message, text) => {
    sent.push(text);
    send(message);
  }, true);
  const drop = () => {
    post.cancel();
    clearTimeout(timer);
    key = null;
    sent = [];
    down = false;
  };
  return {
    drop,
    value: (name, incoming) => (key === name ? value : incoming),
    take(name, now, message, before, pressed) {
      if (key !== name) {
        post.flush();
        drop();
        key = name;
        sent = [JSON.stringify(before)];
      }
      clearTimeout(timer);
      value = now;
      down = pressed;
      post(message, JSON.stringify(now));
      if (!down) timer = setTimeout(drop, 3000); // nobody answers: what the model says stands
    },
    release() {
      if (key === null) return;
      post.flush();
      down = false;
      timer = setTimeout(drop, 3000);
    },
    settle(name, incoming) {
      if (key !== name || down) return;
      const at = sent.lastIndexOf(JSON.stringify(incoming));
      if (at < 0 || at === sent.length - 1) drop();
    },
  };
}

/** Drag with the pointer: start(event) -> false to refuse; move(event); end(event, cancelled). */
export function drag(node, { start, move, end }) {
  let held = null;
  const stop = (event, cancelled) => {
    if (held === null) return;
    held = null;
    document.removeEventListener("keydown", escape, true);
    end?.(event, cancelled);
  };
  const escape = (event) => {
    if (event.key !== "Escape") return;
    event.stopPropagation();
    stop(event, true);
  };
  node.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || held !== null || start(event) === false) return;
    held = event.pointerId;
    node.setPointerCapture(held);
    event.preventDefault(); // no selection of text on the way
    event.stopPropagation();
    document.addEventListener("keydown", escape, true);
  });
  node.addEventListener("pointermove", (event) => {
    if (event.pointerId === held) move(event);
  });
  node.addEventListener("pointerup", (event) => {
    if (event.pointerId === held) stop(event, false);
  });
  node.addEventListener("pointercancel", (event) => {
    if (event.pointerId === held) stop(event, true);
  });
  node.addEventListener("lostpointercapture", (event) => {
    if (event.pointerId === held) stop(event, false);
  });
}

/** What an arrow key asks of a slider at `value` in [low, high]: 1/200 of the range, ten times that with Shift. */
export function stepped(event, value, low, high) {
  const by = ((high - low) / 200) * (event.shiftKey ? 10 : 1);
  const to = {
    ArrowRight: value + by,
    ArrowUp: value + by,
    ArrowLeft: value - by,
    ArrowDown: value - by,
    PageUp: value + 10 * by,
    PageDown: value - 10 * by,
    Home: low,
    End: high,
  }[event.key];
  if (to === undefined || event.ctrlKey || event.metaKey) return null;
  event.preventDefault();
  event.stopPropagation();
  return to;
}

/** A gesture's name for keys: the same while one presses on, another after a second's rest. */
export function pressing() {
  let name = null,
    last = -Infinity;
  return (event) => {
    if (name === null || event.timeStamp - last > 1000) name = gesture();
    last = event.timeStamp;
    return name;
  };
}

// Fields -------------------------------------------------------------------------------------------------------

const FIELDS = new WeakMap(); // by their inputs

/** Tell the field below `root` that asked for what was refused; false where none of these did, or it is gone. */
export function refuse(root, problem) {
  const input = problem?.field ? root.querySelector(`[data-field="${CSS.escape(problem.field)}"]`) : null;
  FIELDS.get(input)?.refuse(problem.message);
  return input !== null;
}

/** What fields share: a name for their messages, the sentence below them, and what was typed until it is mended. */
function fieldOf(input, text) {
  const id = gesture(),
    told = element("span", { class: "fd-refused", role: "alert", id: `fd-${id}`, hidden: true });
  const node = element("label", { class: "fd-field" }, text && element("span", { "aria-hidden": "true" }, text), input);
  put(input, { "data-field": id, autocomplete: "off", spellcheck: "false" });
  node.append(told);
  const own = {
    id,
    node,
    input,
    asked: "", // what was typed when the last edit was asked for
    wrong: false,
    refuse(message) {
      own.wrong = true;
      input.value = own.asked;
      say(told, message);
      put(told, { hidden: false, style: null });
      put(input, { "aria-invalid": "true", "aria-describedby": told.id });
      const beyond = told.getBoundingClientRect().right + 8 - document.documentElement.clientWidth;
      if (beyond > 0) put(told, { style: `left: ${-beyond}px` });
    },
    mend() {
      own.wrong = false;
      say(told, "");
      put(told, { hidden: true });
      put(input, { "aria-invalid": null, "aria-describedby": null });
    },
  };
  FIELDS.set(input, own);
  return own;
}

/**
 * A field for a number that tells `react(value, event, id)` of each new one; arrows step as a slider's do. `show(value,
 * owner, span)`: owner names what the value is of, for a field that serves several; span is the width of its range.
 */
export function numberField(label, ends, react, text = label) {
  const input = element("input", {
    type: "text",
    inputmode: "decimal",
    role: "spinbutton",
    "aria-label": label,
    class: "fd-number",
  });
  const field = fieldOf(input, text);
  const read = () => Number(input.value.trim().replace("−", "-").replace(",", ".") || "x");
  let shown = NaN,
    owner = null,
    width = 0,
    dirty = false;
  const write = () => {
    const written = typed(shown, width);
    if (input.value !== written) input.value = written;
  };
  const show = (value, of = null, span = 0) => {
    if (!Object.is(value, shown) || of !== owner) field.mend();
    [shown, owner, width] = [value, of, span];
    put(input, { "aria-valuenow": Number.isFinite(value) ? value : null });
    if (!field.wrong && !(dirty && document.activeElement === input)) write();
  };
  const take = (event) => {
    if (!dirty) return;
    dirty = false;
    field.asked = input.value;
    const value = read();
    field.mend();
    if (Number.isFinite(value)) react(value, event, field.id);
    else field.refuse(input.value.trim() ? `“${input.value.trim()}” is not a number` : "a number is missing");
  };
  input.addEventListener("input", () => {
    dirty = true;
  });
  input.addEventListener("change", take);
  input.addEventListener("keydown", (event) => {
    if (event.key === "Enter") take(event);
    if (event.key === "Escape") {
      dirty = false;
      field.mend();
      write();
    }
    if (!["ArrowUp", "ArrowDown", "PageUp", "PageDown"].includes(event.key)) return;
    const [low, high] = ends(),
      to = stepped(event, (dirty || field.wrong) && Number.isFinite(read()) ? read() : shown, low, high);
    dirty = false;
    field.mend();
    field.asked = typed(rounded(to, low, high));
    react(rounded(to, low, high), event, field.id);
  });
  return Object.assign(field, { show });
}

/** A field for a word or a name; `react(text, id)` when it is left or Enter is pressed. `show` as numberField's. */
export function wordField(label, react, text = label) {
  const input = element("input", { type: "text", "aria-label": label, class: "fd-word" });
  const field = fieldOf(input, text);
  let shown = "",
    owner = null,
    dirty = false;
  const show = (value, of = null) => {
    if (value !== shown || of !== owner) field.mend();
    [shown, owner] = [value, of];
    if (!field.wrong && !(dirty && document.activeElement === input) && input.value !== value) input.value = value;
  };
  input.addEventListener("input", () => {
    dirty = true;
  });
  input.addEventListener("change", () => {
    if (!dirty) return;
    dirty = false;
    field.asked = input.value;
    field.mend();
    if (input.value.trim() === shown) input.value = shown;
    else react(input.value.trim(), field.id);
  });
  input.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    dirty = false;
    field.mend();
    input.value = shown;
  });
  return Object.assign(field, { show });
}

/** The sentence of the last edit that was refused, in a live region; where a field asked for it, it stands there. */
export function problemLine(model, root) {
  const node = element("p", { class: "fd-problem", role: "status", "aria-live": "polite" });
  const show = () => {
    const problem = model.get("problem");
    say(node, problem && !refuse(root, problem) ? problem.message : "");
  };
  show();
  return { node, show };
}
