// What shows a run, live or from a report: 3-D view, camera image, charts, health, log. One handler per topic.
import {secondsOf} from './bytes.js';
import {Charts} from './charts.js';
import {Health} from './health.js';
import {ImagePanel} from './image_panel.js';
import {SceneView} from './scene.js';

const $ = (id) => document.getElementById(id);

export const MARKUP = `
  <section id="scene" aria-label="map and way">
    <div class="tools">
      <button id="follow" aria-pressed="true">follow</button>
      <button id="top" aria-pressed="false">top view</button>
      <button id="all">show all</button>
    </div>
    <ul class="legend">
      <li class="c-tracking">vision</li><li class="c-degraded">weak</li>
      <li class="c-dr_only">dead reckoning only</li><li class="c-recovering">place not known</li>
      <li class="c-lost">lost</li><li class="c-dr">dead reckoning alone</li>
      <li class="c-truth">ground truth</li><li class="c-loop">loop</li>
    </ul>
    <p id="map-note" class="note" hidden></p>
  </section>
  <section id="camera" aria-label="camera image">
    <canvas id="image" width="480" height="360"></canvas>
    <p id="image-note" class="note">no image yet</p>
    <p id="explanation"></p>
    <div id="feature-counts" class="legend"></div>
    <div id="shares" title="share of dead reckoning in the pose, per axis"></div>
  </section>
  <section id="health" aria-label="health of the processes">
    <ul id="processes"></ul>
    <p id="viewer" class="quiet"></p>
    <ol id="log"></ol>
  </section>
  <section id="charts" aria-label="charts"></section>`;

function toggle(button, action) {
  button.addEventListener('click', () => {
    const on = button.getAttribute('aria-pressed') !== 'true';
    button.setAttribute('aria-pressed', on);
    action(on);
  });
}

export class RunView {
  // element: gets MARKUP. whole: keep and show a whole run, not the last minutes. onCursor: time (s) in the charts, or null.
  constructor(element, {whole = false, onCursor = () => {}} = {}) {
    element.innerHTML = MARKUP;
    this.scene = new SceneView($('scene'));
    this.image = new ImagePanel({canvas: $('image'), note: $('image-note'), counts: $('feature-counts'), shares: $('shares'),
      explanation: $('explanation'), remembered: whole ? Infinity : 600});
    this.charts = new Charts($('charts'), (time) => {
      this.image.hold(time);
      onCursor(time);
    }, whole ? Infinity : 120);
    this.health = new Health($('processes'), $('log'), whole ? Infinity : 60);
    toggle($('follow'), (on) => this.scene.setFollow(on));
    toggle($('top'), (on) => this.scene.setTop(on));
    $('all').addEventListener('click', () => this.showAll());
  }

  showAll() {
    $('follow').setAttribute('aria-pressed', 'false');
    this.scene.setFollow(false);
    this.scene.showAll();
  }

  handlers() {
    return {
      '/tf': (m) => this.scene.takeTransforms(m),
      '/trajectory': (m) => this.scene.takeWay(m),
      '/map/keyframes': (m) => this.scene.takeKeyframes(m),
      '/map/landmarks': (m) => this.scene.takeLandmarks(m),
      '/floor': (m) => this.scene.takeFloor(m),
      '/camera/image': (m) => this.image.takeImage(m),
      '/camera/features': (m) => this.image.takeFeatures(m),
      '/weights': (m) => this.takeWeights(m),
      '/error': (m) => this.charts.takeError(m),
      '/health': (m) => this.health.take(m),
      '/log': (m, received) => this.health.takeLog(m, received),
    };
  }

  takeWeights(m) {
    this.image.takeWeights(m);
    if (this.image.images.length === 0) this.image.showWeights(m);
    this.charts.takeWeights(secondsOf(m.timestamp), m);
  }

  // After the colours of the page have changed.
  applyTheme() {
    const css = getComputedStyle(document.documentElement);
    this.scene.setTheme({background: css.getPropertyValue('--ground').trim(), line: css.getPropertyValue('--quiet').trim()});
    this.charts.build();
    this.charts.changed = true;
  }

  clear() {
    [this.scene, this.image, this.charts, this.health].forEach((part) => part.clear());
  }
}
