// The 3-D view: floor map, landmarks, keyframes, ways, robot. z is up, as in the world of the map.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CanvasTexture, Color, ColorManagement, ConeGeometry, CylinderGeometry, DoubleSide,
  Group, LinearSRGBColorSpace, Mesh, MeshBasicMaterial, NearestFilter, PerspectiveCamera, PlaneGeometry, Points, PointsMaterial,
  Scene, Vector3, WebGLRenderer,
} from 'three';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';
import {LineSegments2} from 'three/addons/lines/LineSegments2.js';
import {LineSegmentsGeometry} from 'three/addons/lines/LineSegmentsGeometry.js';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {fromBase64} from './bytes.js';
import {Entities} from './entities.js';
import {Frames, matrixOf} from './frames.js';

// Colours are shown as they are sent.
ColorManagement.enabled = false;

function makeRobot() {
  const robot = new Group();
  const body = new Mesh(new CylinderGeometry(0.17, 0.17, 0.12, 24), new MeshBasicMaterial({color: '#8793a3'}));
  body.rotation.x = Math.PI / 2;
  body.position.z = 0.08;
  const nose = new Mesh(new ConeGeometry(0.1, 0.28, 16), new MeshBasicMaterial({color: '#ff4d6d'}));
  nose.rotation.z = -Math.PI / 2;
  nose.position.set(0.22, 0, 0.16);
  const mast = new Mesh(new BoxGeometry(0.04, 0.1, 0.3), new MeshBasicMaterial({color: '#9aa4af'}));
  mast.position.z = 0.28;
  robot.add(body, nose, mast);
  robot.matrixAutoUpdate = false;
  robot.visible = false;
  return robot;
}

// One metre a cell.
function makeGrid() {
  const half = 50, ends = [];
  for (let i = -half; i <= half; ++i) ends.push(i, -half, 0, i, half, 0, -half, i, 0, half, i, 0);
  const grid = new LineSegments2(new LineSegmentsGeometry().setPositions(ends),
      new LineMaterial({linewidth: 1, transparent: true, opacity: 0.22}));
  grid.position.z = -0.02;
  return grid;
}

export class SceneView {
  frames = new Frames();
  way = new Entities();
  map = new Entities();
  robot = makeRobot();
  follow = true;
  fromTop = false;
  changed = true;
  notBefore = 0;

  constructor(element) {
    this.element = element;
    this.renderer = new WebGLRenderer({antialias: true});
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    element.prepend(this.renderer.domElement);
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(55, 1, 0.05, 2000);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(-4, -5, 6);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.grid = makeGrid();
    this.landmarks = new Points(new BufferGeometry(), new PointsMaterial({size: 2.2, sizeAttenuation: false, vertexColors: true}));
    this.landmarks.frustumCulled = false;
    this.floor = new Group();
    this.floor.matrixAutoUpdate = false;
    this.scene.add(this.grid, this.landmarks, this.way, this.map, this.robot, this.floor);
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
    this.renderer.setAnimationLoop(() => this.draw());
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.element;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // Another size has emptied the canvas: it is drawn before it is shown.
    this.changed = true;
    this.notBefore = 0;
    this.draw();
  }

  // Only what has changed, and never more than half of the time: there are slow tablets.
  draw() {
    const now = performance.now();
    const moved = this.controls.update();
    if (!(moved || this.changed) || now < this.notBefore) return;
    this.changed = false;
    this.renderer.render(this.scene, this.camera);
    this.notBefore = performance.now() + Math.min(performance.now() - now, 500);
  }

  setTheme({background, line}) {
    this.scene.background = new Color(background);
    this.grid.material.color.set(line);
    this.changed = true;
  }

  takeTransforms(message) {
    this.frames.take(message);
    const body = this.frames.toWorld('body');
    if (body) {
      const before = new Vector3().setFromMatrixPosition(this.robot.matrix);
      const now = new Vector3().setFromMatrixPosition(body);
      this.robot.matrix.copy(body);
      if (this.follow) {
        const step = this.robot.visible ? now.clone().sub(before) : now.clone().sub(this.controls.target);
        this.camera.position.add(step);
        this.controls.target.add(step);
      }
      this.robot.visible = true;
    }
    const floor = this.frames.toWorld('floor');
    if (floor) this.floor.matrix.copy(floor);
    this.changed = true;
  }

