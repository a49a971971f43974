const find = selector => document.querySelector(selector);
/* An element with attributes and children. */
const make = (name, attributes, ...children) => {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
};

const report = JSON.parse(find("#comparison").textContent);
const columns = Math.ceil(report.width / report.shrink), rows = Math.ceil(report.height / report.shrink);
const pixelCount = columns * rows;

const images = [report.reference, ...report.images].map((entry, index) => {
  const element = document.querySelectorAll(".pixels")[index];
  return {
    entry, index, element, name: entry.name, scale: 2 ** Number(element.dataset.exponent),
    window: element.dataset.window.split(" ").map(Number), halves: null, loading: null, mean: 0, painted: null, paint: "",
  };
});

/* Differences from the left, folded (0, -1, 1, -2 as 0, 1, 2, 3), low bytes before high bytes. */
const unfold = bytes => {
  const count = bytes.length / 2, halves = new Uint16Array(count);
  for (let at = 0; at < count;) {
    let left = 0;
    for (let x = 0; x < columns; ++x, ++at) {
      const folded = bytes[at] | bytes[count + at] << 8;
      left = left + (folded >>> 1 ^ -(folded & 1)) & 0xffff;
      halves[at] = left;
    }
  }
  return halves;
};

const unpack = async image => {
  const text = atob(image.element.textContent), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  image.halves = unfold(new Uint8Array(await new Response(stream).arrayBuffer()));
  image.element.remove();
  let sum = 0;
  for (let i = 0; i < pixelCount; ++i) {
    const value = sumAt(image, i);
    if (Number.isFinite(value)) sum += value;
  }
  image.mean = sum / pixelCount;
};

const load = image => image.loading ??= unpack(image);

const valueAt = (image, channel, at) => image.scale * halfValues[image.halves[channel * pixelCount + at]];
const sumAt = (image, at) => valueAt(image, 0, at) + valueAt(image, 1, at) + valueAt(image, 2, at);
/* Rec.709 */
const luminanceAt = (image, at) =>
  0.2126 * valueAt(image, 0, at) + 0.7152 * valueAt(image, 1, at) + 0.0722 * valueAt(image, 2, at);

/* True if an image has this pixel: its window may be a part of the frame. */
const covers = (image, x, y) => {
  const [left, top, width, height] = image.window, k = report.shrink;
  return x * k >= left && x * k < left + width && y * k >= top && y * k < top + height;
};

/* ---- colours ---- */

/* The display transform of the PNGs: linear up to 1/2, then a shoulder that tends to 1. */
const toByte = x => {
  if (!(x > 0)) return 0;
  const y = 2 * x - 1;
  const shown = x <= 0.5 ? x : y === Infinity ? 1 : 0.5 + 0.5 * y / (1 + y);
  return Math.floor(255 * toSrgb(Math.min(shown, 1)) + 0.5);
};

const makeRamp = map => Uint8Array.from({ length: 768 }, (_, i) => map(Math.floor(i / 3) / 255)[i % 3]);
const ramps = { luminance: makeRamp(sequential), error: makeRamp(diverging) };

/* Luminance: so many stops up to and from full exposure. */
const stopsBelow = 8, stopsAbove = 2;
