// Drawing on a canvas: its size, lines with gaps, hatching, axes; numbers as text.

const NEAR = 0.5; // px
const FONT = '12px system-ui, "DejaVu Sans", sans-serif'; // as a canvas tells it

// A number as text: no −0, a true minus sign
export const fixed = (value, digits) =>
  Number.isFinite(value)
    ? value
        .toFixed(digits)
        .replace(/^-(?=[0.]*$)/, "")
        .replace("-", "−")
    : "–";

export function ticks(low, high, most) {
  const rough = (high - low) / most,
    power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((m) => m >= rough * 0.999);
  const out = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + step * 1e-9; n++) out.push(n * step);
  return { values: out, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

/** Give canvases a size [px]. One that they have is not set again: that would take new ones, and lay the page out. */
export function sized(width, height, ...canvases) {
  const ratio = window.devicePixelRatio || 1,
    size = { width: Math.round(width * ratio), height: Math.round(height * ratio) };
  for (const canvas of canvases) {
    for (const side of ["width", "height"]) if (canvas[side] !== size[side]) canvas[side] = size[side];
    canvas.style.height = `${height}px`;
  }
  return { width, height, ratio };
}

export function begin(canvas, { ratio, width, height }, font = FONT) {
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.setLineDash([]);
  pen.globalAlpha = 1;
  if (pen.font !== font) pen.font = font; // to set one lays the page out
  return pen;
}

/** A line through `count` points [px], with gaps where there is none; one that nobody could tell from the last is left out. */
export function line(pen, count, x, y) {
  let down = false,
    [fromX, fromY] = [0, 0];
  for (let k = 0; k < count; k++) {
    const px = x(k),
      py = y(k);
    if (!Number.isFinite(px + py)) {
      down = false;
      continue;
    }
    if (!down) pen.moveTo(px, py);
    else if (k + 1 < count && Math.abs(px - fromX) < NEAR && Math.abs(py - fromY) < NEAR) continue;
    else pen.lineTo(px, py);
    [down, fromX, fromY] = [true, px, py];
  }
}

// Parallel strokes within the current clip, across a box: what tells faults apart without colour
export function hatch(pen, x, y, width, height, gap, kind) {
  const reach = width + height;
  pen.beginPath();
  for (let d = gap / 2; d < reach; d += gap) {
    if (kind === "delay" || kind === "failure") {
      pen.moveTo(x + d, y);
      pen.lineTo(x + d - height, y + height);
    }
    if (kind === "failure") {
      pen.moveTo(x + width - d, y);
      pen.lineTo(x + width - d + height, y + height);
    }
    if (kind === "silence" && d < height) {
      pen.moveTo(x, y + d);
      pen.lineTo(x + width, y + d);
    }
    if (kind === "stall" && d < width) {
      pen.moveTo(x + d, y);
      pen.lineTo(x + d, y + height);
    }
  }
  pen.stroke();
}

export function axes(pen, box, view, theme, xs, ys, labels) {
  pen.lineWidth = 1;
  pen.strokeStyle = theme.line;
  pen.fillStyle = theme.quiet;
  pen.textAlign = "center";
  pen.textBaseline = "top";
  for (const value of xs.values) {
    const px = view.x(value);
    pen.beginPath();
    pen.moveTo(px, box.top);
    pen.lineTo(px, box.bottom);
    pen.stroke();
    pen.fillText(fixed(value, xs.digits), px, box.bottom + 5);
  }
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (const value of ys.values) {
    const py = view.y(value);
    pen.beginPath();
    pen.moveTo(box.left, py);
    pen.lineTo(box.right, py);
    pen.stroke();
    pen.fillText(fixed(value, ys.digits), box.left - 6, py);
  }
  pen.textBaseline = "bottom";
  pen.fillText(labels[0], box.right, box.bottom + 36);
  pen.textAlign = "left";
  pen.fillText(labels[1], 4, box.top - 11);
}
