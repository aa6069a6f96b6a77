// The page of gw-view: one client of its WebSocket, like any other.
import './style.css';
import {secondsOf} from './bytes.js';
import {Charts} from './charts.js';
import {Connection} from './connection.js';
import {Health} from './health.js';
import {ImagePanel} from './image_panel.js';
import {PlaybackBar} from './playback.js';
import {SceneView} from './scene.js';
import {Verdict} from './verdict.js';

const $ = (id) => document.getElementById(id);

const scene = new SceneView($('scene'));
const image = new ImagePanel({canvas: $('image'), note: $('image-note'), counts: $('feature-counts'), shares: $('shares'), explanation: $('explanation')});
const charts = new Charts($('charts'), (time) => image.hold(time));
const health = new Health($('processes'), $('log'));
const verdict = new Verdict({badge: $('tracking'), line: $('worst'), recent: $('recent')});

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  const css = getComputedStyle(document.documentElement);
  scene.setTheme({background: css.getPropertyValue('--ground').trim(), line: css.getPropertyValue('--quiet').trim()});
  charts.build();
  charts.changed = true;
}

function takeWeights(message, received) {
  verdict.takeWeights(message, received);
  image.takeWeights(message);
  if (image.images.length === 0) image.showWeights(message);
  charts.takeWeights(secondsOf(message.timestamp), message);
}

// Time goes on also where images do not.
function goOn() {
  image.setSilence(verdict.withoutImage);
  charts.goOn(verdict.withoutImage);
}

function takeTransforms(message, received) {
  verdict.takePose(received);
  goOn();
  scene.takeTransforms(message);
}

function takeHealth(message, received) {
  verdict.takeHealth(message, received);
  goOn();
  health.take(message);
}

function takeViewer(m) {
  $('viewer').textContent = `gw-view: ${m.clients} client${m.clients === 1 ? '' : 's'}, ${m.cpu_percent.toFixed(0)} % of a core, ` +
    `${m.memory_mb.toFixed(0)} MB, ${m.dropped} dropped, ${m.refused} refused; map: ${m.keyframes} keyframes, ` +
    `${m.landmarks} landmarks, ${m.loops} loops` +
    (m.pieces > 0 ? `, ${m.pieces} piece${m.pieces === 1 ? '' : 's'} whose place in it is not known` : '');
  const lossy = m.channels.filter((channel) => channel.lost > 0 || channel.undecodable > 0);
  if (lossy.length > 0) {
    $('viewer').textContent += '; ' + lossy.map((c) => `${c.name}: ${c.lost} lost, ${c.undecodable} undecodable`).join('; ');
  }
  $('source').textContent = m.source;
  const note = $('map-note');
  note.hidden = m.map_complete || m.keyframes === 0;
  note.textContent = 'gw-view came later than the map: only what changed since is shown';
}

let session = null;
const token = new URLSearchParams(location.search).get('token');
const address = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}${location.pathname}${token ? `?token=${encodeURIComponent(token)}` : ''}`;
const connection = new Connection(address, {
  '/tf': takeTransforms,
  '/trajectory': (m) => scene.takeWay(m),
  '/map/keyframes': (m) => scene.takeKeyframes(m),
  '/map/landmarks': (m) => scene.takeLandmarks(m),
  '/floor': (m) => scene.takeFloor(m),
  '/camera/image': (m) => image.takeImage(m),
  '/camera/features': (m) => image.takeFeatures(m),
  '/weights': takeWeights,
  '/error': (m) => charts.takeError(m),
  '/health': takeHealth,
  '/log': (m) => health.takeLog(m),
  '/viewer': takeViewer,
}, {
  opened(info) {
    if (session !== null && session !== info.sessionId) [scene, image, charts, health, verdict].forEach((part) => part.clear());
    session = info.sessionId;
    $('connection').textContent = 'connected';
    $('connection').dataset.state = 'ok';
    document.body.classList.remove('lost');
  },
  lost() {
    $('connection').textContent = 'no connection, trying again';
    $('connection').dataset.state = 'lost';
    document.body.classList.add('lost');
  },
  parameters: (list) => playback.take(list),
});
const playback = new PlaybackBar($('playback'), (values) => connection.setParameters(values), () => {
  [charts, image, verdict].forEach((part) => part.clear());
});

function toggle(button, action) {
  button.addEventListener('click', () => {
    const on = button.getAttribute('aria-pressed') !== 'true';
    button.setAttribute('aria-pressed', on);
    action(on);
  });
}
toggle($('follow'), (on) => scene.setFollow(on));
toggle($('top'), (on) => scene.setTop(on));
$('all').addEventListener('click', () => {
  $('follow').setAttribute('aria-pressed', 'false');
  scene.setFollow(false);
  scene.showAll();
});
$('theme').addEventListener('click', () => setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'));
setTheme(matchMedia('(prefers-color-scheme: light)').matches ? 'light' : 'dark');
