// What robotics/show/playback/player.py packed for a page of several players: JSON and arrays, deflated, as base64.

// The text's object; where it had an array as base64, there is an ArrayBuffer.
export async function unpacked(text) {
  const raw = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream("deflate"));
  const all = new Uint8Array(await new Response(stream).arrayBuffer());
  const head = new DataView(all.buffer).getUint32(0, true);
  const arrays = all.subarray(4 + head);
  return JSON.parse(new TextDecoder().decode(all.subarray(4, 4 + head)), (key, value) =>
    value?.packed ? whole(arrays, ...value.packed) : value,
  );
}

function whole(arrays, from, bytes, differences) {
  const part = arrays.slice(from, from + bytes);
  if (!differences) return part.buffer;
  // Differences of 16-bit numbers, all low bytes before all high ones
  const count = bytes / 2,
    out = new Uint16Array(count);
  let sum = 0;
  for (let k = 0; k < count; k++) {
    sum = (sum + part[k] + 256 * part[count + k]) & 0xffff;
    out[k] = sum;
  }
  return out.buffer;
}
