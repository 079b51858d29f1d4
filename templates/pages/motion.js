"use strict";
// Bodies in motion on a 2D canvas: triangles, edges and paths in one list, the farthest first.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const canvas = document.getElementById("stage");
  const element = (name) => document.getElementById(name);
  const LIGHT = [-0.371, -0.557, 0.743], SHADE = 0.55, SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];

  const TYPES = { f4: Float32Array, f8: Float64Array, u2: Uint16Array, u4: Uint32Array };
  const unpacked = (entry) => {
    const text = atob(entry.bdata), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return new TYPES[entry.dtype](bytes.buffer);
  };
  const time = unpacked(data.time), energy = unpacked(data.energy), violation = unpacked(data.violation);
  const bodies = data.bodies.map((b) => ({
    color: rgb(b.color), vertices: unpacked(b.vertices), faces: unpacked(b.faces), edges: unpacked(b.edges), poses: unpacked(b.poses),
  }));
  const traces = data.traces.map((t) => ({ color: t.color, points: unpacked(t.points) }));
  const objects = data.objects.map(unpacked);
  const last = time.length - 1, start = time[0], end = time[last];

  let now = start, playing = !matchMedia("(prefers-reduced-motion: reduce)").matches && last > 0, trails = true;
  let factor = 1, before = 0;

  function rgb(code) { return [1, 3, 5].map((i) => parseInt(code.slice(i, i + 2), 16)); }

  // -- what is drawn ---------------------------------------------------------------------------------------------
  function place() {  // the stored state before now, and the share of the way to the next one
    let low = 0, high = last;
    while (high - low > 1) { const mid = (low + high) >> 1; if (time[mid] <= now) low = mid; else high = mid; }
    const span = time[high] - time[low];
    return [low, span > 0 ? Math.min(1, Math.max(0, (now - time[low]) / span)) : 0];
  }
  function pose(body, low, share) {
    const found = new Float64Array(12), next = Math.min(low + 1, last);
    for (let i = 0; i < 12; i++) found[i] = (1 - share) * body.poses[12 * low + i] + share * body.poses[12 * next + i];
    return found;
  }
  function moved(body, p) {
    const from = body.vertices, to = new Float64Array(from.length);
    for (let i = 0; i < from.length; i += 3) {
      const x = from[i], y = from[i + 1], z = from[i + 2];
      for (let k = 0; k < 3; k++) to[i + k] = p[4 * k] * x + p[4 * k + 1] * y + p[4 * k + 2] * z + p[4 * k + 3];
    }
    return to;
  }
  function addBody(list, body, low, share) {
    const at = moved(body, pose(body, low, share)), shown = [];
    for (let i = 0; i < at.length; i += 3) shown.push(project(at[i], at[i + 1], at[i + 2]));
    for (let f = 0; f < body.faces.length; f += 3) {
      const [i, j, k] = [body.faces[f], body.faces[f + 1], body.faces[f + 2]], [a, b, c] = [shown[i], shown[j], shown[k]];
      if ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) >= 0) continue;  // it faces away
      const u = [0, 1, 2].map((n) => at[3 * j + n] - at[3 * i + n]), v = [0, 1, 2].map((n) => at[3 * k + n] - at[3 * i + n]);
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      const size = Math.hypot(...n) || 1, bright = SHADE + (1 - SHADE) * (1 + dot(LIGHT, ...n) / size) / 2;
      list.push({ near: (a[2] + b[2] + c[2]) / 3, corners: [a, b, c], fill: `rgb(${body.color.map((x) => Math.round(x * bright)).join(",")})` });
    }
    const lift = 0.004 * data.size, dark = `rgb(${body.color.map((x) => Math.round(0.55 * x)).join(",")})`;
    for (let e = 0; e < body.edges.length; e += 2) {
      const a = shown[body.edges[e]], b = shown[body.edges[e + 1]];
      list.push({ near: (a[2] + b[2]) / 2 + lift, from: a, to: b, stroke: dark, width: body.faces.length ? 1 : 2.5 });
    }
  }
  function paint(list, ratio) {
    const [low, share] = place();
    for (const line of objects) stage.addLine(list, line, 0, line.length / 3, "#8a97a3", 1.2 * ratio);
    for (const trace of traces) {
      if (trails) stage.addLine(list, trace.points, 0, low + 1, trace.color, 2 * ratio);
      const next = Math.min(low + 1, last), p = [0, 1, 2].map((k) => (1 - share) * trace.points[3 * low + k] + share * trace.points[3 * next + k]);
      const a = project(...[0, 1, 2].map((k) => trace.points[3 * low + k])), b = project(...p);
      if (trails) list.push({ near: b[2], from: a, to: b, stroke: trace.color, width: 2 * ratio });
      list.push({ near: b[2] + 0.01 * data.size, dot: b, fill: trace.color, radius: 4 * ratio });
    }
    for (const body of bodies) addBody(list, body, low, share);
    return () => said(low, share);
  }
  function said(low, share) {
    const next = Math.min(low + 1, last), mix = (x) => (1 - share) * x[low] + share * x[next];
    element("clock").textContent = `t = ${now.toFixed(data.digits)} ${data.units.time}`;
    element("energy").textContent = `energy ${(data.energy_start + mix(energy)).toPrecision(6)} ${data.units.energy} (${mix(energy).toExponential(1)} since the start)`;
    element("violation").textContent = data.held ? `violation ${violation[low].toExponential(1)}` : "";
    element("time").value = end > start ? 1000 * (now - start) / (end - start) : 0;
  }

  const stage = createStage(canvas, data, paint, 96);
  const { project, dot, view } = stage;

  // -- what the reader does --------------------------------------------------------------------------------------
  function play(on) {
    if (on && now >= end) now = start;
    playing = on; before = 0; stage.refresh();
    element("play").textContent = on ? "Pause" : "Play";
  }
  function tick(stamp) {
    if (playing) {
      if (before) now += Math.min(0.1, (stamp - before) / 1000) * data.speed * factor;
      before = stamp; stage.refresh();
      if (now >= end) { now = end; play(false); }
    }
  }
  element("play").onclick = () => play(!playing);
  element("home").onclick = () => { Object.assign(view, stage.home); stage.refresh(); };
  element("trails").onclick = (event) => { trails = !trails; event.currentTarget.setAttribute("aria-pressed", trails); stage.refresh(); };
  element("time").oninput = (event) => { play(false); now = start + event.target.value / 1000 * (end - start); stage.refresh(); };
  for (const value of SPEEDS) {
    const option = document.createElement("option");
    option.value = value; option.textContent = `${value}x`; option.selected = value === 1;
    element("speed").append(option);
  }
  element("speed").onchange = (event) => { factor = Number(event.target.value); };
  for (const trace of data.traces) if (trace.label) {
    const item = document.createElement("li");
    item.textContent = trace.label; item.style.setProperty("--color", trace.color);
    element("legend").append(item);
  }
  canvas.addEventListener("keydown", (event) => { if (event.key === " ") { play(!playing); event.preventDefault(); } });
  window.bladesmith = { show: (t) => { play(false); now = t; stage.frame(); }, view, states: last + 1 };
  play(playing);
  stage.frame();
  stage.tick = tick;
  document.body.dataset.state = "ready";
})();
