/* Keeping: the scene, the command line, images, and sequences of frames. */

import { download, find, make } from "./dom.js";
import { edit } from "./edit.js";
import { hasFrames } from "./kinds.js";
import { ask } from "./link.js";
import { makeNumber } from "./field.js";
import { snapshot } from "./screen.js";
import { emit, isPhoto, methodShown, on, referenceName, state } from "./state.js";
import { notice } from "./status.js";

const stem = () => (state.welcome?.name ?? "view").split("/").pop().replace(/^builtin:/, "").replace(/\.(json|exr|hdr|png|jpe?g)$/i, "") || "view";

/* Runs an action and says what went wrong. */
const attempt = action => async () => {
  try {
    await action();
  } catch (error) {
    emit("trouble", { text: error.message });
  }
};

export const saveScene = attempt(async () => {
  const { json } = await ask({ type: "document" });
  download(`${stem()}${isPhoto() ? "_medium" : ""}.json`, new Blob([json], { type: "application/json" }));
  notice(isPhoto() ? "Medium saved" : "Scene saved");
});

/* Without the clipboard's permission the text is selected in a field that can be copied from. */
const putOnClipboard = async text => {
  try {
    await navigator.clipboard.writeText(text);
    notice("Command copied");
  } catch {
    const field = make("textarea", { readonly: true, "aria-label": "Command" });
    field.value = text;
    const dialog = make("dialog", { class: "text", close: () => dialog.remove() }, make("p", {}, "The command:"), field,
      make("form", { method: "dialog" }, make("button", {}, "Close")));
    document.body.append(dialog);
    dialog.showModal();
    field.select();
  }
};

export const copyCommand = attempt(async () => {
  const { command } = await ask({ type: "document" });
  await putOnClipboard(command);
});

export const savePng = attempt(async () => {
  if (!state.frames.some(Boolean)) throw new Error("There is no image yet.");
  const blob = await snapshot().convertToBlob({ type: "image/png" });
  download(`${stem()}_${{ method: methodShown(), path: referenceName() }[state.display.mode] ?? state.display.mode}.png`, blob);
  notice("PNG saved");
});

const record = name => ask({ type: "record", name });

const recordOne = attempt(async () => {
  const { file } = await record(find("#record-name").value);
  notice(`Recorded ${file}`);
});

const refreshLink = () => {
  const token = new URLSearchParams(location.search).get("token"), channel = state.display.mode === "path" ? "path" : "method";
  find("#exr").href = `image.exr?${new URLSearchParams({ ...token && { token }, channel })}`;
  find("#exr").download = `${stem()}_${channel === "path" ? referenceName() : methodShown()}.exr`;
};

/* ---- sequences ---- */

const sequence = { from: 0, to: 100, playing: false, recording: false };
let slider = null, fields = [], playButton = null, recordButton = null;

const frameNow = () => state.document?.frame ?? 0;
const goTo = (frame, moving) => {
  edit([{ path: "frame", value: frame }], moving);
};

/* When a condition holds, which images and the server's scenes may change. */
const waiting = new Set();
let revision = 0; // of the server's last scene
const until = holds => new Promise(resolve => {
  const look = () => {
    if (!holds()) return;
    waiting.delete(look);
    resolve();
  };
  waiting.add(look);
  look();
});
const lookAgain = () => {
  for (const look of [...waiting]) look();
};
on("frame", lookAgain);
on("server:scene", message => {
  revision = message.revision;
  lookAgain();
});

const image = () => state.frames[0];
const nextImage = after => until(() => (image()?.revision ?? 0) > after);
/* The final image of a frame: changes before may be on their way still. */
const finalImage = frame => until(() => (state.served?.frame ?? 0) === frame && image()?.final && image().revision >= revision);

const pause = ms => new Promise(resolve => setTimeout(resolve, ms));

