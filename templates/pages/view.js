/* The page's own script: the figure, and buttons for points of view. Reads #data, draws into #scene. */
(function () {
  "use strict";
  var data = JSON.parse(document.getElementById("data").textContent);
  var place = document.getElementById("scene");
  var note = document.getElementById("note");
  var config = {displaylogo: false, responsive: true, scrollZoom: true, showTips: false, modeBarButtonsToRemove: ["resetCameraDefault3d", "resetCameraLastSave3d"]};

  function failed(text) {
    var line = document.createElement("p");
    line.id = "failed";
    line.textContent = text;
    document.body.appendChild(line);
    document.body.dataset.state = "failed";
  }

  /* plotly sees 45 degrees; the scene's camera has an angle of its own. */
  function widen() {
    var plot = place._fullLayout && place._fullLayout.scene && place._fullLayout.scene._scene && place._fullLayout.scene._scene.glplot;
    if (plot && plot.fovy) plot.fovy = data.views.angle;
    return Boolean(plot && plot.fovy);
  }

  function look(name) {
    var drawn = place._fullLayout && place._fullLayout.scene && place._fullLayout.scene._scene;
    if (drawn && Plotly.Fx && Plotly.Fx.loneUnhover) Plotly.Fx.loneUnhover(drawn.svgContainer);
    return Plotly.relayout(place, {"scene.camera": JSON.parse(JSON.stringify(data.views[name]))});
  }

  function toggle(button, change) {
    button.addEventListener("click", function () {
      var on = button.getAttribute("aria-pressed") !== "true";
      button.setAttribute("aria-pressed", String(on));
      change(on);
    });
  }

  function probe() {
    var canvas = document.createElement("canvas");
    return canvas.getContext("webgl2") || canvas.getContext("webgl");
  }

  if (!probe()) return failed("This browser shows no WebGL, which the 3D view needs. Try another, or turn on hardware acceleration.");
  Plotly.newPlot(place, data.data, data.layout, config).then(function () {
    document.body.dataset.lens = widen() ? "own" : "default";
    document.getElementById("camera").addEventListener("click", function () { look("camera"); });
    document.getElementById("overview").addEventListener("click", function () { look("overview"); });
    toggle(document.getElementById("axes"), function (on) {
      Plotly.relayout(place, {"scene.xaxis.visible": on, "scene.yaxis.visible": on, "scene.zaxis.visible": on});
    });
    place.on("plotly_relayout", widen);
    return look("camera");
  }).then(function () {
    document.body.dataset.traces = String(place._fullData.length);
    document.body.dataset.state = "ready";
  }).catch(function (error) {
    failed("The view could not be drawn: " + error.message);
  });
})();
