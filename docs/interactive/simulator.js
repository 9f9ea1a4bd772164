// The simulator's loop as drive.py has compiled it, and how a design becomes the numbers that it reads.

const bytes = (text) => Uint8Array.from(atob(text), (sign) => sign.charCodeAt(0));
const known = new Map(); // what was unpacked
function floats(text) {
  if (!known.has(text)) known.set(text, new Float64Array(bytes(text).buffer));
  return known.get(text);
}

/** The numbers of a rule base, packed as drive.py did, with the parameters that a design has now. */
export function packed({ numbers, at, terms, consequents }, { inputs, outputs }) {
  const s = floats(numbers).slice(),
    rules = consequents[0].length;
  terms.forEach(([i, t], k) => {
    inputs[i].terms[t].parameters.forEach((value, n) => (s[s[at["abcd"[n]]] + k] = value));
  });
  consequents.forEach((row, o) =>
    row.forEach((term, r) => {
      if (term < 0) return;
      const parameters = outputs[o].terms[term].parameters,
        place = o * rules + r;
      s[s[at.constant] + place] = parameters.at(-1);
      parameters.slice(0, -1).forEach((slope, i) => (s[s[at.slopes] + place * inputs.length + i] = slope));
    }),
  );
  return s;
}

/** What drives: drive(law, {path, seed, noise, latency}, numbers) gives x, y [m] and heading [rad] of each period. */
export async function simulator(data) {
  const { sin, cos, atan2, hypot } = Math;
  const functions = { sin, cos, atan2, hypot, fmod: (a, b) => a % b };
  const { instance } = await WebAssembly.instantiate(bytes(data.module), { env: functions });
  const { memory, drive, ...places } = instance.exports;
  const put = (name, values) => new Float64Array(memory.buffer, places[name].value, values.length).set(values);
  put("parameters", data.robot);
  return {
    aims: (path) => floats(data.paths[path].aims),
    /** noise: m, and rad of the heading; latency: s. */
    drive(law, { path, seed, noise, latency }, numbers = null) {
      const road = data.paths[path];
      for (const name of ["aims", "ahead", "early"]) put(name, floats(road[name]));
      put("draws", floats(data.draws[seed]));
      put("noise", [noise, noise, noise]);
      if (numbers) put("rules", numbers);
      drive(data.laws.indexOf(law), Math.round(latency / data.step), ...road.start);
      return new Float64Array(memory.buffer, places.trace.value, 3 * data.samples).slice();
    },
  };
}
