// The front end of `bladesmith.plot.show`, after stage.js: draws what Python sends, and sends sliders and dragged points back.
// One question is on the way at a time; what the reader does meanwhile goes into the next one.
// Each object is a value of the model of its own, which is sent only when it has changed.
const REACH = 16, HANDLE = 7;

function decoded(parts) {
  const array = (view, Type) => new Type(view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength));
  return parts.map((part) => {
    const rows = array(part.colors, Uint8Array), colors = [];
    for (let i = 0; i < rows.length; i += 4) colors.push(`rgba(${rows[i]},${rows[i + 1]},${rows[i + 2]},${rows[i + 3] / 255})`);
    return { ...part, positions: array(part.positions, Float32Array), colors, clear: rows[3] < 255 };
  });
}

function render({ model, el }) {
  const setup = model.get("setup"), make = (tag, more) => Object.assign(document.createElement(tag), more);
  const canvas = make("canvas", { tabIndex: 0 }), controls = make("div"), note = make("div");
  canvas.style.cssText = `display: block; width: 100%; height: ${setup.height}px; touch-action: none; cursor: grab; background: #fbfcfd`;
  controls.style.cssText = "display: flex; flex-wrap: wrap; gap: 4px 20px; font: 14px system-ui, sans-serif; padding: 4px 8px";
  note.style.cssText = "color: #c8402f; font: 13px system-ui, sans-serif; padding: 0 8px; white-space: pre-wrap";
  note.setAttribute("role", "status");
  el.append(canvas, controls, note);

  const inputs = structuredClone(model.get("inputs"));
  let frame = model.get("frame"), objects = [], waiting = false, changed = false, drawn = 0, shown = -1;
  function read() {  // an object that was not sent again is as it was decoded
    const known = (i) => { const sent = model.get(`object${i}`); return objects[i]?.sent === sent ? objects[i] : { sent, parts: decoded(sent) }; };
    objects = Array.from({ length: frame.objects }, (_, i) => known(i));
  }
  read();
  function send() {
    changed = waiting;
    if (waiting) return;
    waiting = true;
    inputs.number += 1;
    model.set("inputs", structuredClone(inputs));
    model.save_changes();
  }
  function receive() {
    frame = model.get("frame");
    read();
    note.textContent = frame.error;
    if (frame.number >= inputs.number) {
      inputs.number = frame.number;
      waiting = false;
      if (changed) send();
    }
    stage.refresh();
  }
  model.on("change:frame", receive);

  for (const { name, low, high } of setup.sliders) {
    const label = make("label"), value = make("span"), input = make("input", { type: "range", min: low, max: high, step: (high - low) / 1000 });
    const say = () => { value.textContent = ` ${Number(inputs.sliders[name]).toPrecision(3)}`; };
    input.value = inputs.sliders[name]; input.name = name;
    input.oninput = () => { inputs.sliders[name] = Number(input.value); say(); send(); };
    say();
    label.append(`${name} `, input, value);
    controls.append(label);
  }

  const placed = (name) => stage.project(...inputs.points[name].map((x, k) => x - setup.center[k]));
  function paint(list, ratio) {
    for (const { kind, count, corners, positions, colors, size, clear } of objects.flatMap((object) => object.parts)) {
      const color = (i) => colors[colors.length === 1 ? 0 : i];
      for (let i = 0; i < count; i++) {
        if (kind === "strokes") stage.addLine(list, positions, corners * i, corners * (i + 1), color(i), size * ratio);
        else {
          const at = [];
          for (let j = 3 * corners * i; j < 3 * corners * (i + 1); j += 3) at.push(stage.project(positions[j], positions[j + 1], positions[j + 2]));
          const near = at.reduce((sum, c) => sum + c[2], 0) / corners;
          if (kind === "marks") list.push({ near, dot: at[0], fill: color(i), radius: size * ratio });
          else list.push({ near, corners: at, fill: color(i), clear });
        }
      }
    }
    setup.points.forEach((name) => {
      const dot = placed(name);
      list.push({ near: Infinity, dot, fill: "#22303c", radius: HANDLE * ratio }, { near: Infinity, dot, fill: "#ffffff", radius: (HANDLE - 2.5) * ratio });
    });
    return () => { if (shown !== frame.number) { shown = frame.number; drawn += 1; } };
  }
  const stage = createStage(canvas, setup, paint, 40);
  stage.grab = (x, y) => {
    const reach = REACH * (window.devicePixelRatio || 1);
    const distance = (name) => { const p = placed(name); return Math.hypot(p[0] - x, p[1] - y); };
    const name = setup.points.filter((n) => distance(n) < reach).sort((a, b) => distance(a) - distance(b))[0];
    if (name === undefined) return null;
    const near = placed(name)[2];
    return (px, py) => {  // across the direction of the view
      inputs.points[name] = stage.unproject(px, py, near).map((v, k) => v + setup.center[k]);
      send();
      stage.refresh();
    };
  };
  el.bladesmith = { placed, draw: stage.frame, view: stage.view, inputs, drawn: () => drawn, frame: () => frame };
  return () => { stage.stop(); model.off("change:frame", receive); };
}

export default { render };
