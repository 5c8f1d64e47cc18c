"use strict";
// The page of a result: its theme, and curves that can be zoomed. The fields are in viewer.js.
const data = JSON.parse(document.getElementById("data").textContent);
const root = document.documentElement;
const onTheme = [];

function setTheme(name) {
  root.dataset.theme = name;
  onTheme.forEach(redraw => redraw());
}
root.dataset.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
document.getElementById("theme").addEventListener("click", () => setTheme(root.dataset.theme === "dark" ? "light" : "dark"));

const colour = name => getComputedStyle(root).getPropertyValue(name).trim();
// As many digits as a reader can use.
const digits = (value, count = 5) => value == null ? "" : Number(value.toPrecision(count)).toString();

// Curves ----------------------------------------------------------------------------------------------------------------
// A chart: {title, x: "t [s]", y: "T [K]", columns: [[x...], [y...], ...], series: [{label, colour, points, thin}]}

function drawChart(chart, place) {
  const axis = label => ({
    label, stroke: colour("--ink"), font: "12px system-ui", labelFont: "12px system-ui", labelSize: 22,
    size: label === chart.x ? 42 : 66, grid: { stroke: colour("--line"), width: 1 }, ticks: { stroke: colour("--line"), width: 1 },
    values: (plot, splits) => splits.map(value => value == null ? "" : digits(value, 7)),
  });
  const options = {
    width: place.clientWidth, height: 300, pxAlign: 0, scales: { x: { time: false } }, axes: [axis(chart.x), axis(chart.y)],
    cursor: { drag: { x: true, y: true, uni: 20 }, points: { size: 6 } },
    series: [{ label: chart.x, value: (plot, value) => digits(value) }, ...chart.series.map(series => ({
      label: series.label, stroke: series.colour, width: series.points ? 0 : series.thin ? 1 : 1.8, spanGaps: true, pxAlign: 0,
      points: { show: !!series.points, size: 6, stroke: series.colour, fill: colour("--paper") },
      value: (plot, value) => digits(value),
    }))],
  };
  return new uPlot(options, chart.columns, place);
}

for (const chart of data.charts) {
  const place = document.getElementById(chart.id);
  let plot = drawChart(chart, place);
  onTheme.push(() => { plot.destroy(); plot = drawChart(chart, place); });
  addEventListener("resize", () => plot.setSize({ width: place.clientWidth, height: 300 }));
}
