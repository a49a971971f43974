/* The line at the bottom: connection, stage, errors against path, times. And troubles that are to be read. */

import { find, make, makeSvg, milliseconds, percent, shown } from "./dom.js";
import { connect } from "./link.js";
import { showRefusal } from "./panels.js";
import { emit, methodShown, on, state } from "./state.js";

const STAGES = ["load", "solve", "surfaces", "view", "encode"];

const showConnection = () => {
  const { connection } = state;
  document.body.dataset.connection = connection;
  find("#connection b").textContent = { connecting: "connecting", open: "connected", lost: "disconnected" }[connection];
  const lost = find("#lost");
  lost.hidden = connection !== "lost";
  if (connection !== "lost") return;
  const seconds = Math.max(0, Math.ceil((state.retryAt - performance.now()) / 1000));
  lost.querySelector("strong").textContent = "No connection to tyndall view";
  lost.querySelector("p").textContent = `The last image stays. ${seconds > 0 ? `Next attempt in ${seconds} s.` : "Connecting …"}`
    + " If the viewer was started anew, open the address that it printed.";
};

/* A bar of the stages' times, and in words the ones that matter. */
const showTimes = (times = {}) => {
  const own = Object.entries(times).filter(([name, value]) => name !== "latency" && typeof value === "number" && value > 0);
  own.sort(([a], [b]) => STAGES.indexOf(a) - STAGES.indexOf(b));
  const total = own.reduce((sum, [, value]) => sum + value, 0);
  let from = 0;
  find("#times svg").replaceChildren(...own.map(([name, value]) => {
    const width = 100 * value / total, bar = makeSvg("rect", { x: from, y: 0, width, height: 6,
      class: `time-${Math.max(STAGES.indexOf(name), -1) + 1}` });
    from += width;
    return bar;
  }));
  find("#times span").replaceChildren(...own.map(([name, value]) =>
    make("span", { class: "time" }, make("i", { class: `time-${STAGES.indexOf(name) + 1}` }), `${name.replaceAll("_", " ")} ${milliseconds(value)}`)));
  const stages = Object.entries(times.stages ?? {}).filter(([, value]) => value > 0);
  find("#times").title = [...own, ...stages].map(([name, value]) => `${name.replaceAll("_", " ")} ${milliseconds(value)}`).join("\n");
  find("#times").hidden = own.length === 0;
};

const figure = (word, value, after = "") => make("span", { class: "figure" }, word, make("b", {}, value), after);

const differenceText = ({ mean_ratio, rmse, noise }) => [make("span", { class: "against" }, `${methodShown()} : path`),
  figure("mean ", mean_ratio.toFixed(3)), figure("RMSE ", percent(rmse)), figure("of it noise ", percent(noise))];

const showStatus = () => {
  const { status, view } = state;
  if (status === null) return;
  find("#stage-now").textContent = [status.method ?? view.method, `revision ${status.revision}`,
    view.paused ? "paused" : status.final ? "final" : status.stage].filter(Boolean).join(" · ");
  const running = !view.paused && !status.final && status.fraction > 0 && status.fraction < 1;
  find("#progress").hidden = !running;
  if (running) find("#progress").value = status.fraction;
  find("#message").textContent = status.message ?? "";
  find("#message").hidden = !status.message;
  const { path } = status, seen = view.compare && path && path.spp > 0;
  find("#path-state").hidden = !seen;
  if (seen)
    find("#path-state").replaceChildren(figure("path ", `${shown(path.spp, 6)} spp`),
      ...path.error > 0 ? [figure("error ", percent(path.error))] : []);
  const known = view.compare && status.difference;
  find("#difference").hidden = !known;
  if (known) find("#difference").replaceChildren(...differenceText(status.difference));
  showTimes(status.times);
  const latency = status.times?.latency;
  find("#speed").replaceChildren(...status.fps > 0 ? [figure("", shown(status.fps, 3), " fps")] : [],
    ...latency > 0 ? [figure("latency ", milliseconds(latency))] : []);
};

/* ---- troubles ---- */

/* A line beside the control it is about, or else over the page; it stays until it is dismissed. */
const showTrouble = ({ text, path }) => {
  if (path && showRefusal(path, text)) return;
  const list = find("#troubles");
  if ([...list.children].some(line => line.dataset.text === text)) return;
  const line = make("p", { "data-text": text }, text, make("button", { type: "button", "aria-label": "Dismiss", click: () => line.remove() }, "×"));
  list.append(line);
  while (list.children.length > 4) list.firstChild.remove();
};

let timer = 0;
/* A few words over the image, for a moment. */
export const notice = text => {
  const line = find("#notice");
  line.textContent = text;
  line.hidden = false;
  clearTimeout(timer);
  timer = setTimeout(() => line.hidden = true, 1600);
};

export const start = () => {
  find("#lost button").addEventListener("click", connect);
  on("connection", showConnection);
  on("view", showStatus);
  on("trouble", showTrouble);
  setInterval(() => {
    if (state.connection === "lost") showConnection();
  }, 500);
  showConnection();
};

on("server:status", message => {
  const before = methodShown();
  state.status = message;
  if (methodShown() !== before) emit("view");
  else showStatus();
});
