
/* ---- the images, side by side or in turn ---- */

const canvas = find("#canvas"), stage = find("#stage"), context = canvas.getContext("2d");
/* At first: the reference, and what comes nearest to it of what is not paths. */
const byError = images.slice(1).sort((a, b) => a.entry.all.rmse - b.entry.all.rmse);
const view = {
  left: images[0], right: byError.find(image => image.entry.source !== "path") ?? byError[0],
  mode: "slider", flipped: false, cut: 50, display: "color", exposure: report.exposure, range: 0.3,
  x: columns >> 1, y: rows >> 1,
};

const paintColor = (image, data) => {
  const bytes = new Uint8ClampedArray(65536), scale = image.scale * 2 ** view.exposure;
  for (let i = 0; i < 65536; ++i) bytes[i] = toByte(halfValues[i] * scale);
  for (let i = 0; i < pixelCount; ++i)
    for (let c = 0; c < 3; ++c) data[4 * i + c] = bytes[image.halves[c * pixelCount + i]];
};

/* t: 0..1 of a pixel, NaN where there is no number: green. */
const paintRamp = (ramp, data, t) => {
  for (let i = 0; i < pixelCount; ++i) {
    const place = t(i), at = 3 * Math.round(255 * Math.min(Math.max(place, 0), 1));
    for (let c = 0; c < 3; ++c) data[4 * i + c] = Number.isNaN(place) ? (c === 1 ? 255 : 0) : ramp[at + c];
  }
};

/* As heat maps: of R + G + B, relative to the reference or a tenth of its mean, whichever is more. */
const errorAt = (image, reference, at) => {
  const value = sumAt(image, at), expected = sumAt(reference, at);
  const error = (value - expected) / Math.max(expected, 0.1 * reference.mean, 1e-30);
  return Number.isFinite(error) ? error : NaN;
};

/* An image as it is shown now, on a canvas of its own that is kept until something changes. */
const painted = (image, reference) => {
  const key = [view.display, view.exposure, view.range, view.display === "error" ? reference.index : ""].join();
  if (image.paint === key) return image.painted;
  image.painted ??= Object.assign(document.createElement("canvas"), { width: columns, height: rows });
  const ink = image.painted.getContext("2d"), pixels = ink.createImageData(columns, rows), data = pixels.data;
  const scale = 2 ** view.exposure;
  if (view.display === "color") paintColor(image, data);
  if (view.display === "luminance")
    paintRamp(ramps.luminance, data,
      at => (Math.log2(Math.max(luminanceAt(image, at) * scale, 1e-30)) + stopsBelow) / (stopsBelow + stopsAbove));
  if (view.display === "error")
    paintRamp(ramps.error, data, at => 0.5 + 0.5 * errorAt(image, reference, at) / view.range);
  const whole = covers(image, 0, 0) && covers(image, columns - 1, rows - 1);
  for (let i = 0; i < pixelCount; ++i)
    data[4 * i + 3] = whole || covers(image, i % columns, Math.floor(i / columns)) ? 255 : 0;
  ink.putImageData(pixels, 0, 0);
  image.paint = key;
  return image.painted;
};

const number = (value, digits = 3) => {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "not a number" : String(value);
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e5 || size < 1e-3 ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
};
const percent = (value, digits = 3) => number(100 * value, digits) + " %";
const samples = value => Number.isInteger(value) || value >= 100 ? String(Math.round(value)) : number(value);
const seconds = value => value >= 100 ? Math.round(value) + " s" : value >= 1 ? number(value) + " s"
  : value >= 1e-3 ? number(1000 * value) + " ms" : number(1e6 * value) + " µs";

const describe = () => {
  const { left, right } = view;
  const what = { color: "in colour", luminance: "as luminance in false colours", error: "" }[view.display];
  if (view.display === "error") return `Error of ${right.name} against ${left.name}`;
  if (view.mode === "flip") return `${view.flipped ? right.name : left.name}, ${what}`;
  return `${left.name} on the left, ${right.name} on the right, ${what}`;
};

const drawNames = () => {
  const whole = view.display === "error" || view.mode === "flip";
  const shown = view.display === "error" ? `${view.right.name} against ${view.left.name}`
    : view.mode === "flip" && view.flipped ? view.right.name : view.left.name;
  find("#name-left").textContent = shown;
  find("#name-right").textContent = whole ? "" : view.right.name;
  find("#name-right").hidden = find("#edge").hidden = find("#cut").hidden = whole;
  find("#flip").hidden = view.mode !== "flip" || view.display === "error";
};

const drawScale = () => {
  const { display } = view, scale = find("#scale");
  find("#range-label").hidden = display !== "error";
  find(".exposure").hidden = find("#reset").hidden = display === "error";
  scale.hidden = display === "color";
  if (display === "color") return;
  const ramp = ramps[display], ink = find("#ramp").getContext("2d"), row = ink.createImageData(256, 1);
  for (let i = 0; i < 256; ++i) row.data.set([ramp[3 * i], ramp[3 * i + 1], ramp[3 * i + 2], 255], 4 * i);
  ink.putImageData(row, 0, 0);
  const labels = [0, 0.25, 0.5, 0.75, 1].map(t => display === "error" ? percent((2 * t - 1) * view.range, 2)
    : number(2 ** (-stopsBelow + t * (stopsBelow + stopsAbove) - view.exposure), 2));
  find("#ticks").replaceChildren(...labels.map(label => make("span", {}, label)));
  find("#scale-says").textContent = display === "error"
    ? `Blue where ${view.right.name} is darker than ${view.left.name}, red where it is brighter; relative to `
      + `${view.left.name}, or to a tenth of its mean where that is more.`
    : "Luminance, in the units of the images, one stop a tenth of the scale.";
};

/* Only once both images are unpacked. */
const draw = () => {
  const { left, right } = view;
  const whole = view.display === "error" || view.mode === "flip";
  const cut = Math.round(view.cut / 100 * columns);
  context.clearRect(0, 0, columns, rows);
  if (view.display === "error") {
    context.drawImage(painted(right, left), 0, 0);
  } else if (whole) {
    context.drawImage(painted(view.flipped ? right : left), 0, 0);
  } else {
    if (cut > 0) context.drawImage(painted(left), 0, 0, cut, rows, 0, 0, cut, rows);
    if (cut < columns) context.drawImage(painted(right), cut, 0, columns - cut, rows, cut, 0, columns - cut, rows);
  }
  find("#edge").style.left = 100 * cut / columns + "%";
  drawNames();
  drawScale();
  canvas.setAttribute("aria-label", describe());
  find("#cut").setAttribute("aria-valuetext", `${Math.round(view.cut)} percent of the width`);
  find("#stops").textContent = (view.exposure > 0 ? "+" : "") + number(view.exposure, 4) + " stops";
  drawMagnifier();
};

/* Unpacks what is chosen, and draws. */
const refresh = async () => {
  find("#left").value = view.left.index;
  find("#right").value = view.right.index;
  find("#display").value = view.display;
  find("#range").value = view.range;
  find("#cut").value = view.cut;
  find("#exposure").value = view.exposure;
  for (const radio of document.querySelectorAll("input[name=mode]")) radio.checked = radio.value === view.mode;
  document.documentElement.removeAttribute("data-drawn");
  await Promise.all([load(view.left), load(view.right)]);
  draw();
  document.documentElement.dataset.drawn = "";
};
