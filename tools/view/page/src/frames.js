// The tree of frames from foxglove.FrameTransforms.
import {Matrix4, Quaternion, Vector3} from 'three';

const ONE = new Vector3(1, 1, 1);

export function matrixOf(translation, rotation) {
  return new Matrix4().compose(
      new Vector3(translation.x, translation.y, translation.z),
      new Quaternion(rotation.x, rotation.y, rotation.z, rotation.w), ONE);
}

export class Frames {
  parents = new Map();

  take(message) {
    for (const t of message.transforms) {
      this.parents.set(t.child_frame_id, {parent: t.parent_frame_id, matrix: matrixOf(t.translation, t.rotation)});
    }
  }

  // From the frame into the world; null while it is not known.
  toWorld(frame) {
    const matrix = new Matrix4();
    for (let steps = 0; frame !== 'world'; ++steps) {
      const link = this.parents.get(frame);
      if (!link || steps > 10) return null;
      matrix.premultiply(link.matrix);
      frame = link.parent;
    }
    return matrix;
  }
}
