// Draws foxglove.SceneUpdate: lines and texts, the primitives that gw-view sends.
import {CanvasTexture, Group, Sprite, SpriteMaterial} from 'three';
import {Line2} from 'three/addons/lines/Line2.js';
import {LineGeometry} from 'three/addons/lines/LineGeometry.js';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';
import {LineSegments2} from 'three/addons/lines/LineSegments2.js';
import {LineSegmentsGeometry} from 'three/addons/lines/LineSegmentsGeometry.js';

const LINE_LIST = 2;

function drawLine(line) {
  const least = line.type === LINE_LIST ? 2 : 1;
  if (line.points.length < least) return null;
  const points = line.points.length === 1 ? [line.points[0], line.points[0]] : line.points;
  const colors = line.colors.length === 1 ? [line.colors[0], line.colors[0]] : line.colors;
  const geometry = line.type === LINE_LIST ? new LineSegmentsGeometry() : new LineGeometry();
  geometry.setPositions(points.flatMap((p) => [p.x, p.y, p.z]));
  const each = colors.length === points.length;
  if (each) geometry.setColors(colors.flatMap((c) => [c.r, c.g, c.b]));
  const material = new LineMaterial({
    linewidth: line.thickness, vertexColors: each, transparent: true,
    opacity: each ? colors[0].a : line.color.a,
  });
  if (!each) material.color.setRGB(line.color.r, line.color.g, line.color.b);
  return line.type === LINE_LIST ? new LineSegments2(geometry, material) : new Line2(geometry, material);
}

function drawText(text) {
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d'), font = '28px system-ui, sans-serif';
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text.text).width) + 16;
  canvas.height = 48;
  context.font = font;  // a new size resets it
  context.textAlign = 'center';
  const {r, g, b} = text.color;
  context.fillStyle = `rgb(${255 * r} ${255 * g} ${255 * b})`;
  context.fillText(text.text, canvas.width / 2, 34);
  const sprite = new Sprite(new SpriteMaterial(
      {map: new CanvasTexture(canvas), sizeAttenuation: false, depthTest: false}));
  sprite.scale.set(0.03 * canvas.width / canvas.height, 0.03, 1);
  const {x, y, z} = text.pose.position;
  sprite.position.set(x, y, z);
  return sprite;
}

export class Entities extends Group {
  byId = new Map();
  points = 0;  // of all lines

  take(update) {
    for (const deletion of update.deletions) {
      if (deletion.type === 1) [...this.byId.keys()].forEach((id) => this.drop(id));
      else this.drop(deletion.id);
    }
    for (const entity of update.entities) {
      this.drop(entity.id);
      const drawn = new Group();
      drawn.userData.points = 0;
      for (const line of entity.lines) {
        const object = drawLine(line);
        if (object) drawn.add(object);
        drawn.userData.points += line.points.length;
      }
      for (const text of entity.texts) drawn.add(drawText(text));
      this.byId.set(entity.id, drawn);
      this.points += drawn.userData.points;
      this.add(drawn);
    }
  }

  drop(id) {
    const drawn = this.byId.get(id);
    if (!drawn) return;
    this.points -= drawn.userData.points;
    for (const object of drawn.children) {
      object.geometry?.dispose();
      object.material.map?.dispose();
      object.material.dispose();
    }
    this.remove(drawn);
    this.byId.delete(id);
  }
}
