// A small picture of an output over one or two inputs: bands without numbers, or a curve.
import { fieldOf, levelsOf, paintBands } from "./field.js";

/** The colours that a small picture takes from the style of `node`. */
export function inks(node) {
  const style = getComputedStyle(node),
    read = (name) => style.getPropertyValue(name).trim();
  return {
    paper: read("--ff-paper"),
    hatch: read("--ff-hatch"),
    line: read("--ff-mark"),
    quiet: read("--ff-quiet"),
  };
}

const EDGE = 6, // px round a curve
  RATIO = 1.5; // dots a pixel
const tone = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/**
 * Paint a trait `surface` into a canvas of width × height CSS pixels, with red lines at the shares `at` of its ranges.
 * `levels` are its own by default.
 */
export function paintSmall(canvas, surface, width, height, colours, { levels = null, at = [] } = {}) {
  const field = fieldOf(surface);
  if (field.flat) {
    const paper = tone(colours.paper),
      hatch = tone(colours.hatch);
    paintBands(canvas, field, levels ?? levelsOf([field]), "viridis", { width, height, ratio: RATIO, paper, hatch });
    cross(canvas, at, 0, colours.line);
    return;
  }
  const pen = begun(canvas, width, height, colours),
    known = [...field.z].filter(Number.isFinite),
    low = Math.min(...known),
    span = Math.max(...known) - low || 1;
  // Where no rule fires the value is the system's own.
  for (const [fired, ink] of [
    [0, colours.quiet],
    [1, colours.line],
  ]) {
    const shares = [...field.z].map((z, k) => (field.fired[k] === fired ? (z - low) / span : NaN));
    trace(pen, shares, width, height, ink);
  }
  cross(canvas, at, EDGE, colours.line);
}

function cross(canvas, [x, y], edge, mark) {
  const pen = canvas.getContext("2d");
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.scale(RATIO, RATIO);
  const wide = canvas.width / RATIO,
    high = canvas.height / RATIO;
  for (const [width, ink] of [
    [3, "rgb(255 255 255 / 0.7)"],
    [1.2, mark],
  ]) {
    pen.lineWidth = width;
    pen.strokeStyle = ink;
    pen.beginPath();
    if (x !== undefined) (pen.moveTo(edge + x * (wide - 2 * edge), 0), pen.lineTo(edge + x * (wide - 2 * edge), high));
    if (y !== undefined) (pen.moveTo(0, (1 - y) * high), pen.lineTo(wide, (1 - y) * high));
    pen.stroke();
  }
}

/** Paint curves of degrees from 0 to 1, each over equal steps. */
export function paintCurves(canvas, curves, width, height, colours) {
  const pen = begun(canvas, width, height, colours);
  for (const curve of curves) trace(pen, curve, width, height, colours.line);
}

function begun(canvas, width, height, colours) {
  canvas.width = Math.round(width * RATIO);
  canvas.height = Math.round(height * RATIO);
  Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
  const pen = canvas.getContext("2d");
  pen.scale(RATIO, RATIO);
  pen.fillStyle = colours.paper;
  pen.fillRect(0, 0, width, height);
  return pen;
}

function trace(pen, shares, width, height, ink) {
  pen.strokeStyle = ink;
  pen.lineWidth = 2;
  pen.beginPath();
  let down = false;
  shares.forEach((share, k) => {
    const x = EDGE + (k / Math.max(1, shares.length - 1)) * (width - 2 * EDGE),
      y = height - EDGE - share * (height - 2 * EDGE);
    if (Number.isFinite(share)) down ? pen.lineTo(x, y) : pen.moveTo(x, y);
    down = Number.isFinite(share);
  });
  pen.stroke();
}
