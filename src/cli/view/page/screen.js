/* The canvas: textures of both channels, where the image lies in the window, and drawing. */

import { ramps } from "./color.js";
import { clamp, find, perFrame } from "./dom.js";
import { fragmentText, vertexText } from "./shaders.js";
import { emit, on, state } from "./state.js";

const MODES = { method: 0, path: 1, wipe: 2, difference: 3 };
const CURVES = { filmic: 0, srgb: 1, reinhard: 2, linear: 3 };
const CHANNELS = { rgb: 0, r: 1, g: 2, b: 3, luminance: 4 };

const canvas = find("#screen");
let gl = null, program = null, uniforms = {}, textures = [];

const compile = (type, text) => {
  const shader = gl.createShader(type);
  gl.shaderSource(shader, text);
  gl.compileShader(shader);
  if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost())
    throw new Error(gl.getShaderInfoLog(shader));
  return shader;
};

const makeTexture = unit => {
  const texture = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.LINEAR);
  return texture;
};

const prepare = () => {
  program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, vertexText));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, fragmentText));
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.bindVertexArray(gl.createVertexArray());
  const names = ["method", "path", "radiance", "difference", "place", "outside", "window", "jpeg", "false", "scale", "wipe",
    "range", "mode", "curve", "channel", "look", "markers", "taps", "there"];
  uniforms = Object.fromEntries(names.map(name => [name, gl.getUniformLocation(program, `u_${name}`)]));
  textures = [0, 1, 2, 3].map(makeTexture);
  ["method", "path", "radiance", "difference"].forEach((name, unit) => gl.uniform1i(uniforms[name], unit));
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  [ramps.radiance, ramps.difference].forEach((ramp, i) => {
    gl.activeTexture(gl.TEXTURE2 + i);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, ramp);
  });
  for (const frame of state.frames) if (frame !== null) upload(frame);
};

/* Halves to a texture with a fourth channel, which every driver takes as it is. */
let padded = new Uint16Array(0);
const withAlpha = ({ halves, width, height }) => {
  const count = width * height;
  if (padded.length < 4 * count) padded = new Uint16Array(4 * count);
  for (let i = 0, from = 0, to = 0; i < count; ++i, from += 3, to += 4) {
    padded[to] = halves[from];
    padded[to + 1] = halves[from + 1];
    padded[to + 2] = halves[from + 2];
  }
  return padded;
};

const upload = frame => {
  gl.activeTexture(gl.TEXTURE0 + frame.channel);
  if (frame.halves !== null)
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA16F, frame.width, frame.height, 0, gl.RGBA, gl.HALF_FLOAT, withAlpha(frame));
  else
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, frame.width, frame.height, 0, gl.RGBA, gl.UNSIGNED_BYTE, frame.bitmap);
};

/* Takes a decoded frame. */
export const show = frame => {
  const old = state.frames[frame.channel];
  old?.bitmap?.close();
  state.frames[frame.channel] = frame;
  if (!gl.isContextLost()) upload(frame);
  redraw();
  emit("frame", frame);
};

/* The size of the full frame: of what was received last. */
export const frameSize = () => {
  const frame = state.frames[0] ?? state.frames[1];
  return frame ? [frame.fullWidth, frame.fullHeight] : [state.view.width || 4, state.view.height || 3];
};

/* Where the frame lies in the window: left, top, width, height and zoom, in device pixels. */
export const place = () => {
  const [width, height] = frameSize(), { zoom: wanted, center } = state.display;
  const fit = Math.min(canvas.width / width, canvas.height / height), zoom = wanted || fit;
  const along = (window, size, at) => size * zoom <= window ? (window - size * zoom) / 2
    : clamp(window / 2 - at * size * zoom, window - size * zoom, 0);
  const left = along(canvas.width, width, center[0]), top = along(canvas.height, height, center[1]);
  const whole = zoom >= 1 && Number.isInteger(zoom) ? Math.round : x => x;
  return { left: whole(left), top: whole(top), width: width * zoom, height: height * zoom, zoom };
};

/* Where a point of the window (CSS pixels) is on the frame, in pixels, not rounded. */
export const toFrame = (x, y) => {
  const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width, at = place();
  return [((x - box.left) * ratio - at.left) / at.zoom, ((y - box.top) * ratio - at.top) / at.zoom];
};

