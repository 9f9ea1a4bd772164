// The time that one looks at: questions about it to Python, one at a time, and a clock that lets it pass.

const LATE = 3000; // ms after which an answer is waited for no longer
const FRAME = 500; // ms between two pictures for whoever asked for less motion

/** Ask about moments: while one is answered, only the latest of those that follow is kept, with any rule asked for. */
export function asker(send) {
  let count = 0,
    sent = -Infinity,
    waiting = null;
  function ask(moment) {
    waiting = { ...moment, rule: moment.rule ?? waiting?.rule ?? null };
    if (performance.now() - sent > LATE) next();
  }
  function next() {
    sent = -Infinity;
    if (waiting === null) return;
    const moment = waiting;
    waiting = null;
    sent = performance.now();
    send({ ...moment, count: ++count });
  }
  return { ask, answered: next };
}

/** A clock: `step(seconds)` is called for every frame while it is on, until it says that the end is reached. */
export function clockwork(step, changed) {
  const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
  let request = 0,
    before = null;
  const clock = {
    on: false,
    toggle(on = !clock.on) {
      cancelAnimationFrame(request);
      clock.on = on;
      before = null;
      if (on) request = requestAnimationFrame(advance);
      changed(on);
    },
  };
  function advance(now) {
    before ??= now;
    // A page that was hidden does not jump.
    const past = Math.min(now - before, calm.matches ? FRAME + 100 : 250);
    let goes = true;
    if (!calm.matches || past >= FRAME) {
      goes = step(past / 1000);
      before = now;
    }
    if (goes) request = requestAnimationFrame(advance);
    else clock.toggle(false);
  }
  return clock;
}