/* Frame by frame, at most 24 a second; each is shown, and when recording it is waited for until it is final. */
const run = async recording => {
  Object.assign(sequence, { playing: true, recording });
  refreshPlay();
  if (recording) goTo(sequence.from, false);
  const name = find("#record-name").value.replace(/(_\d+)?\.(exr|png)$/, "");
  const ending = find("#record-name").value.endsWith(".png") ? "png" : "exr";
  try {
    for (let frame = recording ? sequence.from : frameNow(); sequence.playing;) {
      const begun = performance.now(), shown = image()?.revision ?? 0;
      if (frame !== frameNow() || recording) {
        goTo(frame, !recording);
        await Promise.race([recording ? finalImage(frame) : nextImage(shown), pause(recording ? 600000 : 5000)]);
      }
      if (recording) await record(`${name}_${String(frame).padStart(4, "0")}.${ending}`);
      if (recording && frame >= sequence.to) break;
      await pause(Math.max(0, 1000 / 24 - (performance.now() - begun)));
      frame = frame >= sequence.to ? sequence.from : frame + 1;
    }
  } catch (error) {
    emit("trouble", { text: error.message });
  }
  const recorded = sequence.recording;
  Object.assign(sequence, { playing: false, recording: false });
  if (!recorded) goTo(frameNow(), false);
  refreshPlay();
};

export const togglePlay = () => {
  if (sequence.playing) sequence.playing = false;
  else if (!find("#frames").hidden) run(false);
};
export const stepFrame = by => {
  if (!find("#frames").hidden) goTo(Math.max(0, frameNow() + by), false);
};

const refreshPlay = () => {
  playButton.textContent = sequence.playing ? "Stop" : "Play";
  recordButton.disabled = sequence.playing;
};

const refreshFrames = () => {
  const seen = state.document !== null && (hasFrames(state.document) || state.document.frame !== undefined);
  find("#frames").hidden = !seen;
  if (!seen) return;
  slider.min = sequence.from;
  slider.max = sequence.to;
  slider.value = frameNow();
  slider.style.setProperty("--at", `${100 * (frameNow() - sequence.from) / Math.max(1, sequence.to - sequence.from)}%`);
  fields.forEach((field, i) => field.update([sequence.from, frameNow(), sequence.to][i]));
};

const makeFrames = () => {
  slider = make("input", { type: "range", step: 1, "aria-label": "Frame",
    input: () => goTo(Number(slider.value), true), change: () => goTo(Number(slider.value), false) });
  const limits = { type: "integer", minimum: 0, maximum: 2147483647 };
  fields = [["from", value => sequence.from = Math.min(value, sequence.to)], ["frame", (value, moving) => goTo(value, moving)],
    ["to", value => sequence.to = Math.max(value, sequence.from)]].map(([word, action]) => makeNumber(limits, word, (value, moving) => {
    action(value, moving);
    refreshFrames();
  }));
  playButton = make("button", { type: "button", click: togglePlay }, "Play");
  recordButton = make("button", { type: "button", click: () => run(true) }, "Record all");
  find("#frames .body").append(slider, make("div", { class: "channels" }, ...fields.map(({ element }, i) =>
    make("label", { class: "channel" }, make("span", {}, ["from", "frame", "to"][i]), element))),
  make("div", { class: "keep" }, playButton, recordButton));
};

export const start = () => {
  find("#save").addEventListener("click", saveScene);
  find("#command").addEventListener("click", copyCommand);
  find("#png").addEventListener("click", savePng);
  find("#record").addEventListener("click", recordOne);
  makeFrames();
  for (const event of ["view", "display"]) on(event, refreshLink);
  on("document", refreshFrames);
};

let begun = false;
on("server:welcome", message => {
  revision = message.revision;
  find("#record-row").hidden = !message.record;
  if (isPhoto()) Object.assign(find("#save"), { textContent: "Save medium", title: "The medium, as --medium and scenes take it (Ctrl+S)" });
  recordButton.hidden = !message.record;
  if (!begun) Object.assign(sequence, { from: 0, to: Math.max(100, frameNow()) });
  begun = true;
  refreshLink();
  refreshFrames();
});
