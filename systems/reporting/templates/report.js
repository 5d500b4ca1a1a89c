"use strict";
(function () {
  const config = { responsive: true, displayModeBar: false, displaylogo: false };
  for (const source of document.querySelectorAll("script[data-chart]")) {
    const figure = JSON.parse(source.textContent);
    Plotly.newPlot(source.dataset.chart, figure.data, figure.layout, config);
  }
  function numbers(text) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    return new Float32Array(bytes.buffer);
  }
  function part(all, ends, i) {
    return Array.from(all.subarray(i > 0 ? ends[i - 1] : 0, ends[i]), (v) => (Number.isNaN(v) ? null : v));
  }
  const marked = Array.from(document.querySelectorAll(".chart[data-marked='1']"));
  for (const player of document.querySelectorAll(".player")) {
    const data = JSON.parse(player.querySelector("script.data").textContent);
    const moving = data.moving.map((m) => ({ ...m, x: numbers(m.x), y: numbers(m.y) }));
    const slider = player.querySelector("input"), button = player.querySelector("button");
    const cells = Array.from(player.querySelectorAll(".values td"));
    const events = Array.from(player.querySelectorAll(".events li"));
    function show(i) {
      player.querySelector(".frame").textContent = data.frames[i];
      data.values.forEach((row, k) => { cells[k].textContent = row[1][i]; });
      const x = moving.map((m) => part(m.x, m.ends, i)), y = moving.map((m) => part(m.y, m.ends, i));
      if (moving.length) Plotly.restyle(data.chart, { x: x, y: y }, moving.map((m) => m.trace));
      if (data.marks.length) {
        for (const chart of marked) {
          Plotly.relayout(chart, { "shapes[0].x0": data.marks[i], "shapes[0].x1": data.marks[i] });
        }
      }
      let last = null;
      for (const event of events) {
        const past = Number(event.dataset.frame) <= i;
        event.classList.toggle("past", past);
        if (past) last = event;
      }
      if (last) last.parentNode.scrollTop = last.offsetTop - last.parentNode.offsetTop - 60;
    }
    let timer = null;
    function stop() {
      clearInterval(timer);
      timer = null;
      button.textContent = button.dataset.play;
    }
    function go(i) {
      slider.value = i;
      show(i);
    }
    button.addEventListener("click", () => {
      if (timer) return stop();
      if (Number(slider.value) >= data.frames.length - 1) go(0);
      button.textContent = button.dataset.pause;
      timer = setInterval(() => {
        const next = Number(slider.value) + 1;
        if (next >= data.frames.length) return stop();
        go(next);
      }, 90);
    });
    slider.addEventListener("input", () => show(Number(slider.value)));
    for (const event of events) event.addEventListener("click", () => go(Number(event.dataset.frame)));
    show(Number(slider.value));
  }
})();
