
/* ---- what the reader does ---- */

const drawHeader = () => {
  const { reference } = report;
  find("#title").textContent = report.scene ?? "Images";
  find("#about").textContent = `Reference: ${reference.source}`
    + (reference.spp > 0 ? `, ${samples(reference.spp)} samples per pixel` : "")
    + (reference.seconds >= 0 ? `, ${seconds(reference.seconds)}` : "")
    + (reference.stored ? ", of this and earlier runs" : "")
    + `. ${report.width} × ${report.height} pixels.`;
  find("#noise").hidden = !reference.noise_is;
  find("#noise").textContent = reference.noise_is ?? "";
  find("#made").textContent = `Tyndall ${report.version}. Exposure ${number(report.exposure)} stops at first.`;
  if (report.shrink > 1) find("#means").textContent = ` Each pixel here is the mean of ${report.shrink} × ${report.shrink}.`;
};

const change = changes => {
  Object.assign(view, changes);
  refresh().catch(fail);
};
const fail = error => {
  find("#trouble").hidden = false;
  find("#trouble").textContent =
    `This browser cannot show the images (${error.message}). The numbers below are right all the same.`;
};
const flip = () => change(view.mode === "flip" ? { flipped: !view.flipped } : { mode: "flip", flipped: true });
const swap = () => change({ left: view.right, right: view.left });
const expose = stops => change({ exposure: Math.min(Math.max(stops, -12), 12) });

const listen = () => {
  const on = (selector, event, action) => find(selector).addEventListener(event, action);
  on("#left", "change", event => change({ left: images[event.target.value] }));
  on("#right", "change", event => change({ right: images[event.target.value] }));
  on("#swap", "click", swap);
  on("#flip", "click", flip);
  for (const radio of document.querySelectorAll("input[name=mode]"))
    radio.addEventListener("change", () => change({ mode: radio.value, flipped: false }));
  on("#cut", "input", event => change({ cut: Number(event.target.value) }));
  on("#display", "change", event => change({ display: event.target.value }));
  on("#exposure", "input", event => change({ exposure: Number(event.target.value) }));
  on("#reset", "click", () => change({ exposure: report.exposure }));
  on("#range", "change", event => change({ range: Number(event.target.value) }));
  on("#channels", "change", drawErrors);
};

/* Where the pointer is on the image, 0..1. */
const pointerPlace = event => {
  const box = canvas.getBoundingClientRect();
  return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
};

const listenToPointer = () => {
  let moved = false;
  const follow = event => {
    const [u, v] = pointerPlace(event);
    moveTo(Math.floor(u * columns), Math.floor(v * rows));
    if (event.buttons !== 1 || view.mode !== "slider" || view.display === "error") return;
    change({ cut: Math.min(Math.max(100 * u, 0), 100) });
  };
  stage.addEventListener("pointerdown", event => {
    moved = false;
    stage.setPointerCapture(event.pointerId);
    follow(event);
  });
  stage.addEventListener("pointermove", event => {
    moved = true;
    follow(event);
  });
  stage.addEventListener("click", () => {
    if (!moved && view.mode === "flip" && view.display !== "error") flip();
  });
};

const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

const press = event => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const digit = /^(?:Digit|Numpad)([1-9])$/.exec(event.code);
  const step = event.shiftKey ? 10 : 1;
  if (event.key in moves) {
    moveTo(view.x + step * moves[event.key][0], view.y + step * moves[event.key][1]);
    sayReading();
  } else if (digit !== null && images[digit[1] - 1] !== undefined) {
    change({ [event.shiftKey ? "left" : "right"]: images[digit[1] - 1] });
  } else if (event.key === "f" || event.key === "F" || event.key === " ") flip();
  else if (event.key === "s" || event.key === "S") swap();
  else if (event.key === "+" || event.key === "=") expose(view.exposure + 0.5);
  else if (event.key === "-") expose(view.exposure - 0.5);
  else if (event.key === "0") expose(report.exposure);
  else return;
  event.preventDefault();
};

const begin = () => {
  canvas.width = columns;
  canvas.height = rows;
  stage.style.setProperty("--aspect", columns / rows);
  for (const id of ["#left", "#right"])
    find(id).replaceChildren(...images.map(({ name, index, entry }) => make("option", { value: index },
      entry.all ? `${name} (${percent(entry.all.relative_rmse, 2)})` : name)));
  drawHeader();
  drawErrors();
  drawSkipped();
  drawStages();
  drawCommands();
  drawScene();
  drawPlot();
  addEventListener("resize", drawPlot);
  listen();
  listenToPointer();
  canvas.addEventListener("keydown", press);
  change({});
};
begin();
