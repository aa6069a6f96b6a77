// Figures of the tools (tools/lab/plot) in a report: panels of lines and points, or of bars.
import {XyChart} from './xy_chart.js';

function make(tag, className, text = '') {
  return Object.assign(document.createElement(tag), {className, textContent: text});
}

function barPanel(panel) {
  const box = make('figure', 'bars');
  box.append(make('figcaption', '', panel.title));
  const longest = panel.x_max ?? Math.max(...panel.bars.map((bar) => bar.value ?? 0), panel.marker ?? 0, 1e-9);
  for (const bar of panel.bars) {
    const row = make('div', 'bar');
    row.title = `${bar.label}: ${bar.value ?? '-'}`;
    const track = make('i', ''), filled = make('b', bar.hatched ? 'hatched' : '');
    filled.style.width = `${100 * Math.min(1, (bar.value ?? 0) / longest)}%`;
    filled.style.setProperty('--bar', bar.color || '#0072b2');
    track.append(filled);
    if (panel.marker !== null) {
      const marker = make('s', '');
      marker.style.left = `${100 * Math.min(1, panel.marker / longest)}%`;
      track.append(marker);
    }
    row.append(make('span', bar.bold ? 'bold' : '', bar.label), track, make('output', '', bar.note));
    box.append(row);
  }
  const marker = panel.marker === null ? '' : `; dashed: ${panel.marker_label} ${Number(panel.marker.toPrecision(3))}`;
  box.append(make('p', 'value', panel.x_label + marker));
  return box;
}

export function renderFigure(figure) {
  const section = make('section', figure.panels.length > 1 ? 'figure many' : 'figure');
  if (figure.title) section.append(make('h2', '', figure.title));
  const charts = [];
  const panels = make('div', 'panels');
  for (const panel of figure.panels) {
    if (panel.bars) {
      panels.append(barPanel(panel));
    } else {
      charts.push(new XyChart(panel));
      panels.append(charts.at(-1).element);
    }
  }
  section.append(panels, ...figure.footer.map((text) => make('p', 'quiet', text)));
  return {section, charts};
}
