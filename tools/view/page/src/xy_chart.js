// A panel of a figure: lines and points over two axes. A rectangle that is drawn with the mouse is zoomed into, a double click
// shows everything again, and what is nearest to the pointer says its values.
const MARGIN = {left: 56, right: 10, top: 8, bottom: 34};
const PALETTE = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#8b8b00', '#707070'];
const NEAR_PX = 30;

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

function ticks([low, high], most) {
  const raw = (high - low) / most, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw);
  const out = [];
  for (let k = Math.ceil(low / step); k * step <= high; ++k) out.push(Number((k * step).toPrecision(12)));
  return out;
}

function extent(values, given) {
  if (given) return given;
  let low = Infinity, high = -Infinity;
  for (const v of values) {
    if (v === null) continue;
    low = Math.min(low, v);
    high = Math.max(high, v);
  }
  if (!Number.isFinite(low)) return [0, 1];
  const room = 0.04 * (high - low) || Math.abs(low) * 0.1 || 1;
  return [low - room, high + room];
}

const readable = (v) => (v === null ? '-' : Number(v.toPrecision(4)).toString());

export class XyChart {
  constructor(panel) {
    this.panel = panel;
    this.element = document.createElement('figure');
    this.element.className = 'xy';
    if (panel.title) this.element.append(Object.assign(document.createElement('figcaption'), {textContent: panel.title}));
    this.canvas = document.createElement('canvas');
    this.value = Object.assign(document.createElement('p'), {className: 'value'});
    this.element.append(this.canvas, this.legend(), this.value);
    this.showAll();
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.element);
  }

  colorOf(i) {
    const given = this.panel.series[i].color;
    // Black of a printed figure is the colour of text here.
    return given === '#000000' ? css('--text') : given || PALETTE[i % PALETTE.length];
  }

  legend() {
    const list = document.createElement('div');
    list.className = 'legend';
    this.panel.series.forEach((series, i) => {
      if (series.label) list.append(this.key(series.label, series.color === '#000000' ? 'var(--text)' : this.colorOf(i)));
    });
    for (const label of new Set(this.panel.spans.map((span) => span.label))) {
      const span = this.panel.spans.find((s) => s.label === label);
      if (label) list.append(this.key(label, `${span.color}55`));
    }
    return list;
  }

  key(label, color) {
    const item = Object.assign(document.createElement('span'), {textContent: label});
    item.style.setProperty('--dot', color);
    return item;
  }

  showAll() {
    this.x = extent(this.panel.series.flatMap((s) => s.x), this.panel.x_range);
    this.y = extent(this.panel.series.flatMap((s) => s.y), this.panel.y_range);
    this.draw();
  }

  listen() {
    const at = (event) => [event.offsetX, event.offsetY];
    this.canvas.addEventListener('pointerdown', (event) => { this.from = this.to = at(event); });
    this.canvas.addEventListener('pointermove', (event) => {
      if (this.from) this.to = at(event);
      this.draw();
      this.say(...at(event));
    });
    this.canvas.addEventListener('pointerup', () => this.zoom());
    this.canvas.addEventListener('pointerleave', () => { this.from = null; this.value.textContent = ''; this.draw(); });
    this.canvas.addEventListener('dblclick', () => this.showAll());
  }

  zoom() {
    const [a, b] = [this.from, this.to];
    this.from = null;
    if (a && Math.abs(a[0] - b[0]) > 5 && Math.abs(a[1] - b[1]) > 5) {
      const xs = [a[0], b[0]].map((p) => this.xOf(p)).sort((p, q) => p - q);
      const ys = [a[1], b[1]].map((p) => this.yOf(p)).sort((p, q) => p - q);
      [this.x, this.y] = [xs, ys];
    }
    this.draw();
  }

  px(x) { return MARGIN.left + (x - this.shown.x[0]) / (this.shown.x[1] - this.shown.x[0]) * this.inner.width; }
  py(y) { return MARGIN.top + (this.shown.y[1] - y) / (this.shown.y[1] - this.shown.y[0]) * this.inner.height; }
  xOf(px) { return this.shown.x[0] + (px - MARGIN.left) / this.inner.width * (this.shown.x[1] - this.shown.x[0]); }
  yOf(py) { return this.shown.y[1] - (py - MARGIN.top) / this.inner.height * (this.shown.y[1] - this.shown.y[0]); }

  // On maps a metre is as long on x as on y.
  fit() {
    this.shown = {x: this.x, y: this.y};
    if (!this.panel.equal_aspect) return;
    const scale = Math.max((this.x[1] - this.x[0]) / this.inner.width, (this.y[1] - this.y[0]) / this.inner.height);
    const grown = ([low, high], pixels) => {
      const middle = (low + high) / 2, half = scale * pixels / 2;
      return [middle - half, middle + half];
    };
    this.shown = {x: grown(this.x, this.inner.width), y: grown(this.y, this.inner.height)};
  }

  draw() {
    const width = this.element.clientWidth;
    if (!width) return;
    const height = this.panel.equal_aspect ? Math.round(0.75 * width) : 260, ratio = devicePixelRatio;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    this.canvas.style.height = `${height}px`;
    this.inner = {width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom};
    this.fit();
    const c = this.canvas.getContext('2d');
    c.scale(ratio, ratio);
    this.drawAxes(c, width, height);
    c.save();
    c.beginPath();
    c.rect(MARGIN.left, MARGIN.top, this.inner.width, this.inner.height);
    c.clip();
    for (const span of this.panel.spans) {
      c.fillStyle = `${span.color}2a`;
      c.fillRect(this.px(span.x_begin), MARGIN.top, this.px(span.x_end) - this.px(span.x_begin), this.inner.height);
    }
    this.panel.series.forEach((series, i) => this.drawSeries(c, series, this.colorOf(i)));
    if (this.from) {
      c.strokeStyle = css('--accent');
      c.strokeRect(this.from[0], this.from[1], this.to[0] - this.from[0], this.to[1] - this.from[1]);
    }
    c.restore();
  }

  drawAxes(c, width, height) {
    c.font = '11px system-ui, sans-serif';
    c.fillStyle = css('--quiet');
    c.strokeStyle = css('--grid');
    c.textAlign = 'center';
    for (const x of ticks(this.shown.x, width / 90)) {
      c.strokeRect(this.px(x), MARGIN.top, 0, this.inner.height);
      c.fillText(readable(x), this.px(x), height - MARGIN.bottom + 14);
    }
    c.fillText(this.panel.x_label, MARGIN.left + this.inner.width / 2, height - 4);
    c.textAlign = 'right';
    for (const y of ticks(this.shown.y, height / 45)) {
      c.strokeRect(MARGIN.left, this.py(y), this.inner.width, 0);
      c.fillText(readable(y), MARGIN.left - 5, this.py(y) + 4);
    }
    c.save();
    c.translate(11, MARGIN.top + this.inner.height / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = 'center';
    c.fillText(this.panel.y_label, 0, 0);
    c.restore();
  }

  drawSeries(c, series, color) {
    c.strokeStyle = c.fillStyle = color;
    c.lineWidth = series.width;
    c.setLineDash(series.dashed ? [6, 4] : []);
    c.beginPath();
    let pen = false;
    series.x.forEach((x, i) => {
      const y = series.y[i];
      if (x === null || y === null) {
        pen = false;
      } else if (series.points) {
        c.moveTo(this.px(x) + 2.5, this.py(y));
        c.arc(this.px(x), this.py(y), 2.5, 0, 7);
        if (series.line && pen) {
          c.moveTo(this.px(series.x[i - 1]), this.py(series.y[i - 1]));
          c.lineTo(this.px(x), this.py(y));
        }
        pen = true;
      } else {
        if (pen) c.lineTo(this.px(x), this.py(y)); else c.moveTo(this.px(x), this.py(y));
        pen = true;
      }
    });
    c.stroke();
    c.setLineDash([]);
  }

  say(px, py) {
    let best = null, distance = NEAR_PX;
    this.panel.series.forEach((series, s) => series.x.forEach((x, i) => {
      if (x === null || series.y[i] === null) return;
      const d = Math.hypot(this.px(x) - px, this.py(series.y[i]) - py);
      if (d < distance) [best, distance] = [{s, i}, d];
    }));
    if (!best) {
      this.value.textContent = '';
      return;
    }
    const series = this.panel.series[best.s], x = series.x[best.i], y = series.y[best.i];
    this.value.textContent = `${series.label || this.panel.title}: ${this.panel.x_label} ${readable(x)}, ${this.panel.y_label} ${readable(y)}`;
    const c = this.canvas.getContext('2d');
    c.beginPath();
    c.arc(this.px(x), this.py(y), 4.5, 0, 7);
    c.strokeStyle = css('--text');
    c.stroke();
  }
}
