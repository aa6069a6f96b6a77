// Colours and words of the tracking status; the colours of the way come with it from gw-view.
export const STATUS = {
  initializing: {text: 'no map yet', color: '#7c8694'},
  tracking: {text: 'vision tracks', color: '#2078b8'},
  degraded: {text: 'vision weak', color: '#fabf24'},
  dr_only: {text: 'dead reckoning only', color: '#f56b1a'},
  recovering: {text: 'place in the map not known', color: '#b861ed'},
  lost: {text: 'lost', color: '#e62633'},
  no_images: {text: 'no images: dead reckoning only', color: '#f56b1a'},
  no_pose: {text: 'no images, no pose', color: '#e62633'},
};

// Degraded, but not for want of vision.
export const STATUS_WITHOUT_DR = {text: 'vision alone: dead reckoning contradicts it', color: '#fabf24'};

export const statusOf = (name) => STATUS[name] ?? {text: name, color: '#999999'};
