// Binary fields of JSON messages.
export function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  return Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
}

export const secondsOf = (time) => time.sec + time.nsec * 1e-9;
