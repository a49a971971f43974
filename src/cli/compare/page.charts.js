
/* ---- numbers, error against time, stages ---- */

const colorOf = entry => `var(--c${report.images.indexOf(entry) % 8})`;
const dot = entry => make("span", { class: "dot", style: `--of: ${colorOf(entry)}` });

/* Errors without noise are not told from none below a third of the noise, which is not known to a tenth of its square. */
const belowNoise = (entry, channel) => entry[channel].rmse > 0 &&
  3 * entry.relative_rmse_without_noise[channel] < report.reference.relative_noise[channel];

const drawErrors = () => {
  const table = find("#errors"), channels = find("#channels").checked ? ["all", "R", "G", "B"] : ["all"];
  const heads = ["image", ...channels.length > 1 ? ["channel"] : [], "relative RMSE", "without noise", "time",
    "own time", "samples", "mean ratio", "RMSE", "relMSE"];
  const amount = (value, print) => value >= 0 ? print(value) : "";
  const row = (entry, channel) => {
    const errors = entry[channel], left = entry.relative_rmse_without_noise?.[channel], all = channel === "all";
    const cells = [...channels.length > 1 ? [channel] : [], percent(errors.relative_rmse),
      left === undefined ? "" : belowNoise(entry, channel) ? "below noise" : percent(left), all ? amount(entry.seconds, seconds) : "",
      all ? amount(entry.own_seconds, seconds) : "", all && entry.spp > 0 ? samples(entry.spp) : "",
      number(errors.mean_ratio, 4), number(errors.rmse, 4), number(errors.rel_mse)];
    return make("tr", all ? {} : { class: "channel" }, make("td", {}, ...all ? [dot(entry), entry.name] : []),
      ...cells.map(text => make("td", {}, text)));
  };
  table.replaceChildren(
    make("thead", {}, make("tr", {}, ...heads.map(text => make("th", { scope: "col" }, text)))),
    make("tbody", {}, ...report.images.flatMap(entry => channels.map(channel => row(entry, channel)))));
};

const drawSkipped = () => {
  find("#skipped").hidden = report.skipped.length === 0;
  find("#skipped ul").replaceChildren(...report.skipped.map(({ name, reason }) =>
    make("li", {}, make("strong", {}, name), ": " + reason)));
};

const makeSvg = (name, attributes, ...children) => {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
};

/* A logarithmic axis over values, from one pixel to another: its range, with room at the ends, and its ticks. */
const makeAxis = (values, from, to) => {
  const low = Math.log10(Math.min(...values)), high = Math.log10(Math.max(...values));
  const room = Math.max(0.08 * (high - low), 0.12), lower = low - room, upper = high + room;
  const ticks = [];
  for (let decade = Math.floor(lower); decade <= Math.ceil(upper); ++decade)
    for (const step of upper - lower < 2.2 ? [1, 2, 5] : [1]) ticks.push(step * 10 ** decade);
  const place = value => from + (to - from) * (Math.log10(value) - lower) / (upper - lower);
  return { place, ticks: ticks.filter(tick => Math.log10(tick) >= lower && Math.log10(tick) <= upper) };
};

/* Labels beside points, moved down where they would overlap: some 8 pixels a letter. */
const spreadLabels = labels => {
  labels.sort((a, b) => a.y - b.y);
  labels.forEach((label, i) => {
    for (const other of labels.slice(0, i)) {
      const apart = Math.abs(label.x - other.x) > 8 * Math.max(label.name.length, other.name.length);
      if (!apart && label.y < other.y + 15) label.y = other.y + 15;
    }
  });
};

