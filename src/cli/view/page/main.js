/* The page of tyndall view: its parts, in the order in which they begin. */

import * as bar from "./bar.js";
import * as camera from "./camera.js";
import { find } from "./dom.js";
import * as keep from "./keep.js";
import * as keys from "./keys.js";
import { connect } from "./link.js";
import "./panels.js";
import * as probe from "./probe.js";
import * as screen from "./screen.js";
import * as show from "./show.js";
import { emit, state } from "./state.js";
import * as status from "./status.js";

/* For tests and consoles: what the page knows, as a copy. */
const describe = () => structuredClone({ ...state,
  frames: state.frames.map(frame => frame && { ...frame, halves: null, bitmap: null, bytes: null }) });
window.tyndall = Object.freeze({
  get state() { return describe(); },
  probe: (x, y, channel = 0) => probe.probe(x, y, channel),
  place: () => screen.place(),
});

bar.start();
status.start();
if (screen.start()) {
  show.start();
  probe.start();
  camera.start();
  keep.start();
  keys.start();
  connect();
  find("#screen").focus({ preventScroll: true });
} else {
  emit("trouble", { text: "This browser has no WebGL2, which the image needs." });
}
