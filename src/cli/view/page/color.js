/* Luminance, display curves and tables of colour maps. */

import { diverging, sequential, toSrgb } from "./color_maps.js";
import { clamp } from "./dom.js";

/* Rec. 709 */
export const luminance = ([r, g, b]) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

export const fromSrgb = x => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;

/* Identity up to 1/2, then a shoulder that tends to 1; and its inverse. */
export const fromFilmic = y => y <= 0.5 ? y : 0.5 + 0.5 * (1 / (1 - (2 * y - 1)) - 1);

const byte = x => Math.round(255 * clamp(x, 0, 1));

/* A colour of any brightness as #rrggbb of full brightness, or as it is where it is at most 1 by its kind. */
export const hexOf = (rgb, relative) => {
  const top = relative ? Math.max(...rgb) || 1 : 1;
  return `#${rgb.map(x => byte(toSrgb(x / top)).toString(16).padStart(2, "0")).join("")}`;
};
export const rgbOf = hex => [1, 3, 5].map(at => fromSrgb(parseInt(hex.slice(at, at + 2), 16) / 255));

const makeRamp = map =>
  Uint8Array.from(Array.from({ length: 256 }, (_, i) => [...map(i / 255), 255]).flat());

/* 256 colours of 4 bytes. */
export const ramps = { radiance: makeRamp(sequential), difference: makeRamp(diverging) };
