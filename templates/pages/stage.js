"use strict";
// Space on a 2D canvas, for pages and widgets: triangles, edges and lines in one list, the farthest first; the reader turns and zooms.
// content: half sides and size of the view's box, whose middle is the origin, and the view in degrees. paint(list) adds what is seen,
// and returns what is to do after it is drawn.
function createStage(canvas, content, paint, footer) {
  const ink = canvas.getContext("2d"), EYE = 4.5;
  const home = { azimuth: content.view[1], elevation: content.view[0], zoom: 1 };
  const view = { ...home };
  let stale = true, running = true;

  // -- from space to the page --------------------------------------------------------------------------------
  let right, up, toward, scale, middle, ratio;
  function aim() {
    const a = view.azimuth * Math.PI / 180, e = view.elevation * Math.PI / 180;
    const ca = Math.cos(a), sa = Math.sin(a), ce = Math.cos(e), se = Math.sin(e);
    right = [-sa, ca, 0]; up = [-se * ca, -se * sa, ce]; toward = [ce * ca, ce * sa, se];
    scale = Math.min(canvas.width, canvas.height * 0.86) * 0.98 * view.zoom / content.size;
    middle = [canvas.width / 2, canvas.height * 0.48];
  }
  const dot = (u, x, y, z) => u[0] * x + u[1] * y + u[2] * z;
  const magnified = (near) => scale * EYE / Math.max(EYE - near / content.size, 0.2);
  function project(x, y, z) {  // page coordinates, and how near it is
    const near = dot(toward, x, y, z), grow = magnified(near);
    return [middle[0] + grow * dot(right, x, y, z), middle[1] - grow * dot(up, x, y, z), near];
  }
  function unproject(x, y, near) {  // the position at these page coordinates that is as near
    const grow = magnified(near), a = (x - middle[0]) / grow, b = (middle[1] - y) / grow;
    return [0, 1, 2].map((k) => a * right[k] + b * up[k] + near * toward[k]);
  }

  // -- what is drawn ---------------------------------------------------------------------------------------------
  function addLine(list, points, begin, end, stroke, width) {  // positions begin .. end - 1; interrupted at NaN
    let a = null;
    for (let i = begin; i < end; i++) {
      const x = points[3 * i], y = points[3 * i + 1], z = points[3 * i + 2];
      const b = Number.isFinite(x + y + z) ? project(x, y, z) : null;
      if (a && b) list.push({ near: (a[2] + b[2]) / 2, from: a, to: b, stroke, width });
      a = b;
    }
    return a;
  }
  function frame() {
    ratio = window.devicePixelRatio || 1;
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    aim();
    ink.clearRect(0, 0, width, height);
    ink.lineCap = ink.lineJoin = "round";
    box();
    const list = [], after = paint(list, ratio);
    list.sort((a, b) => a.near - b.near);
    list.forEach(draw);
    triad();
    if (after) after();
  }
  function draw(part) {
    ink.beginPath();
    if (part.corners) {
      part.corners.forEach((c, i) => (i ? ink.lineTo(c[0], c[1]) : ink.moveTo(c[0], c[1])));
      ink.closePath(); ink.fillStyle = part.fill; ink.fill();
      if (!part.clear) { ink.strokeStyle = part.fill; ink.lineWidth = 0.7; ink.stroke(); }  // no seams
    } else if (part.dot) {
      ink.arc(part.dot[0], part.dot[1], part.radius, 0, 2 * Math.PI); ink.fillStyle = part.fill; ink.fill();
    } else {
      ink.moveTo(part.from[0], part.from[1]); ink.lineTo(part.to[0], part.to[1]);
      ink.strokeStyle = part.stroke; ink.lineWidth = part.width; ink.stroke();
    }
  }
  function box() {  // the edges of the view's box, in pale
    const h = content.half;
    ink.strokeStyle = "#dde3e8"; ink.lineWidth = ratio;
    for (let i = 0; i < 8; i++) for (const bit of [1, 2, 4]) if (!(i & bit)) {
      const corner = (n) => project(n & 1 ? h[0] : -h[0], n & 2 ? h[1] : -h[1], n & 4 ? h[2] : -h[2]);
      const a = corner(i), b = corner(i | bit);
      ink.beginPath(); ink.moveTo(a[0], a[1]); ink.lineTo(b[0], b[1]); ink.stroke();
    }
  }
  function triad() {  // the directions of the axes, in the lower left corner
    const x = 52 * ratio, y = canvas.height - footer * ratio, size = 30 * ratio;
    ink.font = `${12 * ratio}px system-ui, sans-serif`; ink.textAlign = "center"; ink.textBaseline = "middle"; ink.lineWidth = 2 * ratio;
    ["x", "y", "z"].forEach((name, i) => {
      const px = size * right[i], py = -size * up[i];
      ink.strokeStyle = ink.fillStyle = ["#c8402f", "#2f9461", "#2c6fbb"][i];
      ink.beginPath(); ink.moveTo(x, y); ink.lineTo(x + px, y + py); ink.stroke(); ink.fillText(name, x + 1.35 * px, y + 1.35 * py);
    });
  }

  // -- what the reader does --------------------------------------------------------------------------------------
  const stage = { view, home, project, unproject, addLine, dot, frame, grab: null, tick: null,
    refresh() { stale = true; },
    stop() { running = false; window.removeEventListener("resize", stage.refresh); },
  };
  function next(stamp) {
    if (stage.tick) stage.tick(stamp);
    if (stale) { stale = false; frame(); }
    if (running) requestAnimationFrame(next);
  }
  const raise = (by) => { view.elevation = Math.max(-90, Math.min(90, view.elevation + by)); stale = true; };
  let held = null, move = null;
  canvas.onpointerdown = (event) => {
    move = stage.grab ? stage.grab(event.offsetX * ratio, event.offsetY * ratio) : null;
    held = [event.clientX, event.clientY]; canvas.setPointerCapture(event.pointerId);
  };
  canvas.onpointermove = (event) => {
    if (!held) return;
    if (move) { move(event.offsetX * ratio, event.offsetY * ratio); return; }
    view.azimuth -= 0.4 * (event.clientX - held[0]);
    raise(0.4 * (event.clientY - held[1]));
    held = [event.clientX, event.clientY];
  };
  canvas.onpointerup = canvas.onpointercancel = () => { held = move = null; };
  const zoom = (by) => { view.zoom = Math.max(0.1, Math.min(40, view.zoom * by)); stale = true; };
  canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(-0.0012 * event.deltaY)); }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const turn = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] }[event.key];
    if (turn) { view.azimuth += turn[0]; raise(turn[1]); }
    else if (event.key === "+" || event.key === "-") zoom(event.key === "+" ? 1.15 : 1 / 1.15);
    else return;
    event.preventDefault();
  });
  window.addEventListener("resize", stage.refresh);
  requestAnimationFrame(next);
  return stage;
}
