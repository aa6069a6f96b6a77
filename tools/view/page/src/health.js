// Health of the processes, what is worst first; and what happened.
import {gradeOf, ORDER} from './verdict.js';

const LOSSES = /lost|dropped|undecodable|exceptions|unsent|rejected/;

function line(parent, text, className) {
  const div = document.createElement('div');
  div.textContent = text;
  div.className = className;
  parent.append(div);
}

// The HEALTH message often ends with the same advice as the runbook's.
function says(message, action) {
  return message.includes(action.split(/[;(]/)[0].trim());
}

function describe(cell, m) {
  if (m.message) line(cell, m.message, 'message');
  for (const counter of m.counters) {
    if (counter.grew && LOSSES.test(counter.name)) line(cell, `${counter.name} grows: ${counter.value}`, 'warning');
  }
  if (m.action && !says(m.message, m.action)) line(cell, `to do: ${m.action}`, 'action');
}

export class Health {
  processes = new Map();

  // lines: of the log that are kept.
  constructor(list, log, lines) {
    Object.assign(this, {list, log, lines});
  }

  take(message) {
    this.processes.set(message.process, message);
    this.draw();
  }

  draw() {
    const all = [...this.processes.values()].sort((a, b) =>
      ORDER.indexOf(gradeOf(a)) - ORDER.indexOf(gradeOf(b)) || a.process.localeCompare(b.process));
    this.list.replaceChildren(...all.map((m) => {
      const item = document.createElement('li');
      item.dataset.process = m.process;
      item.dataset.state = m.state;
      const head = document.createElement('div');
      head.className = 'process';
      line(head, m.process, 'name');
      line(head, gradeOf(m) === 'remark' ? 'ok, but:' : m.state, `state ${gradeOf(m)}`);
      if (m.state !== 'silent' && m.latency_p99_ms > 0) line(head, `p99 ${m.latency_p99_ms.toFixed(1)} ms`, 'quiet');
      item.append(head);
      describe(item, m);
      return item;
    }));
  }

  // One clock for all lines where they come live: stamps of a replay are of another day.
  takeLog(message, received) {
    const item = document.createElement('li');
    const time = new Date(1000 * (received ?? message.timestamp.sec)).toISOString().slice(11, 19);
    item.textContent = `${time} ${message.name}: ${message.message}`;
    item.className = `level${message.level}`;
    this.log.prepend(item);
    while (this.log.children.length > this.lines) this.log.lastChild.remove();
  }

  clear() {
    this.processes.clear();
    this.log.replaceChildren();
    this.draw();
  }
}
