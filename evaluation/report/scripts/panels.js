/* Panels: small plots drawn by Plotly from the page's data, redrawn when the theme changes or their box does. */
"use strict";
class PanelPlot {
  constructor(box) {
    this.box = box;
    this.data = JSON.parse(document.getElementById(box.id.replace("plot-", "plot-data-")).textContent);
    this.visibility = Visibility.of(box.closest("section").id);
    this.visibility.listeners.push(() => this.draw());
    Theme.listeners.push(() => this.draw());
    this.draw();
  }

  /* The line with its markers, and what lies beneath: intervals, whiskers, the dots of single episodes. */
  traces(series) {
    const colour = Theme.colour(`--c${series.colour}`), paper = Theme.colour("--paper"), staircase = series.step;
    const common = { name: escaped(series.name), legendgroup: series.name };
    const out = [];
    if (series.dots) {
      out.push({
        ...common, x: series.dots.map((dot) => dot[0]), y: series.dots.map((dot) => dot[1]), mode: "markers",
        hoverinfo: "skip", marker: { symbol: SYMBOLS[series.marker], size: 4.5, color: colour, opacity: 0.45 },
      });
    }
    const filled = series.x.map((_, k) => !(series.hollow && series.hollow[k]));
    const marker = {
      symbol: SYMBOLS[series.marker], size: staircase ? 6 : 9, color: filled.map((full) => (full ? colour : paper)),
      line: { color: colour, width: staircase ? 0 : 1.6 }, maxdisplayed: staircase ? 7 : 0,
    };
    const main = {
      ...common, x: series.x, y: series.y, text: series.text, marker, mode: series.line ? "lines+markers" : "markers",
      line: { color: colour, width: 1.8, dash: series.pattern, shape: staircase ? "hv" : "linear" },
      hovertemplate: "%{text}<extra>%{fullData.name}</extra>",
    };
    const bar = { color: colour, thickness: 1.4, width: 3, type: "data", symmetric: false };
    if (series.low) {
      main.error_y = {
        ...bar, array: series.high.map((end, k) => end - series.y[k]), arrayminus: series.y.map((y, k) => y - series.low[k]),
      };
    }
    if (series.right) {
      main.error_x = { ...bar, thickness: 1, array: series.right.map((end, k) => end - series.x[k]), arrayminus: series.x.map(() => 0) };
    }
    return [...out, main];
  }

  guide(guide) {
    return {
      x: guide.x, y: guide.y, mode: "lines", hoverinfo: "skip", name: guide.name,
      line: { color: Theme.colour("--faint"), width: 1.4, dash: "6px,4px", shape: guide.step ? "hv" : "linear" },
    };
  }

  axis(axis, fitted) {
    const soft = Theme.colour("--soft"), line = Theme.colour("--line");
    const place = axis.log ? Math.log10 : (value) => value;
    const out = {
      title: { text: axis.title, standoff: 8, font: { size: 12 } }, type: axis.log ? "log" : "linear",
      ...(fitted ? { autorange: true } : { range: [place(axis.low), place(axis.high)] }), gridcolor: line, zeroline: false, linecolor: soft, tickcolor: soft,
      automargin: true, ...(axis.share ? { tickformat: ".0%" } : {}),
    };
    if (axis.ticks.length) {
      out.tickvals = axis.ticks.map((tick) => tick[0]);
      out.ticktext = axis.ticks.map((tick) => tick[1]);
    } else if (axis.log) {
      Object.assign(out, this.decades(axis));
    }
    return out;
  }

  /* Label 1, 2 and 5 of each decade where there are few decades, else the decades. */
  decades(axis) {
    const low = Math.floor(Math.log10(axis.low)), high = Math.ceil(Math.log10(axis.high));
    const digits = high - low > 3 ? [1] : [1, 2, 5], values = [];
    for (let power = low; power <= high; power++) {
      for (const digit of digits) values.push(Number(`${digit}e${power}`));
    }
    const shown = values.filter((value) => value >= axis.low && value <= axis.high);
    return { tickvals: shown, ticktext: shown.map(String) };
  }

  layout(fitted) {
    const soft = Theme.colour("--soft"), ink = Theme.colour("--ink"), line = Theme.colour("--line");
    return {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", showlegend: false, hovermode: "closest",
      font: { family: getComputedStyle(document.body).fontFamily, size: 11, color: soft },
      margin: { l: 50, r: 10, t: 8, b: 40 },
      xaxis: { ...this.axis(this.data.x), ticks: "outside", ticklen: 4, showline: true, showgrid: false }, yaxis: this.axis(this.data.y, fitted),
      hoverlabel: { bgcolor: Theme.colour("--paper"), bordercolor: line, font: { color: ink, size: 12 }, align: "left" },
    };
  }

  draw() {
    const shown = this.data.series.filter((series) => this.visibility.shows(series.name));
    const traces = [...this.data.guides.map((guide) => this.guide(guide)), ...shown.flatMap((series) => this.traces(series))];
    Plotly.react(this.box, traces, this.layout(shown.length < this.data.series.length && !this.data.y.share && !this.data.beyond), {
      responsive: true, displayModeBar: false,
    });
  }
}

Parts.each((part) => {
  for (const box of part.querySelectorAll(".plot")) new PanelPlot(box);
});
