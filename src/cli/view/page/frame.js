/* Frames from the server: docs/view_protocol.md. */

import { fromFilmic, fromSrgb } from "./color.js";
import { halfValues } from "./color_maps.js";

const HEADER = 64;

/* The members of the header. */
const readHeader = buffer => {
  const data = new DataView(buffer);
  if (buffer.byteLength < HEADER || data.getUint32(0) !== 0x54594631) throw new Error("a frame without TYF1");
  return {
    channel: data.getUint8(4), codec: data.getUint8(5), sequence: data.getUint32(8, true),
    revision: data.getUint32(12, true), width: data.getUint16(16, true), height: data.getUint16(18, true),
    fullWidth: data.getUint16(20, true), fullHeight: data.getUint16(22, true), spp: data.getFloat32(24, true),
    latency: data.getFloat32(28, true), exposure: data.getFloat32(32, true), final: (data.getUint32(36, true) & 1) !== 0,
    halves: null, bitmap: null, bytes: null,
  };
};

const inflate = async bytes => {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

/* Three planes of differences, all low bytes before all high bytes, to interleaved halves. */
const undelta = (bytes, width, height) => {
  const count = width * height, halves = new Uint16Array(3 * count);
  if (bytes.length !== 6 * count) throw new Error("a frame of another size than its header says");
  for (let plane = 0, at = 0; plane < 3; ++plane)
    for (let y = 0; y < height; ++y)
      for (let x = 0, last = 0, to = 3 * y * width + plane; x < width; ++x, ++at, to += 3)
        halves[to] = last = last + bytes[at] + (bytes[at + 3 * count] << 8) & 0xffff;
  return halves;
};

/* A frame with halves (codecs 0 and 1) or a bitmap (JPEG). */
export const decode = async buffer => {
  const frame = readHeader(buffer), bytes = new Uint8Array(buffer, HEADER), values = 3 * frame.width * frame.height;
  if (frame.codec === 0) {
    if (bytes.length !== 2 * values) throw new Error("a frame of another size than its header says");
    frame.halves = new Uint16Array(buffer, HEADER, values);
  } else if (frame.codec === 1) {
    frame.halves = undelta(await inflate(bytes), frame.width, frame.height);
  } else {
    frame.bitmap = await createImageBitmap(new Blob([bytes], { type: "image/jpeg" }), { colorSpaceConversion: "none" });
  }
  return frame;
};

/* The bytes of a JPEG, read back once. */
const bytesOf = frame => {
  if (frame.bytes === null) {
    const ink = new OffscreenCanvas(frame.width, frame.height).getContext("2d");
    ink.drawImage(frame.bitmap, 0, 0);
    frame.bytes = ink.getImageData(0, 0, frame.width, frame.height).data;
  }
  return frame.bytes;
};

/* Linear R, G, B at a pixel of the full frame: exact from halves; of a JPEG what its bytes stand for. */
export const valueAt = (frame, x, y) => {
  const column = Math.min(Math.floor((x + 0.5) * frame.width / frame.fullWidth), frame.width - 1);
  const row = Math.min(Math.floor((y + 0.5) * frame.height / frame.fullHeight), frame.height - 1);
  const at = row * frame.width + column;
  if (frame.halves !== null) return [0, 1, 2].map(c => halfValues[frame.halves[3 * at + c]]);
  const bytes = bytesOf(frame), scale = 2 ** -frame.exposure;
  return [0, 1, 2].map(c => scale * fromFilmic(Math.min(fromSrgb(bytes[4 * at + c] / 255), 0.996)));
};

/* Luminances of up to so many pixels, spread over a frame, in ascending order. */
export const sortedLuminances = (frame, other = null, most = 20000) => {
  const step = Math.max(1, Math.floor(Math.sqrt(frame.fullWidth * frame.fullHeight / most))), found = [];
  for (let y = step >> 1; y < frame.fullHeight; y += step)
    for (let x = step >> 1; x < frame.fullWidth; x += step) {
      const [r, g, b] = valueAt(frame, x, y), [p, q, s] = other ? valueAt(other, x, y) : [0, 0, 0];
      const value = 0.2126 * (r - p) + 0.7152 * (g - q) + 0.0722 * (b - s);
      if (Number.isFinite(value)) found.push(other ? Math.abs(value) : value);
    }
  return Float32Array.from(found).sort();
};
