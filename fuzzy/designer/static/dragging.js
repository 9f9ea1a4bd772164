// The hands on the designer's modules: dragging, keys, fields, and what is shown until Python has answered.
import { element, put, rounded, say } from "./chart.js";

/** At most one call an animation frame, with the latest arguments; flush() makes the waiting one now. */
export function framed(f) {
  let request = 0,
    latest = null;
  const now = () => {
    cancelAnimationFrame(request);
    request = 0;
    if (latest === null) return;
    const waiting = latest;
    latest = null;
    f(...waiting);
  };
  const later = (...given) => {
    latest = given;
    if (!request) request = requestAnimationFrame(now);
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
  });
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

/** A field for a number that tells `react(value, event)` of each new one; arrows step as a slider's do. */
export function numberField(label, ends, react, text = label) {
  const input = element("input", {
    type: "text",
    inputmode: "decimal",
    role: "spinbutton",
    "aria-label": label,
    class: "fd-number",
    autocomplete: "off",
    spellcheck: "false",
  });
  const read = () => Number(input.value.trim().replace("−", "-").replace(",", ".") || "x");
  let shown = NaN,
    dirty = false;
  const show = (value) => {
    shown = value;
    if (dirty && document.activeElement === input) return;
    const written = Number.isFinite(value) ? String(Number(value.toPrecision(6))) : "";
    if (input.value !== written) input.value = written;
    put(input, { "aria-valuenow": Number.isFinite(value) ? value : null, "aria-invalid": null });
  };
  const take = (event) => {
    if (!dirty) return;
    dirty = false;
    const value = read();
    if (Number.isFinite(value)) react(value, event);
    else put(input, { "aria-invalid": "true" });
  };
  input.addEventListener("input", () => {
    dirty = true;
  });
  input.addEventListener("change", take);
  input.addEventListener("keydown", (event) => {
    if (event.key === "Enter") take(event);
    if (event.key === "Escape") {
      dirty = false;
      show(shown);
    }
    if (!["ArrowUp", "ArrowDown", "PageUp", "PageDown"].includes(event.key)) return;
    const [low, high] = ends(),
      to = stepped(event, dirty && Number.isFinite(read()) ? read() : shown, low, high);
    dirty = false;
    react(rounded(to, low, high), event);
  });
  return {
    node: element("label", { class: "fd-field" }, element("span", { "aria-hidden": "true" }, text), input),
    input,
    show,
  };
}

/** A field for a word or a name; `react(text)` when it is left or Enter is pressed. */
export function wordField(label, react, text = label) {
  const input = element("input", {
    type: "text",
    "aria-label": label,
    class: "fd-word",
    autocomplete: "off",
    spellcheck: "false",
  });
  let shown = "";
  const show = (value) => {
    shown = value;
    if (document.activeElement !== input || input.value === value || input.dataset.left) input.value = value;
    delete input.dataset.left;
  };
  input.addEventListener("change", () => {
    input.dataset.left = "yes";
    if (input.value !== shown) react(input.value);
  });
  input.addEventListener("keydown", (event) => {
    if (event.key === "Escape") input.value = shown;
  });
  const head = text ? element("span", { "aria-hidden": "true" }, text) : null;
  return { node: element("label", { class: "fd-field" }, head, input), input, show };
}

/** The sentence of the last edit that was refused, in a live region. */
export function problemLine(model) {
  const node = element("p", { class: "fd-problem", role: "status", "aria-live": "polite" });
  const show = () => say(node, model.get("problem")?.message ?? "");
  show();
  return { node, show };
}