  takeWay(update) {
    this.way.take(update);
    this.changed = true;
    this.element.dataset.wayPoints = this.way.points;
  }

  takeKeyframes(update) {
    this.map.take(update);
    this.changed = true;
  }

  takeLandmarks(cloud) {
    const bytes = fromBase64(cloud.data);
    const count = Math.floor(bytes.length / cloud.point_stride);
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    const positions = new Float32Array(3 * count), colors = new Uint8Array(3 * count);
    const offset = Object.fromEntries(cloud.fields.map((field) => [field.name, field.offset]));
    for (let i = 0; i < count; ++i) {
      const at = i * cloud.point_stride;
      ['x', 'y', 'z'].forEach((axis, k) => { positions[3 * i + k] = view.getFloat32(at + offset[axis], true); });
      ['red', 'green', 'blue'].forEach((name, k) => { colors[3 * i + k] = bytes[at + offset[name]]; });
    }
    this.landmarks.geometry.dispose();
    this.landmarks.geometry = new BufferGeometry();
    this.landmarks.geometry.setAttribute('position', new BufferAttribute(positions, 3));
    this.landmarks.geometry.setAttribute('color', new BufferAttribute(colors, 3, true));
    this.element.dataset.landmarks = count;
    this.changed = true;
  }

  takeFloor(grid) {
    const cells = fromBase64(grid.data);
    const columns = grid.column_count, rows = Math.floor(cells.length / grid.row_stride);
    const canvas = document.createElement('canvas');
    canvas.width = columns;
    canvas.height = rows;
    const context = canvas.getContext('2d');
    const image = context.createImageData(columns, rows);
    for (let y = 0; y < rows; ++y) {
      for (let x = 0; x < columns; ++x) {
        const to = 4 * ((rows - 1 - y) * columns + x);
        image.data.set([125, 140, 165, cells[y * grid.row_stride + x] ? 210 : 0], to);
      }
    }
    context.putImageData(image, 0, 0);
    const texture = new CanvasTexture(canvas);
    texture.magFilter = NearestFilter;
    const width = columns * grid.cell_size.x, height = rows * grid.cell_size.y;
    const plane = new Mesh(new PlaneGeometry(width, height),
        new MeshBasicMaterial({map: texture, transparent: true, side: DoubleSide, depthWrite: false}));
    plane.position.set(width / 2, height / 2, -0.01);
    const placed = new Group();
    placed.applyMatrix4(matrixOf(grid.pose.position, grid.pose.orientation));
    placed.add(plane);
    this.floor.clear();
    this.floor.add(placed);
    this.changed = true;
  }

  setFollow(on) {
    this.follow = on;
    if (!on || !this.robot.visible) return;
    const now = new Vector3().setFromMatrixPosition(this.robot.matrix);
    this.camera.position.add(now.clone().sub(this.controls.target));
    this.controls.target.copy(now);
  }

  setTop(on) {
    this.fromTop = on;
    const distance = this.camera.position.distanceTo(this.controls.target);
    const from = on ? new Vector3(0, -0.001, 1) : new Vector3(-0.5, -0.6, 0.65);
    this.camera.position.copy(this.controls.target).add(from.setLength(distance));
    this.controls.enableRotate = !on;
  }

  // The whole way into sight.
  showAll() {
    const low = new Vector3(Infinity, Infinity, 0), high = new Vector3(-Infinity, -Infinity, 0);
    for (const entity of this.way.byId.values()) {
      for (const line of entity.children) {
        line.geometry.computeBoundingBox();
        low.min(line.geometry.boundingBox.min);
        high.max(line.geometry.boundingBox.max);
      }
    }
    if (!Number.isFinite(low.x)) return;
    const centre = low.clone().add(high).divideScalar(2);
    const reach = Math.max(high.x - low.x, (high.y - low.y) * this.camera.aspect, 3);
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).add(direction.multiplyScalar(0.75 * reach + 2));
  }

  clear() {
    for (const group of [this.way, this.map]) group.take({deletions: [{type: 1}], entities: []});
    this.landmarks.geometry.dispose();
    this.landmarks.geometry = new BufferGeometry();
    this.robot.visible = false;
    this.changed = true;
  }
}
