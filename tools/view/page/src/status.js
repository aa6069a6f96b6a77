// Colours and words of the tracking status; the colours of the way come with it from gw-view.
export const STATUS = {
  initializing: {text: 'initializing', color: '#999999'},
  tracking: {text: 'vision tracks', color: '#2999ed'},
  degraded: {text: 'vision weak', color: '#fabf24'},
  dr_only: {text: 'dead reckoning only', color: '#f56b1a'},
  recovering: {text: 'recovering', color: '#b861ed'},
  lost: {text: 'lost', color: '#e62633'},
};

export const statusOf = (name) => STATUS[name] ?? {text: name, color: '#999999'};
