/* Half floats, the sRGB curve and colour maps. The page of `tyndall compare` has this file, too, without its exports. */

/* The values of all half floats. */
export const halfValues = Float32Array.from({ length: 65536 }, (_, bits) => {
  const sign = bits & 0x8000 ? -1 : 1, exponent = bits >> 10 & 31, mantissa = bits & 1023;
  if (exponent === 31) return mantissa > 0 ? NaN : sign * Infinity;
  return sign * (exponent === 0 ? mantissa * 2 ** -24 : (1024 + mantissa) * 2 ** (exponent - 25));
});

export const toSrgb = x => x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;

const fromOklab = (lightness, chroma, hue) => {
  const a = chroma * Math.cos(hue), b = chroma * Math.sin(hue);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3;
  const linear = [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s, -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s];
  return linear.map(x => Math.round(255 * toSrgb(Math.min(Math.max(x, 0), 1))));
};

/* Dark violet over orange to light yellow, as bright as t says; blue over white to red. */
export const sequential = t =>
  fromOklab(0.16 + 0.8 * t, 0.03 + 0.16 * Math.sin(Math.PI * t ** 0.8), -1.35 + 3.25 * t);
export const diverging = t => {
  const amount = Math.abs(2 * t - 1);
  return fromOklab(0.98 - 0.52 * amount ** 1.1, 0.17 * amount ** 0.8, t < 0.5 ? 4.5 : 0.45);
};
