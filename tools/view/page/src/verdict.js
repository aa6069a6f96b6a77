// What is wrong and what to do, in the lines above everything, and the badge of what carries the pose. Both go by the times
// at which messages were received, so that they say it when some stop, live and in a log.
import {STATUS_WITHOUT_DR, statusOf} from './status.js';

export const ORDER = ['silent', 'failed', 'degraded', 'starting', 'remark', 'ok'];
const QUIET_S = 1.5;   // without images or poses: they come ten times a second and more
const RECENT_S = 30;
const DR_FILTER = 'gw-dr-ekf';
const LEAST_SHARE = 0.05;  // of the last images: a reason that is worth a word

// A process that is well but has something to say counts as more than one that is well.
export const gradeOf = (m) => (m.state === 'ok' && m.message ? 'remark' : m.state);

export class Verdict {
  constructor({badge, line, recent}) {
    Object.assign(this, {badge, line, recent});
    this.clear();
  }

  takeClock(time) {
    // Nothing at all for a while: this page was held up, and knows nothing of the images meanwhile.
    const missed = time - (this.now ?? time);
    if (missed > QUIET_S && this.weights) this.weights.time = Math.min(this.weights.time + missed, time);
    this.now = Math.max(this.now ?? time, time);
    this.draw();
  }

  takePose(received) {
    this.pose = received;
    this.takeClock(received);
  }

  takeWeights(m, received) {
    this.weights = {time: received, m};
    this.images.push({time: received, status: m.status, reason: m.reason, text: m.reason_text});
    while (this.images[0].time < received - RECENT_S) this.images.shift();
    this.takeClock(received);
  }

  takeHealth(m, received) {
    this.processes.set(m.process, m);
    this.takeClock(received);
  }

  // Seconds without an image's pose; 0 while they come.
  get withoutImage() {
    const age = this.weights ? this.now - this.weights.time : 0;
    return age > QUIET_S ? age : 0;
  }

  draw() {
    if (this.now - this.drawnAt < 0.1) return;
    this.drawnAt = this.now;
    this.drawBadge();
    this.drawLine();
    this.drawRecent();
  }

  drawBadge() {
    if (!this.weights) return;
    let status = statusOf(this.weights.m.status), name = this.weights.m.status;
    if (this.withoutImage > 0) {
      const carried = this.pose !== undefined && this.now - this.pose < QUIET_S;
      name = carried ? 'no_images' : 'no_pose';
      status = statusOf(name);
    }
    if (name === 'degraded' && this.weights.m.reason === 'dr_contradicts_vision') status = STATUS_WITHOUT_DR;
    this.badge.textContent = status.text;
    this.badge.style.background = status.color;
    this.badge.dataset.status = name;
  }

  drawLine() {
    const all = [...this.processes.values()].filter((m) => gradeOf(m) !== 'ok').sort(
        (a, b) => ORDER.indexOf(gradeOf(a)) - ORDER.indexOf(gradeOf(b)) || a.process.localeCompare(b.process));
    const worst = all[0];
    // Where vision says no more than that dead reckoning is wrong, what its filter says of the cause comes first.
    if (this.weights?.m.reason === 'dr_contradicts_vision') {
      all.sort((a, b) => (b.process === DR_FILTER) - (a.process === DR_FILTER));
    }
    this.line.parentElement.dataset.state = worst ? gradeOf(worst) : this.processes.size > 0 ? 'ok' : 'none';
    if (!worst) {
      this.line.textContent = this.processes.size > 0 ? 'all processes say that they are well' : 'no process heard yet';
      return;
    }
    // One line each: what the second says is often the cause of the first.
    this.line.textContent = all.map((m) => `${m.process}: ${m.message || m.state}`).join('\n');
  }

  // Why the last images were not simply tracked: what comes and goes is missed by who looks at one moment.
  drawRecent() {
    const counts = new Map();
    for (const image of this.images) {
      if (image.status === 'tracking' && image.reason === 'none') continue;
      const text = image.text || statusOf(image.status).text;
      counts.set(text, (counts.get(text) ?? 0) + 1);
    }
    const said = [...counts].filter(([, n]) => n >= LEAST_SHARE * this.images.length).sort((a, b) => b[1] - a[1]);
    const span = this.images.length > 1 ? this.images.at(-1).time - this.images[0].time : 0;
    this.recent.textContent = said.length === 0 ? '' : `last ${Math.max(1, Math.round(span))} s of images: ` +
      said.map(([text, n]) => `${Math.round(100 * n / this.images.length)} % ${text}`).join('; ');
  }

  clear() {
    this.now = undefined;
    this.drawnAt = -Infinity;
    this.pose = undefined;
    this.weights = null;
    this.images = [];
    this.processes = new Map();
  }
}