const drawPlot = () => {
  const entries = report.images.map(entry => ({
    entry, points: (entry.error_against_time ?? []).filter(point => point.seconds > 0 && point.relative_rmse > 0),
  })).filter(({ points }) => points.length > 0);
  find("#time").hidden = entries.length === 0;
  if (entries.length === 0) return;
  const width = Math.max(find("#plot").clientWidth, 260), height = Math.min(Math.max(0.5 * width, 260), 460);
  const box = { left: 66, right: width - 60, top: 14, bottom: height - 46 };
  const noise = report.reference.relative_noise?.all;
  const points = entries.flatMap(({ points }) => points);
  const own = entries.flatMap(({ entry }) => entry.own_seconds > 0 ? entry.own_seconds : []);
  const x = makeAxis([...points.map(point => point.seconds), ...own], box.left, box.right);
  const floor = noise > 0 ? [noise] : [];
  const y = makeAxis([...points.map(point => point.relative_rmse), ...floor], box.bottom, box.top);
  const parts = [];
  const text = (attributes, words) => parts.push(makeSvg("text", attributes, words));
  for (const tick of x.ticks) {
    parts.push(makeSvg("line", { class: "grid", x1: x.place(tick), x2: x.place(tick), y1: box.top, y2: box.bottom }));
    text({ x: x.place(tick), y: box.bottom + 18, "text-anchor": "middle" }, seconds(tick));
  }
  for (const tick of y.ticks) {
    parts.push(makeSvg("line", { class: "grid", x1: box.left, x2: box.right, y1: y.place(tick), y2: y.place(tick) }));
    text({ x: box.left - 6, y: y.place(tick) + 4, "text-anchor": "end" }, percent(tick));
  }
  text({ x: (box.left + box.right) / 2, y: height - 6, "text-anchor": "middle" }, "time to the image");
  const middle = (box.top + box.bottom) / 2;
  text({ x: 0, y: 0, transform: `translate(12 ${middle}) rotate(-90)`, "text-anchor": "middle" }, "relative RMSE");
  for (const value of floor) {
    parts.push(makeSvg("line", { class: "floor", x1: box.left, x2: box.right, y1: y.place(value), y2: y.place(value) }));
    text({ x: box.left + 6, y: y.place(value) + 15 }, "noise of the reference");
  }
  const labels = [];
  for (const { entry, points } of entries) {
    const color = colorOf(entry), places = points.map(point => [x.place(point.seconds), y.place(point.relative_rmse)]);
    if (places.length > 1)
      parts.push(makeSvg("polyline",
        { points: places.join(" "), fill: "none", style: `stroke: ${color}`, "stroke-width": 2 }));
    places.forEach(([cx, cy], i) => parts.push(makeSvg("circle",
      { cx, cy, r: i === places.length - 1 ? 6 : 4, style: `fill: ${color}` },
      makeSvg("title", {}, `${entry.name}: ${percent(points[i].relative_rmse)} in ${seconds(points[i].seconds)}` +
        (points[i].spp > 0 ? `, ${samples(points[i].spp)} samples per pixel` : "")))));
    const [px, py] = places[places.length - 1];
    if (entry.own_seconds > 0 && entry.own_seconds < 0.9 * entry.seconds) {
      const own = x.place(entry.own_seconds);
      parts.push(makeSvg("line", { x1: own + 4, x2: px, y1: py, y2: py, style: `stroke: ${color}`, "stroke-width": 1 }),
        makeSvg("circle", { cx: own, cy: py, r: 4, style: `stroke: ${color}`, "stroke-width": 2, fill: "none" },
          makeSvg("title", {}, `${entry.name}: ${seconds(entry.own_seconds)} without the paths' image`)));
    }
    const fits = px + 10 + 8 * entry.name.length < width;
    const side = fits ? { anchor: "start", x: px + 10 } : { anchor: "end", x: px - 10 };
    labels.push({ ...side, y: py + 5, color, name: entry.name });
  }
  spreadLabels(labels);
  for (const { x, y, anchor, color, name } of labels)
    text({ class: "label", x, y, "text-anchor": anchor, style: `fill: ${color}` }, name);
  const says = entries.map(({ entry }) =>
    `${entry.name} ${percent(entry.all.relative_rmse)} in ${seconds(entry.seconds)}`).join(", ");
  const label = "Error against time: " + says;
  find("#plot").replaceChildren(
    makeSvg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label }, ...parts));
  find("#plot-says").textContent = "Both axes are logarithmic. " + (entries.some(({ points }) => points.length > 1)
    ? "Paths: the same render at fewer samples, and at all of them. " : "")
    + "Rings: without the path-traced image that a method takes surfaces from.";
};

const drawStages = () => {
  const entries = report.images.filter(entry => entry.stages !== undefined && entry.seconds > 0);
  find("#stages").hidden = entries.length === 0;
  find("#bars").replaceChildren(...entries.map(entry => {
    const last = Math.max(entry.stages.length - 1, 1);
    const shade = i => `color-mix(in oklab, ${colorOf(entry)} ${100 - 60 * i / last}%, var(--card))`;
    const bar = (stage, i) => make("span", {
      style: `flex: ${stage.seconds / entry.seconds} 0 0; background: ${shade(i)}`,
      title: `${stage.name} ${seconds(stage.seconds)}`,
    });
    return make("div", { class: "method" },
      make("p", {}, make("span", {}, entry.name), make("span", {}, seconds(entry.seconds))),
      make("div", { class: "stack", "aria-hidden": "true" }, ...entry.stages.map(bar)),
      make("ul", {}, ...entry.stages.map((stage, i) => make("li", {},
        make("span", { class: "dot", style: `--of: ${shade(i)}` }), `${stage.name} ${seconds(stage.seconds)}`))));
  }));
};

const drawCommands = () => {
  const entries = [report.reference, ...report.images].filter(entry => entry.command !== undefined);
  find("#again").hidden = entries.length === 0;
  find("#commands").replaceChildren(...entries.map(entry =>
    make("div", { class: "command" }, make("strong", {}, entry.name), make("pre", { tabindex: "0" }, entry.command))));
};

const drawScene = () => {
  find("#scene").hidden = report.scene_text === undefined;
  find("#scene summary").textContent = report.scene + (report.defines ? `, with ${report.defines.join(", ")}` : "");
  find("#scene pre").textContent = report.scene_text ?? "";
};
