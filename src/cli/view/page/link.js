/* The WebSocket: messages, acknowledgements, and connecting again. */

import { decode } from "./frame.js";
import { show } from "./screen.js";
import { emit, on, state } from "./state.js";

const PAUSES = [500, 1000, 2000, 4000, 8000];

let socket = null, failures = 0, timer = 0, count = 0;
const waiting = new Map(); // what to do with answers, by id
const queues = [Promise.resolve(), Promise.resolve()];

export const isOpen = () => socket !== null && socket.readyState === WebSocket.OPEN;

/* Sends a message where there is a connection; returns whether. */
export const send = message => {
  if (!isOpen()) return false;
  socket.send(JSON.stringify(message));
  return true;
};

/* Sends a message with an id. The promise is kept with the answer of type done, broken by an error, in which refused is true
 * where the server refused; a message without an
 * answer is forgotten after 10 s. */
export const ask = message => new Promise((resolve, reject) => {
  const id = ++count;
  if (!send({ ...message, id })) {
    reject(new Error("not connected"));
    return;
  }
  waiting.set(id, { resolve, reject });
  setTimeout(() => waiting.delete(id), 10000);
});

/* Frames of a channel are decoded one after the other; the acknowledgement of each asks for the next. */
const receiveFrame = buffer => {
  const channel = new DataView(buffer).getUint8(4) & 1, from = socket;
  queues[channel] = queues[channel].then(async () => {
    const frame = await decode(buffer);
    if (from !== socket) return;
    show(frame);
    send({ type: "ack", channel: frame.channel, sequence: frame.sequence });
  }).catch(error => emit("trouble", { text: `A frame cannot be shown: ${error.message}` }));
};

const settle = (id, action) => {
  const found = waiting.get(id);
  waiting.delete(id);
  if (found) action(found);
  return found !== undefined;
};

const receiveText = text => {
  const message = JSON.parse(text);
  if (message.type === "done") settle(message.id, ({ resolve }) => resolve(message));
  else if (message.type === "error") {
    const error = Object.assign(new Error(message.text), { refused: true });
    if (!settle(message.id, ({ reject }) => reject(error))) emit("trouble", { text: message.text });
  } else emit(`server:${message.type}`, message);
};

const lose = () => {
  socket = null;
  for (const { reject } of waiting.values()) reject(new Error("the connection was lost"));
  waiting.clear();
  const pause = PAUSES[Math.min(failures++, PAUSES.length - 1)];
  Object.assign(state, { connection: "lost", retryAt: performance.now() + pause });
  timer = setTimeout(connect, pause);
  emit("connection");
};

export const connect = () => {
  clearTimeout(timer);
  if (socket !== null) return;
  const token = new URLSearchParams(location.search).get("token");
  const address = new URL("live", location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  address.search = token === null ? "" : `?token=${encodeURIComponent(token)}`;
  const opened = new WebSocket(address);
  socket = opened;
  opened.binaryType = "arraybuffer";
  opened.addEventListener("message", ({ data }) => {
    if (opened === socket) (typeof data === "string" ? receiveText : receiveFrame)(data);
  });
  opened.addEventListener("close", () => {
    if (opened === socket) lose();
  });
};

on("server:welcome", () => {
  failures = 0;
  state.connection = "open";
  emit("connection");
});
