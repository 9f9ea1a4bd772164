// A run as robotics/show/playback/player.py packed it: numbers, places between samples, and what the chart can show.

function bytes(text) {
  if (text instanceof ArrayBuffer) return text;
  const raw = atob(text),
    out = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
  return out.buffer;
}

function numbers(packed) {
  const raw = new Int16Array(bytes(packed.data));
  const out = new Float32Array(raw.length);
  for (let k = 0; k < raw.length; k++) out[k] = raw[k] === -32768 ? NaN : packed.offset + packed.scale * raw[k];
  return out;
}

export function unpack(run) {
  const count = run.robots,
    time = new Float32Array(bytes(run.time)),
    frames = time.length;
  const channels = Object.fromEntries(Object.entries(run.channels).map(([name, packed]) => [name, numbers(packed)]));
  const bits = run.hears === null ? null : new Uint8Array(bytes(run.hears));
  const hears = (i, j) => bits !== null && ((bits[(i * count + j) >> 3] >> ((i * count + j) & 7)) & 1) === 1;
  const links = [];
  if (bits) for (let i = 0; i < count; i++) for (let j = 0; j < count; j++) if (hears(i, j)) links.push([i, j]);
  const spans = new Float32Array(bytes(run.stale));
  const stale = (t) => {
    const ages = new Map();
    for (let k = 0; k < spans.length; k += 5) {
      if (spans[k + 2] <= t && t < spans[k + 3])
        ages.set(spans[k] * count + spans[k + 1], spans[k + 4] + t - spans[k + 2]);
    }
    return ages;
  };
  const locate = (t) => {
    let low = 0,
      high = frames - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (time[middle] <= t) low = middle;
      else high = middle;
    }
    return { k: low, share: Math.min(1, Math.max(0, (t - time[low]) / (time[high] - time[low]))) };
  };
  const at = (name, i, { k, share }) => {
    const values = channels[name];
    if (!values) return NaN;
    const a = values[i * frames + k],
      b = values[i * frames + Math.min(k + 1, frames - 1)];
    return a + share * (b - a);
  };
  const modes = run.modes ? { ...run.modes, codes: new Int8Array(bytes(run.modes.codes)) } : null;
  const mode = (i, { k, share }) =>
    modes ? modes.codes[i * frames + (share >= 1 ? Math.min(k + 1, frames - 1) : k)] : 0;
  const rules = run.rules && {
    ...run.rules,
    numbers: new Uint16Array(bytes(run.rules.numbers)),
    strengths: new Uint8Array(bytes(run.rules.strengths)),
    shares: new Uint8Array(bytes(run.rules.shares)),
    values: run.rules.values?.map(numbers),
  };
  const sonar = run.sonar ? { ...run.sonar, readings: numbers(run.sonar.readings) } : null;
  let obstacles = null;
  if (run.obstacles) {
    const places = Object.fromEntries(["x", "y", "turn"].map((name) => [name, numbers(run.obstacles[name])]));
    obstacles = { bodies: run.obstacles.bodies, ...places, moving: places.x.length > run.obstacles.bodies.length };
  }
  // Where a body is: x, y [m] and its turn [rad]
  const body = (b, { k, share }) => {
    const n = obstacles.moving ? frames : 1,
      from = b * n + (n > 1 ? k : 0),
      to = b * n + Math.min(n - 1, n > 1 ? k + 1 : 0);
    return ["x", "y", "turn"].map(
      (name) => obstacles[name][from] + share * (obstacles[name][to] - obstacles[name][from]),
    );
  };
  const fault = (i, t) => run.faults.find(([robot, , start, end]) => robot === i && start <= t && t < end)?.[1];
  const stopped = (i, t) => run.stops[i] !== null && t >= run.stops[i];
  const ends = { start: time[0], end: time[frames - 1] };
  return {
    ...run,
    ...ends,
    count,
    time,
    frames,
    channels,
    links,
    stale,
    locate,
    at,
    fault,
    stopped,
    modes,
    mode,
    rules,
    sonar,
    obstacles,
    body,
    shortest: Math.min(...run.sizes.map(([length]) => length)),
  };
}

// What the chart can show: a line a robot, or a line a pair
export function series(data, kind) {
  const { count, frames, channels } = data;
  const over = (f) => Float32Array.from({ length: frames }, (_, k) => f(k));
  const rows = (f) => Array.from({ length: count }, (_, i) => ({ who: [i], name: "", values: over((k) => f(i, k)) }));
  const s = (i, k) => channels.progress[i * frames + k];
  if (kind === "progress") return rows(s);
  if (kind === "speed") return rows((i, k) => channels.v[i * frames + k]);
  const off = (c, n) => channels[c][n] - channels[`${c}_target`][n];
  if (kind === "distance") return rows((i, k) => Math.hypot(off("x", i * frames + k), off("y", i * frames + k)));
  if (count > 4) {
    const middle = over((k) => {
      const known = Array.from({ length: count }, (_, i) => s(i, k))
        .filter(Number.isFinite)
        .sort((a, b) => a - b);
      return (known[(known.length - 1) >> 1] + known[known.length >> 1]) / 2;
    });
    return rows((i, k) => s(i, k) - middle[k]);
  }
  const pairs = [];
  for (let i = 0; i < count; i++) {
    for (let j = i + 1; j < count; j++) {
      pairs.push({ who: [i, j], name: `s${i + 1} − s${j + 1}`, values: over((k) => s(i, k) - s(j, k)) });
    }
  }
  return pairs;
}
