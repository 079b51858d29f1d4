"use strict";
// Bodies in motion on a 2D canvas: triangles, edges and paths in one list, the farthest first.
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const canvas = document.getElementById("stage");
  const ink = canvas.getContext("2d");
  const element = (name) => document.getElementById(name);
  const LIGHT = [-0.371, -0.557, 0.743], SHADE = 0.55, EYE = 4.5, SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];

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

  const home = { azimuth: data.view[1], elevation: data.view[0], zoom: 1 };
  const view = { ...home };
  let now = start, playing = !matchMedia("(prefers-reduced-motion: reduce)").matches && last > 0, trails = true;
  let factor = 1, before = 0, stale = true;

  function rgb(code) { return [1, 3, 5].map((i) => parseInt(code.slice(i, i + 2), 16)); }

  // -- from space to the page --------------------------------------------------------------------------------
  let right, up, toward, scale, middle;
  function aim() {
    const a = view.azimuth * Math.PI / 180, e = view.elevation * Math.PI / 180;
    const ca = Math.cos(a), sa = Math.sin(a), ce = Math.cos(e), se = Math.sin(e);
    right = [-sa, ca, 0]; up = [-se * ca, -se * sa, ce]; toward = [ce * ca, ce * sa, se];
    scale = Math.min(canvas.width, canvas.height * 0.86) * 0.98 * view.zoom / data.size;
    middle = [canvas.width / 2, canvas.height * 0.48];
  }
  const dot = (u, x, y, z) => u[0] * x + u[1] * y + u[2] * z;
  function project(x, y, z) {  // page coordinates, and how near it is
    const near = dot(toward, x, y, z), grow = scale * EYE / Math.max(EYE - near / data.size, 0.2);
    return [middle[0] + grow * dot(right, x, y, z), middle[1] - grow * dot(up, x, y, z), near];
  }

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
  function addLine(list, points, count, stroke, width) {
    let a = null;
    for (let i = 0; i < count; i++) {
      const x = points[3 * i], y = points[3 * i + 1], z = points[3 * i + 2];
      const b = Number.isFinite(x + y + z) ? project(x, y, z) : null;
      if (a && b) list.push({ near: (a[2] + b[2]) / 2, from: a, to: b, stroke, width });
      a = b;
    }
    return a;
  }
  function frame() {
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    aim();
    ink.clearRect(0, 0, width, height);
    ink.lineCap = ink.lineJoin = "round";
    box(ratio);
    const [low, share] = place(), list = [];
    for (const line of objects) addLine(list, line, line.length / 3, "#8a97a3", 1.2 * ratio);
    for (const trace of traces) {
      if (trails) addLine(list, trace.points, low + 1, trace.color, 2 * ratio);
      const next = Math.min(low + 1, last), p = [0, 1, 2].map((k) => (1 - share) * trace.points[3 * low + k] + share * trace.points[3 * next + k]);
      const a = project(...[0, 1, 2].map((k) => trace.points[3 * low + k])), b = project(...p);
      if (trails) list.push({ near: b[2], from: a, to: b, stroke: trace.color, width: 2 * ratio });
      list.push({ near: b[2] + 0.01 * data.size, dot: b, fill: trace.color, radius: 4 * ratio });
    }
    for (const body of bodies) addBody(list, body, low, share);
    list.sort((a, b) => a.near - b.near);
    list.forEach(draw);
    triad(ratio);
    said(low, share);
  }
  function draw(part) {
    ink.beginPath();
    if (part.corners) {
      const [a, b, c] = part.corners;
      ink.moveTo(a[0], a[1]); ink.lineTo(b[0], b[1]); ink.lineTo(c[0], c[1]); ink.closePath();
      ink.fillStyle = ink.strokeStyle = part.fill; ink.lineWidth = 0.7; ink.fill(); ink.stroke();
    } else if (part.dot) {
      ink.arc(part.dot[0], part.dot[1], part.radius, 0, 2 * Math.PI); ink.fillStyle = part.fill; ink.fill();
    } else {
      ink.moveTo(part.from[0], part.from[1]); ink.lineTo(part.to[0], part.to[1]);
      ink.strokeStyle = part.stroke; ink.lineWidth = part.width; ink.stroke();
    }
  }
  function box(ratio) {  // the edges of the view's box, in pale
    const h = data.half;
    ink.strokeStyle = "#dde3e8"; ink.lineWidth = ratio;
    for (let i = 0; i < 8; i++) for (const bit of [1, 2, 4]) if (!(i & bit)) {
      const corner = (n) => project(n & 1 ? h[0] : -h[0], n & 2 ? h[1] : -h[1], n & 4 ? h[2] : -h[2]);
      const a = corner(i), b = corner(i | bit);
      ink.beginPath(); ink.moveTo(a[0], a[1]); ink.lineTo(b[0], b[1]); ink.stroke();
    }
  }
  function triad(ratio) {  // the directions of the axes, in the lower left corner
    const x = 52 * ratio, y = canvas.height - 96 * ratio, size = 30 * ratio;
    ink.font = `${12 * ratio}px system-ui, sans-serif`; ink.textAlign = "center"; ink.textBaseline = "middle"; ink.lineWidth = 2 * ratio;
    ["x", "y", "z"].forEach((name, i) => {
      const px = size * right[i], py = -size * up[i];
      ink.strokeStyle = ink.fillStyle = ["#c8402f", "#2f9461", "#2c6fbb"][i];
      ink.beginPath(); ink.moveTo(x, y); ink.lineTo(x + px, y + py); ink.stroke(); ink.fillText(name, x + 1.35 * px, y + 1.35 * py);
    });
  }
  function said(low, share) {
    const next = Math.min(low + 1, last), mix = (x) => (1 - share) * x[low] + share * x[next];
    element("clock").textContent = `t = ${now.toFixed(data.digits)} ${data.units.time}`;
    element("energy").textContent = `energy ${(data.energy_start + mix(energy)).toPrecision(6)} ${data.units.energy} (${mix(energy).toExponential(1)} since the start)`;
    element("violation").textContent = data.held ? `violation ${violation[low].toExponential(1)}` : "";
    element("time").value = end > start ? 1000 * (now - start) / (end - start) : 0;
  }

  // -- what the reader does --------------------------------------------------------------------------------------
  function play(on) {
    if (on && now >= end) now = start;
    playing = on; before = 0; stale = true;
    element("play").textContent = on ? "Pause" : "Play";
  }
  function tick(stamp) {
    if (playing) {
      if (before) now += Math.min(0.1, (stamp - before) / 1000) * data.speed * factor;
      before = stamp; stale = true;
      if (now >= end) { now = end; play(false); }
    }
    if (stale) { stale = false; frame(); }
    requestAnimationFrame(tick);
  }
  element("play").onclick = () => play(!playing);
  element("home").onclick = () => { Object.assign(view, home); stale = true; };
  element("trails").onclick = (event) => { trails = !trails; event.currentTarget.setAttribute("aria-pressed", trails); stale = true; };
  element("time").oninput = (event) => { play(false); now = start + event.target.value / 1000 * (end - start); stale = true; };
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
  let held = null;
  canvas.onpointerdown = (event) => { held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId); };
  canvas.onpointermove = (event) => {
    if (!held) return;
    view.azimuth -= 0.4 * (event.clientX - held[0]);
    view.elevation = Math.max(-90, Math.min(90, view.elevation + 0.4 * (event.clientY - held[1])));
    held = [event.clientX, event.clientY]; stale = true;
  };
  canvas.onpointerup = canvas.onpointercancel = () => { held = null; };
  const zoom = (by) => { view.zoom = Math.max(0.1, Math.min(40, view.zoom * by)); stale = true; };
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(-0.0012 * event.deltaY)); }, { passive: false });
  canvas.onkeydown = (event) => {
    const turn = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] }[event.key];
    if (turn) { view.azimuth += turn[0]; view.elevation = Math.max(-90, Math.min(90, view.elevation + turn[1])); stale = true; }
    else if (event.key === " ") play(!playing);
    else if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? 1.15 : 1 / 1.15);
    else return;
    event.preventDefault();
  };
  window.addEventListener("resize", () => { stale = true; });
  window.bladesmith = { show: (t) => { play(false); now = t; frame(); }, view, states: last + 1 };
  play(playing);
  frame();
  requestAnimationFrame(tick);
  document.body.dataset.state = "ready";
})();
