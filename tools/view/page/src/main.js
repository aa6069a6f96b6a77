// The page of gw-view: one client of its WebSocket, like any other.
import './style.css';
import {Connection} from './connection.js';
import {PlaybackBar} from './playback.js';
import {RunView} from './run_view.js';
import {startTheme} from './theme.js';
import {Verdict} from './verdict.js';

const $ = (id) => document.getElementById(id);

const run = new RunView($('run'));
const verdict = new Verdict({badge: $('tracking'), line: $('worst'), recent: $('recent')});
const shown = run.handlers();

// Time goes on also where images do not.
function goOn() {
  run.image.setSilence(verdict.withoutImage);
  run.charts.goOn(verdict.withoutImage);
}

// What the verdict goes by, beside what shows it.
function judged(topic, judge) {
  return (message, received) => {
    judge(message, received);
    goOn();
    shown[topic](message);
  };
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
  $('source').textContent = m.source.split('/').at(-1);
  $('source').title = m.source;
  const note = $('map-note');
  note.hidden = m.map_complete || m.keyframes === 0;
  note.textContent = 'gw-view came later than the map: only what changed since is shown';
}

let session = null;
const token = new URLSearchParams(location.search).get('token');
const address = `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}${location.pathname}${token ? `?token=${encodeURIComponent(token)}` : ''}`;
const connection = new Connection(address, {
  ...shown,
  '/tf': judged('/tf', (m, received) => verdict.takePose(received)),
  '/weights': judged('/weights', (m, received) => verdict.takeWeights(m, received)),
  '/health': judged('/health', (m, received) => verdict.takeHealth(m, received)),
  '/viewer': takeViewer,
}, {
  opened(info) {
    if (session !== null && session !== info.sessionId) [run, verdict].forEach((part) => part.clear());
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
  [run.charts, run.image, verdict].forEach((part) => part.clear());
});
startTheme($('theme'), () => run.applyTheme());