/* And back: CSS pixels from the canvas's corner. */
export const toWindow = (x, y) => {
  const ratio = canvas.width / canvas.clientWidth, at = place();
  return [(at.left + x * at.zoom) / ratio, (at.top + y * at.zoom) / ratio];
};

/* Zooms by a factor about a point of the window. */
export const zoomAbout = (factor, x, y) => {
  const [width, height] = frameSize(), [column, row] = toFrame(x, y), box = canvas.getBoundingClientRect();
  const ratio = canvas.width / box.width, zoom = clamp(place().zoom * factor, 0.05, 64);
  const center = [(column - ((x - box.left) - box.width / 2) * ratio / zoom) / width,
    (row - ((y - box.top) - box.height / 2) * ratio / zoom) / height];
  Object.assign(state.display, { zoom, center: center.map(c => clamp(c, 0, 1)) });
  emit("display", ["zoom"]);
};

const setFilter = (unit, frame, zoom) => {
  const sharp = frame !== null && frame.width === frame.fullWidth && zoom > 2;
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, sharp ? gl.NEAREST : gl.LINEAR);
};

export const draw = () => {
  if (gl.isContextLost()) return;
  const { display, frames } = state, at = place();
  gl.viewport(0, 0, canvas.width, canvas.height);
  const outside = getComputedStyle(canvas).getPropertyValue("--outside").split(" ").map(Number);
  if (!frames[0] && !frames[1]) {
    gl.clearColor(...outside, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    return;
  }
  frames.forEach((frame, unit) => setFilter(unit, frame, at.zoom));
  gl.uniform4f(uniforms.place, at.left, at.top, at.width, at.height);
  gl.uniform4f(uniforms.outside, ...outside, 1);
  gl.uniform2f(uniforms.window, canvas.width, canvas.height);
  gl.uniform2f(uniforms.jpeg, ...frames.map(frame => frame?.bitmap ? 2 ** -frame.exposure : 0));
  gl.uniform2i(uniforms.there, ...frames.map(frame => frame !== null ? 1 : 0));
  gl.uniform2f(uniforms.false, ...display.falseRange);
  gl.uniform1f(uniforms.scale, 2 ** display.exposure);
  gl.uniform1f(uniforms.wipe, display.wipe);
  gl.uniform1f(uniforms.range, display.differenceRange);
  gl.uniform1i(uniforms.mode, MODES[display.mode]);
  gl.uniform1i(uniforms.curve, CURVES[display.curve]);
  gl.uniform1i(uniforms.channel, CHANNELS[display.channel]);
  gl.uniform1i(uniforms.look, display.look === "false" ? 1 : 0);
  gl.uniform1i(uniforms.markers, display.markers ? 1 : 0);
  gl.uniform1i(uniforms.taps, at.zoom < 0.75 ? 4 : 1);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
};

export const redraw = perFrame(draw);

/* The part of the frame that the window shows, as a 2D canvas. */
export const snapshot = () => {
  draw();
  const at = place(), left = Math.max(0, Math.round(at.left)), top = Math.max(0, Math.round(at.top));
  const width = Math.min(canvas.width, Math.round(at.left + at.width)) - left;
  const height = Math.min(canvas.height, Math.round(at.top + at.height)) - top;
  const copy = new OffscreenCanvas(Math.max(width, 1), Math.max(height, 1));
  copy.getContext("2d").drawImage(canvas, -left, -top);
  return copy;
};

const measure = () => {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio)), height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width === width && canvas.height === height) return;
  canvas.width = width;
  canvas.height = height;
  draw();
  emit("place");
};

/* Returns false where there is no WebGL2. */
export const start = () => {
  gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, powerPreference: "high-performance" });
  if (gl === null) return false;
  prepare();
  canvas.addEventListener("webglcontextlost", event => event.preventDefault());
  canvas.addEventListener("webglcontextrestored", () => {
    prepare();
    redraw();
  });
  new ResizeObserver(measure).observe(canvas);
  measure();
  on("display", redraw);
  on("theme", redraw);
  return true;
};
