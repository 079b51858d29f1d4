// Which method is cheapest for the error that one accepts: over all cases of a study, or in one of them.
const studies = JSON.parse(document.getElementById("measured").textContent);
const form = document.getElementById("chooser");
const { study, which, error } = form.elements;
const found = document.getElementById("found");

function cases() {
  const names = [...new Set(studies[study.value].rows.map((row) => row.case))];
  which.replaceChildren(new Option("every case", ""), ...names.map((name) => new Option(name, name)));
  form.querySelector("#unit").textContent = studies[study.value].unit;
}

function worst(rows) { // of each method and setting, over the cases that it was measured on
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
  return [...methods.values()];
}

function time(ns) {
  const units = [["s", 1e9], ["ms", 1e6], ["us", 1e3], ["ns", 1]];
  const [unit, size] = units.find(([, least]) => ns >= least) ?? units[3];
  return `${(ns / size).toPrecision(3)} ${unit}`;
}

function choose() {
  const rows = studies[study.value].rows.filter((row) => !which.value || row.case === which.value);
  const accepted = Number(error.value);
  if (!(accepted >= 0)) {
    found.replaceChildren("Write the error as a number, such as 1e-9.");
    return;
  }
  const all = new Set(rows.map((row) => row.case)).size;
  const fit = worst(rows).filter((row) => row.cases === all && row.lost === 0 && row.error <= accepted);
  fit.sort((a, b) => a.ns - b.ns);
  const table = document.createElement("table");
  table.insertRow().append(...["method", "setting", "largest error", "time per item"].map((text) => {
    const head = document.createElement("th");
    head.textContent = text;
    return head;
  }));
  for (const row of fit.slice(0, 8)) {
    const line = table.insertRow();
    for (const text of [row.method, row.setting, row.error.toExponential(1), time(row.ns)]) line.insertCell().textContent = text;
  }
  found.replaceChildren(fit.length ? table : "No method that was measured is so exact without losing an answer.");
}

study.append(...Object.entries(studies).map(([name, each]) => new Option(each.title, name)));
study.addEventListener("change", () => { cases(); choose(); });
which.addEventListener("change", choose);
error.addEventListener("input", choose);
cases();
choose();
document.body.dataset.state = "ready";
