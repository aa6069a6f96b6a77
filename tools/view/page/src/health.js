// Health of the processes, what is worst first; and what happened.
const ORDER = ['silent', 'failed', 'degraded', 'starting', 'ok'];
const LOG_LINES = 60;
const LOSSES = /lost|dropped|undecodable|exceptions|unsent|rejected/;

function cell(row, text, className) {
  const td = row.insertCell();
  td.textContent = text;
  if (className) td.className = className;
  return td;
}

export class Health {
  processes = new Map();

  constructor(table, log) {
    this.table = table;
    this.log = log;
  }

  take(message) {
    this.processes.set(message.process, message);
    this.draw();
  }

  draw() {
    const all = [...this.processes.values()].sort((a, b) =>
      ORDER.indexOf(a.state) - ORDER.indexOf(b.state) || a.process.localeCompare(b.process));
    const body = document.createElement('tbody');
    for (const m of all) {
      const row = body.insertRow();
      row.dataset.process = m.process;
      row.dataset.state = m.state;
      cell(row, m.process);
      cell(row, m.state, `state ${m.state}`);
      cell(row, m.state === 'silent' ? '' : m.latency_p99_ms.toFixed(1), 'number');
      const what = cell(row, m.message);
      for (const counter of m.counters) {
        if (!counter.grew || !LOSSES.test(counter.name)) continue;
        const line = document.createElement('div');
        line.className = 'warning';
        line.textContent = `${counter.name} grows: ${counter.value}`;
        what.append(line);
      }
      if (m.action) {
        const action = document.createElement('div');
        action.className = 'action';
        action.textContent = m.action;
        what.append(action);
      }
    }
    this.table.replaceChildren(...body.children);
  }

  takeLog(message) {
    const item = document.createElement('li');
    const time = new Date(1000 * message.timestamp.sec).toISOString().slice(11, 19);
    item.textContent = `${time} ${message.name}: ${message.message}`;
    item.className = `level${message.level}`;
    this.log.prepend(item);
    while (this.log.children.length > LOG_LINES) this.log.lastChild.remove();
  }

  clear() {
    this.processes.clear();
    this.draw();
  }
}
