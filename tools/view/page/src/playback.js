// Seek bar, pause and speed of a log: parameters of the protocol.
const NAMES = {position: '/playback/position_s', duration: '/playback/duration_s', speed: '/playback/speed', paused: '/playback/paused'};

export class PlaybackBar {
  // jumped: what was shown is of another time.
  constructor(bar, set, jumped) {
    this.bar = bar;
    this.seek = bar.querySelector('#seek');
    this.time = bar.querySelector('#time');
    this.button = bar.querySelector('#pause');
    this.speed = bar.querySelector('#speed');
    this.seek.addEventListener('input', () => { this.dragging = true; this.label(Number(this.seek.value)); });
    this.seek.addEventListener('change', () => {
      jumped();
      set({[NAMES.position]: Number(this.seek.value)});
      this.dragging = false;
    });
    this.button.addEventListener('click', () => set({[NAMES.paused]: !this.paused}));
    this.speed.addEventListener('change', () => set({[NAMES.speed]: Number(this.speed.value)}));
  }

  label(position) {
    this.time.textContent = `${position.toFixed(1)} of ${this.duration.toFixed(1)} s`;
  }

  take(parameters) {
    const values = Object.fromEntries(parameters.map(({name, value}) => [name, value]));
    if (values[NAMES.duration] === undefined) return;
    this.bar.hidden = false;
    this.duration = values[NAMES.duration];
    this.paused = values[NAMES.paused];
    this.seek.max = this.duration;
    this.button.textContent = this.paused ? 'play' : 'pause';
    this.bar.dataset.position = values[NAMES.position];
    const speed = String(values[NAMES.speed]);
    if (![...this.speed.options].some((option) => option.value === speed)) this.speed.add(new Option(speed));
    if (document.activeElement !== this.speed) this.speed.value = speed;
    if (!this.dragging) {
      this.seek.value = values[NAMES.position];
      this.label(values[NAMES.position]);
    }
  }
}
