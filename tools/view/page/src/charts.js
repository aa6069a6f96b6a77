// Charts over the last two minutes, or over a whole run, with one cursor for all; spans without healthy vision are shaded.
// A stretch that is drawn with the mouse is zoomed into, in all of them; a double click shows everything again.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import {statusOf} from './status.js';

const REDRAW_MS = 200;
const HELD_UP_S = 3;  // between images, while none was missed: the page was held up
const STEP_S = 0.5;  // of rows without an image

// One chart: title, unit, whether logarithmic, and its lines.
const CHARTS = [
  {title: 'quality of vision, DR share', range: [0, 1], lines: [
    {key: 'q', label: 'Q', color: '--c1'}, {key: 'dr', label: 'DR share', color: '--c2'}]},
  {title: 'alpha, weight of DR', log: true, lines: [
    {key: 'alpha', label: 'turn', color: '--c1'}, {key: 'alphaWay', label: 'way', color: '--c3'}]},
  {title: 'error and stated sigma, m', lines: [
    {key: 'error', label: 'error', color: '--c4'}, {key: 'sigma', label: '1 sigma', color: '--c5'}]},
  {title: 'image to pose, ms', lines: [{key: 'latency', label: 'latency', color: '--c1'}]},
];

export class Charts {
  rows = [];  // {t, status, q, ...}, by time
  origin = null;  // of the time axis

  // span: s that are kept.
  constructor(element, onCursor, span) {
    Object.assign(this, {element, onCursor, span, zoomed: false});
    this.build();
    element.addEventListener('dblclick', () => { this.zoomed = false; this.changed = true; });
    new ResizeObserver(() => this.resize()).observe(element);
    setInterval(() => this.redraw(), REDRAW_MS);
  }

  build() {
    this.element.replaceChildren();
    const css = getComputedStyle(document.documentElement);
    const color = (name) => css.getPropertyValue(name).trim();
    const axis = {stroke: color('--quiet'), grid: {stroke: color('--grid'), width: 1}, ticks: {show: false}, font: '11px system-ui', size: 44};
    const powers = {...axis, filter: (u, splits) => splits.map((v) => (Number.isInteger(Math.log10(v)) ? v : null)),
      grid: {...axis.grid, filter: (u, splits) => splits.map((v) => (Number.isInteger(Math.log10(v)) ? v : null))}};
    this.plots = CHARTS.map((chart) => {
      const box = document.createElement('div');
      this.element.append(box);
      return new uPlot({
        width: 300, height: 130, title: chart.title, pxAlign: false,
        cursor: {sync: {key: 'gw'}, drag: {x: true, y: false}},
        legend: {live: true},
        scales: {x: {time: false}, y: chart.log ? {distr: 3} : chart.range ? {range: chart.range} : {range: (u, low, high) => [0, Math.max(high ?? 0, 1e-3) * 1.1]}},
        axes: [{...axis, size: 28, values: (u, ticks) => ticks.map((t) => `${t} s`)}, chart.log ? powers : axis],
        series: [{label: 'at', value: (u, v) => (v == null ? '' : `${v.toFixed(1)} s`)},
          ...chart.lines.map((line) => ({label: line.label, stroke: color(line.color), width: 1.5, points: {show: false},
            value: (u, v) => (v == null ? '-' : v.toPrecision(3))}))],
        hooks: {drawClear: [(u) => this.shade(u)], setCursor: [(u) => this.cursor(u)],
          setSelect: [() => { this.zoomed = true; }]},
      }, [[], ...chart.lines.map(() => [])], box);
    });
    this.resize();
  }

  resize() {
    const boxes = [...this.element.children];
    this.plots.forEach((plot, i) => {
      const width = boxes[i].clientWidth;
      if (width > 0) plot.setSize({width, height: 130});
    });
  }

  shade(u) {
    const context = u.ctx;
    let from = 0;
    const rows = this.drawn ?? [];
    for (let i = 1; i <= rows.length; ++i) {
      if (i < rows.length && rows[i].status === rows[from].status) continue;
      if (rows[from].status !== 'tracking' && rows[from].status !== 'unseen') {
        // Images stopped after the row before.
        const begin = rows[from].status === 'no_images' ? Math.max(from - 1, 0) : from;
        const x0 = u.valToPos(rows[begin].t, 'x', true), x1 = u.valToPos(rows[Math.min(i, rows.length - 1)].t, 'x', true);
        context.fillStyle = `${statusOf(rows[from].status).color}33`;
        context.fillRect(x0, u.bbox.top, Math.max(x1 - x0, 1), u.bbox.height);
      }
      from = i;
    }
  }

  cursor(u) {
    if (u.cursor.event && u.cursor.idx !== null && u.cursor.left >= 0) {
      this.onCursor(this.origin + u.data[0][u.cursor.idx]);
    } else if (u.cursor.event && u.cursor.left < 0) {
      this.onCursor(null);
    }
  }

  takeWeights(time, m) {
    this.origin ??= time;
    const t = time - this.origin;
    if (this.rows.length && t < this.rows.at(-1).t) this.rows = [];
    const last = this.rows.at(-1);
    if (last && t - last.t > HELD_UP_S) this.add({t: last.t + 0.01, status: 'unseen'});  // lifts the pen
    this.lastImage = t;
    this.add({t, status: m.status, q: m.q, dr: m.dr_share, alpha: m.alpha || null, alphaWay: m.alpha_translation || null,
      error: this.error ?? null, sigma: m.sigma_position_m < 5 ? m.sigma_position_m : null, latency: m.latency_ms});
  }

  // Rows without an image, so that the charts go on and show it. seconds: since the last one; 0: they come.
  goOn(seconds) {
    const t = this.lastImage + seconds;
    if (seconds > 0 && this.rows.length > 0 && t > this.rows.at(-1).t + STEP_S) {
      this.add({t, status: 'no_images', error: this.error ?? null});
    }
  }

  add(row) {
    this.rows.push(row);
    while (this.rows.length && this.rows[0].t < row.t - this.span) this.rows.shift();
    this.changed = true;
  }

  takeError(m) {
    this.error = m.position_m;
  }

  redraw() {
    if (!this.changed) return;
    this.changed = false;
    this.drawn = this.rows.slice();
    const t = this.drawn.map((row) => row.t);
    this.plots.forEach((plot, i) => {
      plot.setData([t, ...CHARTS[i].lines.map(({key}) => this.drawn.map((row) => row[key] ?? null))], !this.zoomed);
      if (this.zoomed) plot.redraw();
      // Without a cursor the legend shows the newest values.
      if (!(plot.cursor.left >= 0) && t.length > 0) plot.setLegend({idx: t.length - 1});
    });
    this.element.dataset.points = Number(this.element.dataset.points ?? 0) + 1;
    this.element.dataset.last = t.at(-1);
  }

  clear() {
    this.rows = [];
    this.origin = null;
    this.error = null;
    this.changed = true;
  }
}
