/* Elements, numbers as text, downloads. */

export const find = selector => document.querySelector(selector);

/* An element with attributes and children; an attribute that is a function listens to the event of its name, and one that is
 * true or false is there or not. */
export const make = (name, attributes = {}, ...children) => fill(document.createElement(name), attributes, children);
export const makeSvg = (name, attributes = {}, ...children) =>
  fill(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);

const fill = (element, attributes, children) => {
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key, value);
    else if (value !== false && value !== undefined) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.filter(child => child !== null && child !== undefined));
  return element;
};

export const clamp = (x, low, high) => Math.min(Math.max(x, low), high);

/* A number with so many significant digits, without needless zeros. */
export const number = (value, digits = 4) => {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "NaN" : value > 0 ? "∞" : "−∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e6)
    return value.toExponential(digits - 1).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
};

/* As above with a true minus, for reading only. */
export const shown = (value, digits) => number(value, digits).replaceAll("-", "−");

/* With all digits, so that columns stand still. */
export const fixed = (value, digits = 5) => {
  if (!Number.isFinite(value)) return number(value);
  const size = Math.abs(value);
  if (value !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(digits - 2);
  return value.toFixed(Math.max(0, digits - 1 - Math.max(0, Math.floor(Math.log10(size || 1)))));
};

export const percent = value => `${shown(100 * value, 2)} %`;

export const milliseconds = value =>
  value >= 10000 ? `${shown(value / 1000, 3)} s` : value >= 100 ? `${Math.round(value)} ms` : `${shown(value, 2)} ms`;

/* Rounded to the steps that a slider or a drag can mean. */
export const tidy = (value, digits = 4) => Number(value.toPrecision(digits));

export const download = (name, blob) => {
  const address = URL.createObjectURL(blob);
  const link = make("a", { href: address, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
};

/* Calls a function at most once per animation frame. */
export const perFrame = action => {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      action();
    });
  };
};

/* True if keys go into a field as text. */
export const isTyping = element =>
  element instanceof HTMLSelectElement || element instanceof HTMLTextAreaElement ||
  element instanceof HTMLInputElement && !["range", "checkbox", "color", "radio"].includes(element.type);
