/* The state of the page, and its listeners. */

export const state = {
  connection: "connecting", // connecting, open, lost
  retryAt: 0,               // when the next attempt is due, ms
  welcome: null,
  document: null,           // the scene as shown, own changes included
  served: null,             // the scene as the server last told it
  original: null,           // the scene as it was at first
  view: { method: "", compare: false, paused: false, width: 0, height: 0, exposure: 0 },
  status: null,
  camera: null,             // position, target, up in metres, fov_y in degrees
  frames: [null, null],     // the last frame of each channel
  display: {
    mode: "method",         // method, path, wipe, difference
    wipe: 0.5,              // place of the divider, of the image's width
    curve: "filmic",        // filmic, srgb, reinhard, linear
    look: "color",          // color, false
    channel: "rgb",         // rgb, r, g, b, luminance
    exposure: 0,            // stops
    falseRange: [-3, 1],    // decades of radiance
    differenceRange: 0.1,   // radiance at both ends of the scale
    markers: true,          // pixels that are no numbers
    zoom: 0,                // device pixels per pixel; 0 fits the window
    center: [0.5, 0.5],     // of the image, in the middle of the window
  },
};

const listeners = new Map();

export const on = (event, action) => {
  if (!listeners.has(event)) listeners.set(event, []);
  listeners.get(event).push(action);
};

export const emit = (event, detail) => {
  for (const action of listeners.get(event) ?? []) action(detail);
};

/* The method of the image: the one that auto chose, where the view is auto's. */
export const methodShown = () =>
  state.view.method === "auto" ? state.status?.method || state.view.chosen || "auto" : state.view.method;

/* Content of the second channel: path, or the photograph that the first shows through a medium. */
export const referenceName = () => state.welcome?.reference ?? "path";
export const isPhoto = () => state.welcome?.kind === "photograph";

/* Changes how images are shown. */
export const display = changes => {
  Object.assign(state.display, changes);
  emit("display", Object.keys(changes));
};
