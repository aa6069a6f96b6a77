// The camera image with its features, and the shares of dead reckoning in its pose. Remembers images, so that
// the one under the cursor of the charts can be looked at.
import {fromBase64, secondsOf} from './bytes.js';
import {statusOf} from './status.js';

const FATES = ['unmatched', 'inlier', 'outlier', 'new'];
const AXES = ['forward', 'left', 'up', 'roll', 'pitch', 'yaw'];

export class ImagePanel {
  images = [];  // {time, blob, features, weights}
  shown = null;
  held = null;  // time under the cursor

  silence = 0;  // s without an image's pose

  // remembered: images, of which at most 10 come in a second.
  constructor({canvas, note, counts, shares, explanation, remembered}) {
    Object.assign(this, {canvas, note, counts, shares, explanation, remembered});
    this.context = canvas.getContext('2d');
    shares.innerHTML = AXES.map((axis) => `<div class="share"><span>${axis}</span><i><b></b></i><output></output></div>`).join('');
  }

  takeImage(message) {
    const blob = new Blob([fromBase64(message.data)], {type: 'image/jpeg'});
    this.images.push({time: secondsOf(message.timestamp), blob, features: null, weights: null});
    if (this.images.length > this.remembered) this.images.shift();
    this.canvas.dataset.count = Number(this.canvas.dataset.count ?? 0) + 1;
    // Shown with its features when they come; without, when they do not.
    clearTimeout(this.late);
    this.late = setTimeout(() => this.show(), 60);
  }

  at(time) {
    for (let i = this.images.length - 1; i >= 0; --i) {
      if (Math.abs(this.images[i].time - time) < 0.001) return this.images[i];
    }
    return null;
  }

  takeFeatures(message) {
    const image = this.at(secondsOf(message.timestamp));
    if (image) image.features = message.points;
    this.show();
  }

  takeWeights(message) {
    const image = this.at(secondsOf(message.timestamp));
    if (image) image.weights = message;
  }

  hold(time) {
    this.held = time;
    this.show();
  }

  pick() {
    if (this.held === null) return this.images.at(-1);
    return this.images.reduce((best, image) =>
      !best || Math.abs(image.time - this.held) < Math.abs(best.time - this.held) ? image : best, null);
  }

  async show() {
    const image = this.pick();
    if (this.drawing) this.again = true;  // what is newest by then
    if (!image || this.drawing) return;
    this.drawing = true;
    try {
      const bitmap = await createImageBitmap(image.blob);
      if (this.canvas.width !== bitmap.width || this.canvas.height !== bitmap.height) {
        this.canvas.width = bitmap.width;
        this.canvas.height = bitmap.height;
      }
      this.context.drawImage(bitmap, 0, 0);
      bitmap.close();
      this.drawFeatures(image.features ?? []);
      this.label();
      this.showWeights(image.weights);
    } catch {
      this.note.hidden = false;
      this.note.textContent = 'an image could not be decoded';
    } finally {
      this.drawing = false;
      if (this.again) {
        this.again = false;
        this.show();
      }
    }
  }

  // An old image does not look like a new one.
  setSilence(seconds) {
    this.silence = seconds;
    this.label();
  }

  label() {
    if (this.images.length === 0) return;
    const old = this.held === null && this.silence > 0;
    this.canvas.classList.toggle('old', old);
    this.note.hidden = this.held === null && !old;
    this.note.classList.toggle('alarm', old);
    this.note.textContent = old ? `no image for ${Math.round(this.silence)} s; this one, and what is said of it, are of then` : 'image under the cursor';
    this.explanation.classList.toggle('old', old);
  }

  drawFeatures(groups) {
    const texts = [];
    groups.forEach((group, fate) => {
      const {r, g, b, a} = group.outline_color;
      const color = `rgba(${255 * r}, ${255 * g}, ${255 * b}, ${a})`;
      this.context.strokeStyle = color;
      this.context.lineWidth = 1.2;
      const size = group.thickness;
      for (const p of group.points) {
        this.context.strokeRect(p.x - size / 2, p.y - size / 2, size, size);
      }
      texts.push(`<span style="--dot:${color}">${group.points.length} ${FATES[fate]}</span>`);
    });
    this.counts.innerHTML = texts.join('');
  }

  showWeights(weights) {
    if (!weights) return;
    this.explanation.textContent = weights.explanation;
    const shares = weights.dr_share_axes;
    [...this.shares.children].forEach((row, i) => {
      const share = shares ? shares[AXES[i]] : weights.dr_share;
      row.querySelector('b').style.width = `${100 * share}%`;
      row.querySelector('b').style.background = statusOf(weights.status).color;
      row.querySelector('output').textContent = `${Math.round(100 * share)} %`;
    });
  }

  clear() {
    this.images = [];
    this.held = null;
    this.silence = 0;
  }
}
