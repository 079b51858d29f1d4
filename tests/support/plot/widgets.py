"""A widget of Jupyter in a real browser without a server.

Its module is given a model whose messages go over the DevTools protocol.
"""

from __future__ import annotations

import base64
import json
import time
from pathlib import Path
from typing import Any

from ipywidgets.widgets.widget import _remove_buffers

from ..browser import Chromium

_PAGE = """<!doctype html><meta charset="utf-8"><body style="margin: 0"><div id="cell"></div>
<script type="module">
%s
const bytes = (text) => new DataView(Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer);
const state = {}, listeners = {};
window.receive = ({ values, paths, buffers }) => {
  paths.forEach((path, i) => {
    const last = path[path.length - 1];
    path.slice(0, -1).reduce((inside, key) => inside[key], values)[last] = bytes(buffers[i]);
  });
  Object.assign(state, values);
  for (const name of Object.keys(values)) (listeners[`change:${name}`] || []).forEach((call) => call());
};
const model = {
  get: (name) => state[name],
  set: (name, value) => { state[name] = value; },
  save_changes: () => window.toPython(JSON.stringify({ inputs: state.inputs })),
  on: (event, call) => { (listeners[event] ||= []).push(call); },
  off: (event, call) => { listeners[event] = (listeners[event] || []).filter((other) => other !== call); },
};
window.begin = () => {
  window.stop = widget.render({ model, el: document.getElementById("cell") });
  document.body.dataset.state = "ready";
};
document.body.dataset.state = "loaded";
</script>
"""


class WidgetPage:
    """A widget on a page; `attend` answers what it asks until something is true."""

    def __init__(self, chromium: Chromium, widget: Any, folder: Path) -> None:
        self.chromium, self.widget, self.answers = chromium, widget, 0
        module = str(widget._esm).replace("export default {", "const widget = {")
        page = folder / "widget.html"
        page.write_text(_PAGE % module, encoding="utf-8")
        chromium.call("Runtime.addBinding", name="toPython")
        chromium.open(page)
        values, paths, buffers = _remove_buffers({n: getattr(widget, n) for n in widget.keys if not n.startswith("_")})
        self._send({"state": values, "buffer_paths": paths}, buffers)
        chromium.value("begin()")
        widget._send = self._send

    def _send(self, message: Any, buffers: Any = ()) -> None:
        """What the widget sends, to the page."""
        texts = [base64.b64encode(b).decode("ascii") for b in buffers]
        sent = json.dumps({"values": message["state"], "paths": message["buffer_paths"], "buffers": texts}, default=str)
        self.chromium.value(f"receive({sent})")

    def attend(self) -> int:
        """Answer what the page has asked so far; the number of answers."""
        calls = [e for e in self.chromium.events if e.get("method") == "Runtime.bindingCalled"]
        self.chromium.events = [e for e in self.chromium.events if e.get("method") != "Runtime.bindingCalled"]
        for event in calls:
            self.widget.set_state(json.loads(event["params"]["payload"]))
        self.answers += len(calls)
        return len(calls)

    def settle(self, seconds: float = 20.0) -> None:
        """Until all is answered and drawn."""
        end, quiet = time.monotonic() + seconds, 0
        while quiet < 3:
            assert time.monotonic() < end, "the widget asks on and on"
            self.chromium.value("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
            quiet = 0 if self.attend() else quiet + 1

    def mouse(self, kind: str, x: float, y: float) -> None:
        """Press, move or release the left button."""
        self.chromium.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    def value(self, expression: str) -> Any:
        """What JavaScript makes of an expression; ``widget`` is its element's own handle."""
        return self.chromium.value(f"((widget) => {expression})(document.getElementById('cell').bladesmith)")
