// A report: the parts of the page, with the data embedded (tools/view/report/report_page.h says how).
import './style.css';
import './report.css';
import {secondsOf} from './bytes.js';
import {renderFigure} from './figures.js';
import {renderMarkdown} from './markdown.js';
import {RunView} from './run_view.js';
import {startTheme} from './theme.js';

const $ = (id) => document.getElementById(id);

function showFacts(facts) {
  for (const [name, value] of facts) {
    const row = $('facts').insertRow();
    row.append(Object.assign(document.createElement('th'), {textContent: name}));
    row.insertCell().textContent = value;
  }
}

// Every message, in the order in which it came, and the robot where it was at the time under the cursor.
function showRun(messages) {
  $('run').hidden = false;
  const transforms = messages.filter(([topic]) => topic === '/tf').map(([, m]) => [secondsOf(m.transforms[0].timestamp), m]);
  const run = new RunView($('run'), {whole: true, onCursor(time) {
    const at = time === null ? transforms.at(-1) : transforms.findLast(([t]) => t <= time);
    if (at) run.scene.takeTransforms(at[1]);
  }});
  const handlers = run.handlers();
  for (const [topic, message] of messages) handlers[topic]?.(message);
  run.showAll();
  return run;
}

const data = JSON.parse($('data').textContent);
document.title = data.title;
$('title').textContent = data.title;
$('lead').textContent = data.lead;
showFacts(data.facts);
const run = data.messages.length > 0 ? showRun(data.messages) : null;
const figures = data.figures.map(renderFigure);
$('figures').append(...figures.map(({section}) => section));
$('text').append(...renderMarkdown(data.markdown));
startTheme($('theme'), () => {
  run?.applyTheme();
  figures.forEach(({charts}) => charts.forEach((chart) => chart.draw()));
});
document.body.dataset.ready = 'true';
