// Which method is cheapest for the error that one accepts: over all cases of a study, or in one of them.
const studies = JSON.parse(document.getElementById("measured").textContent);
const form = document.getElementById("chooser");
const { study, which, error } = form.elements;
const found = document.getElementById("found");
const drawing = document.getElementById("drawing");
const colors = drawing.dataset.colors.split(" ");
const SMALLEST = 1e-18; // errors of zero are drawn there
const NOISE = 1.1; // times that are nearer to each other are not told apart

function element(name, attributes = {}, text = "") {
  const space = { svg: 1, path: 1, line: 1, circle: 1, text: 1, title: 1 }[name] ? "http://www.w3.org/2000/svg" : "http://www.w3.org/1999/xhtml";
  const made = document.createElementNS(space, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(text);
  return made;
}

function cases() {
  const names = [...new Set(studies[study.value].rows.map((row) => row.case))];
  which.replaceChildren(new Option("every case", ""), ...names.map((name) => new Option(name, name)));
  form.querySelector("#unit").textContent = studies[study.value].unit;
}

function worst(rows) { // of each method and setting that was measured on all cases
  const methods = new Map();
  for (const row of rows) {
    const key = `${row.method}\n${row.setting}`;
    const so_far = methods.get(key) ?? { ...row, cases: 0, error: 0, ns: 0, lost: 0 };
    so_far.cases += 1;
    so_far.error = Math.max(so_far.error, row.error ?? Infinity);
    so_far.ns = Math.max(so_far.ns, row.ns);
    so_far.lost += row.lost;
    methods.set(key, so_far);
  }
  const all = new Set(rows.map((row) => row.case)).size;
  return [...methods.values()].filter((row) => row.cases === all);
}

function time(ns) {
  const units = [["s", 1e9], ["ms", 1e6], ["us", 1e3], ["ns", 1]];
  const [unit, size] = units.find(([, least]) => ns >= least) ?? units[3];
  return `${(ns / size).toPrecision(3)} ${unit}`;
}

function tabulated(rows) {
  const table = element("table", { class: "table" });
  table.createTHead().insertRow().append(...["method", "setting", "largest error", "time per item"].map((text) => element("th", {}, text)));
  const body = table.createTBody();
  for (const row of rows) {
    const line = body.insertRow();
    for (const text of [row.method, row.setting, row.error.toExponential(1), time(row.ns)]) line.insertCell().textContent = text;
  }
  return table;
}

function choose() {
  const rows = worst(studies[study.value].rows.filter((row) => !which.value || row.case === which.value));
  const accepted = Number(error.value);
  draw(rows, accepted);
  if (!(accepted >= 0)) {
    found.replaceChildren("Write the error as a number, such as 1e-9.");
    return;
  }
  const fit = rows.filter((row) => row.lost === 0 && row.error <= accepted).sort((a, b) => a.ns - b.ns);
  if (!fit.length) {
    found.replaceChildren("No method that was measured is so exact without losing an answer.");
    return;
  }
  const shown = fit.slice(0, 8);
  const equals = shown.filter((row) => row.ns < NOISE * shown[0].ns).length;
  const note = element("p", {}, `The first ${equals} differ by less than a tenth: within what such times vary by.`);
  found.replaceChildren(tabulated(shown), ...(equals > 1 ? [note] : []));
}

function draw(rows, accepted) { // error against time, both logarithmic; a line for each method, hollow where answers are lost
  const shown = rows.filter((row) => Number.isFinite(row.error));
  drawing.replaceChildren();
  if (!shown.length) return;
  const [width, height, left, right, top, bottom] = [Math.min(drawing.clientWidth || 640, 760), 340, 52, 28, 14, 44];
  const scale = (values, from, to) => {
    const [low, high] = [Math.floor(Math.log10(Math.min(...values)) - 0.2), Math.ceil(Math.log10(Math.max(...values)) + 0.2)];
    const step = Math.ceil((high - low) / (Math.abs(to - from) / 44));
    const ticks = Array.from({ length: Math.floor((high - low) / step) + 1 }, (_, i) => low + i * step);
    return { at: (value) => from + (to - from) * (Math.log10(value) - low) / (high - low), ticks };
  };
  const height_of = (row) => Math.max(row.error, SMALLEST);
  const x = scale(shown.map((row) => row.ns), left, width - right);
  const y = scale(shown.map(height_of), height - bottom, top);
  const svg = element("svg", { width, height, style: "max-width: 100%", role: "img", "aria-label": "Largest error against time per item", fill: "currentColor", "font-size": 12 });
  const note = (text, where) => svg.append(element("text", { "text-anchor": "middle", ...where }, text));
  const rule = (ends, look) => svg.append(element("line", { stroke: "currentColor", "stroke-opacity": 0.15, ...ends, ...look }));
  for (const tick of x.ticks) {
    const at = x.at(10 ** tick);
    rule({ x1: at, x2: at, y1: top, y2: height - bottom });
    note(time(10 ** tick).replace(/\.0+ /, " "), { x: at, y: height - bottom + 16 });
  }
  for (const tick of y.ticks) {
    const at = y.at(10 ** tick);
    rule({ x1: left, x2: width - right, y1: at, y2: at });
    note(`1e${tick}`, { x: left - 6, y: at + 4, "text-anchor": "end" });
  }
  note("largest error", { x: left + 6, y: top + 12, "text-anchor": "start" });
  note("time per item", { x: (left + width - right) / 2, y: height - 8 });
  if (accepted > 0 && y.at(accepted) > top && y.at(accepted) < height - bottom) {
    rule({ x1: left, x2: width - right, y1: y.at(accepted), y2: y.at(accepted) }, { "stroke-opacity": 0.8, "stroke-dasharray": "6 4" });
  }
  const key = element("p", { style: "font-size: 0.85em" });
  for (const [number, method] of [...new Set(shown.map((row) => row.method))].entries()) {
    const color = colors[number % colors.length];
    const points = shown.filter((row) => row.method === method);
    const way = points.map((row) => `${x.at(row.ns)},${y.at(height_of(row))}`).join("L");
    svg.append(element("path", { d: `M${way}`, fill: "none", stroke: color, "stroke-dasharray": number < colors.length ? "none" : "3 3" }));
    for (const row of points) {
      const mark = { cx: x.at(row.ns), cy: y.at(height_of(row)), r: 4.5, stroke: color, fill: row.lost ? "none" : color };
      const said = `${row.method} ${row.setting}: ${row.error.toExponential(1)}, ${time(row.ns)}${row.lost ? `, ${row.lost} lost` : ""}`;
      const dot = element("circle", mark);
      dot.append(element("title", {}, said));
      svg.append(dot);
    }
    const entry = element("span", { style: "white-space: nowrap; margin-right: 1.2em" });
    entry.append(element("span", { style: `color: ${color}`, "aria-hidden": "true" }, number < colors.length ? "● " : "◍ "), method);
    key.append(entry, " ");
  }
  drawing.append(svg, key);
}

study.append(...Object.entries(studies).map(([name, each]) => new Option(each.title, name)));
study.addEventListener("change", () => { cases(); choose(); });
which.addEventListener("change", choose);
error.addEventListener("input", choose);
window.addEventListener("resize", choose);
cases();
choose();
document.body.dataset.state = "ready";
