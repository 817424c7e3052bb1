// One pane: the boxes of a layout in three.js, drawn where a loading has them.
"use strict";

const RAMP = ["#5277b8", "#4fa3a5", "#8fbf86", "#ecc769"];
const RED = "#e5384b", AMBER = "#ff9f1c";
const DARK = matchMedia("(prefers-color-scheme: dark)");

function bySequence(item, count) {
  const at = count > 1 ? (item / (count - 1)) * (RAMP.length - 1) : 0;
  const low = Math.min(Math.floor(at), RAMP.length - 2);
  return new THREE.Color(RAMP[low]).lerp(new THREE.Color(RAMP[low + 1]), at - low);
}

// Square decals in the middle of all faces but the bottom, each with the item's number.
function numberOn(size, text, most) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 128;
  const pen = canvas.getContext("2d");
  pen.font = `600 ${text.length > 2 ? 58 : 76}px system-ui, sans-serif`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillStyle = "#10151f";
  pen.fillText(text, 64, 68);
  const texture = new THREE.CanvasTexture(canvas);
  texture.anisotropy = 4;
  texture.encoding = THREE.sRGBEncoding;
  const at = [], uv = [];
  const [x, y, z] = size.map((side) => side / 2);
  const faces = [[[1, 0, 0], [0, 0, -1], [0, 1, 0], x, z, y], [[-1, 0, 0], [0, 0, 1], [0, 1, 0], x, z, y],
    [[0, 0, 1], [1, 0, 0], [0, 1, 0], z, x, y], [[0, 0, -1], [-1, 0, 0], [0, 1, 0], z, x, y],
    [[0, 1, 0], [1, 0, 0], [0, 0, -1], y, x, z]];
  for (const [out, right, up, far, wide, high] of faces) {
    const half = Math.min(wide, high, most) * 0.66;
    for (const [u, v] of [[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]]) {
      for (let k = 0; k < 3; k++) {
        at.push(out[k] * (far + 0.06) + (right[k] * (2 * u - 1) + up[k] * (2 * v - 1)) * half);
      }
      uv.push(u, v);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(at, 3));
  geometry.setAttribute("uv", new THREE.Float32BufferAttribute(uv, 2));
  return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({
    map: texture, transparent: true, depthWrite: false, polygonOffset: true, polygonOffsetFactor: -2,
  }));
}

function dotTexture() {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const pen = canvas.getContext("2d");
  pen.fillStyle = "#ffffff";
  pen.beginPath(); pen.arc(32, 32, 30, 0, 7); pen.fill();
  pen.fillStyle = "#14181f";
  pen.beginPath(); pen.arc(32, 32, 19, 0, 7); pen.fill();
  const texture = new THREE.CanvasTexture(canvas);
  texture.encoding = THREE.sRGBEncoding;
  return texture;
}

class Stage {
  constructor(canvas, data, loading) {
    Object.assign(this, { canvas, data, loading });
    THREE.ColorManagement.legacyMode = false; // colours are given as screens show them
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: true }); // kept for printing
    this.renderer.outputEncoding = THREE.sRGBEncoding;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32);
    this.light();
    this.ground();
    const dot = dotTexture();
    this.boxes = data.items.map((item, n) => this.box(item, n, dot));
    const outline = new THREE.EdgesGeometry(new THREE.BoxGeometry(1, 1, 1));
    this.plan = new THREE.LineSegments(outline, new THREE.LineDashedMaterial({ color: RED, dashSize: 0.06, gapSize: 0.04 }));
    this.plan.computeLineDistances();
    this.scene.add(this.plan);
    this.axes = axesOf(data.pallet, data.axes);
    this.lengths = lengthsOf(data.pallet, data.units);
    this.scene.add(this.axes, this.lengths);
    this.forces = forcesOf(data.forces, data.pallet, data.units);
    this.scene.add(this.forces);
    this.sides = null;
    this.pointed = null;
    this.paint();
  }

  light() {
    const [w, h, d] = this.data.pallet, reach = Math.hypot(w, h, d);
    this.scene.add(new THREE.HemisphereLight("#ffffff", "#8d93a3", 0.8));
    const sun = new THREE.DirectionalLight("#ffffff", 0.75);
    sun.position.set(w / 2 + 0.45 * reach, 1.5 * reach, d / 2 + 0.8 * reach);
    sun.target.position.set(w / 2, 0, d / 2);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.bias = -0.0006;
    sun.shadow.normalBias = 0.25;
    sun.shadow.radius = 3;
    const frame = { left: -reach, right: reach, top: reach, bottom: -reach, near: 1, far: 4 * reach };
    Object.assign(sun.shadow.camera, frame);
    this.scene.add(sun, sun.target);
  }

  ground() {
    const [w, h, d] = this.data.pallet, deck = this.data.deck, flat = (mesh, y) => {
      mesh.rotation.x = -Math.PI / 2;
      mesh.position.set(w / 2, y, d / 2);
      this.scene.add(mesh);
      return mesh;
    };
    const reach = 30 * Math.max(w, d);
    const floor = flat(new THREE.Mesh(new THREE.PlaneGeometry(reach, reach), new THREE.ShadowMaterial({ opacity: 0.2 })), -0.15 - deck);
    this.mat = flat(new THREE.Mesh(new THREE.PlaneGeometry(w, d), new THREE.MeshStandardMaterial({ roughness: 1 })), -0.08);
    floor.receiveShadow = this.mat.receiveShadow = true;
    if (deck) {
      const slab = new THREE.Mesh(new THREE.BoxGeometry(w, deck, d), this.mat.material);
      slab.position.set(w / 2, -0.1 - deck / 2, d / 2);
      slab.castShadow = slab.receiveShadow = true;
      this.scene.add(slab);
    }
    const edges = (size, y) => {
      const box = new THREE.EdgesGeometry(new THREE.BoxGeometry(w, size, d));
      const lines = new THREE.LineSegments(box, new THREE.LineBasicMaterial({ transparent: true }));
      lines.position.set(w / 2, y, d / 2);
      this.scene.add(lines);
      return lines;
    };
    this.rim = edges(0.01, 0);
    this.contour = edges(h, h / 2);
    const cell = Math.max(w, d) > 60 ? 20 : 10, cells = 2 * Math.ceil((1.5 * Math.max(w, d)) / cell);
    this.grid = new THREE.GridHelper(cells * cell, cells, "#ffffff", "#ffffff");
    this.grid.position.set(w / 2, -0.2 - deck, d / 2);
    this.grid.material.transparent = true;
    this.scene.add(this.grid);
  }

  box(item, n, dot) {
    const shape = new THREE.BoxGeometry(...item.size);
    const body = new THREE.Mesh(shape, new THREE.MeshStandardMaterial({
      color: this.data.moved.includes(n) ? AMBER : bySequence(n, this.data.items.length), roughness: 0.85, polygonOffset: true,
      polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    }));
    body.castShadow = body.receiveShadow = true;
    const edges = new THREE.LineSegments(new THREE.EdgesGeometry(shape),
      new THREE.LineBasicMaterial({ color: "#10151f", transparent: true, opacity: 0.6 }));
    const label = numberOn(item.size, String(n + 1), 0.09 * Math.hypot(...this.data.pallet));
    // Drawn over its own box, in which a centre of mass lies; hidden behind others, see draw.
    const mass = new THREE.Sprite(new THREE.SpriteMaterial({ map: dot, depthTest: false, sizeAttenuation: false }));
    mass.scale.setScalar(0.011);
    mass.position.set(...item.offset);
    mass.renderOrder = 3;
    const group = new THREE.Group();
    group.add(body, edges, label, mass);
    group.visible = false;
    this.scene.add(group);
    return Object.assign(group, { body, edges, label, mass, own: body.material.color.clone(), item: n });
  }

  // What depends on light or dark.
  paint() {
    const dark = DARK.matches;
    this.mat.material.color.set(dark ? "#4a4338" : "#c9b997");
    this.rim.material.color.set(dark ? "#9c8d73" : "#a08d69");
    this.contour.material.color.set(dark ? "#ffffff" : "#1b2130");
    this.contour.material.opacity = 0.14;
    this.grid.material.color.set(dark ? "#4a5265" : "#aab2c1");
    this.grid.material.opacity = dark ? 0.5 : 0.55;
  }

  // Put everything where it is `share` of the way through a step; says what there is to see.
  show(step, share) {
    const { loading } = this, ended = step > loading.last;
    const at = ended ? loading.last : step, within = ended ? 1 : share;
    const record = loading.steps[at] || { times: [], tracks: {}, moved: [], judged: 0 };
    const falling = Math.min(within / PLACING, 1), motion = Math.max(0, (within - PLACING) / (1 - PLACING));
    const times = record.times, time = times.length ? motion * times[times.length - 1] : 0;
    let frame = times.findLastIndex((t) => t <= time + 1e-9);
    const next = Math.min(frame + 1, times.length - 1);
    const part = next > frame && frame >= 0 ? (time - times[frame]) / (times[next] - times[frame]) : 0;
    this.boxes.forEach((box, n) => {
      box.visible = n <= at;
      if (box.visible) this.pose(box, record.tracks[n], frame, next, part);
    });
    const placed = this.boxes[at], lift = (1 - falling) ** 2 * 0.35 * this.data.pallet[1];
    placed.position.y += lift;
    this.boxes.forEach(({ body: { material } }, n) => {
      material.opacity = n === at ? 0.35 + 0.65 * falling : 1;
      material.transparent = material.opacity < 1;
    });
    this.placed = at;
    const failed = at === loading.failing && falling >= 1 && (!times.length || frame >= record.judged);
    this.mark(failed ? loading.moved ?? at : null);
    const moved = frame > 0 && motion > 0 ? record.moved[frame - 1] : null;
    return { at, ended, failed, time, moved, after: failed && frame > record.judged, simulated: times.length > 0 };
  }

  pose(box, track, frame, next, part) {
    box.quaternion.identity();
    if (!track) return box.position.set(...this.loading.planned[box.item]);
    const [cm, unit] = this.data.scale, still = track.length === 7;
    const a = still ? 0 : 7 * Math.max(frame, 0), b = still ? 0 : 7 * Math.max(next, 0);
    box.position.set(track[a], track[a + 1], track[a + 2]).divideScalar(cm);
    box.position.lerp(new THREE.Vector3(track[b], track[b + 1], track[b + 2]).divideScalar(cm), part);
    const turn = (k) => new THREE.Quaternion(track[k + 4] / unit, track[k + 5] / unit, track[k + 6] / unit, track[k + 3] / unit).normalize();
    return box.quaternion.slerpQuaternions(turn(a), turn(b), part);
  }

  // Red for the item that moved too far, amber for one that is crushed, with an outline of where it was planned.
  mark(item) {
    this.boxes.forEach((box, n) => box.body.material.color.copy(n === item ? new THREE.Color(this.loading.crushed ? AMBER : RED) : box.own));
    this.plan.visible = item !== null && this.loading.simulates;
    if (item === null) return;
    this.plan.position.set(...this.loading.planned[item]);
    this.plan.scale.set(...this.data.items[item].size);
  }

  itemAt(x, y) {
    const area = this.canvas.getBoundingClientRect(), ray = new THREE.Raycaster();
    ray.setFromCamera({ x: (2 * (x - area.left)) / area.width - 1, y: 1 - (2 * (y - area.top)) / area.height }, this.camera);
    const hit = ray.intersectObjects(this.boxes.filter((box) => box.visible).map((box) => box.body))[0];
    return hit ? hit.object.parent.item : null;
  }

  // The sides of the box under the pointer, or else of the one placed last.
  measure(wanted) {
    const item = wanted ? this.pointed ?? this.placed : null;
    this.lengths.visible = wanted;
    if (this.sides?.item === item) return;
    this.sides?.removeFromParent();
    this.sides = item === null ? null : Object.assign(sidesOf(this.data.items[item].size, this.data.units), { item });
    if (this.sides) this.boxes[item].add(this.sides);
  }

  draw(view, { numbers, masses, lengths, forces }) {
    this.measure(lengths);
    this.forces.visible = forces && this.placed === this.boxes.length - 1;
    const { clientWidth: width, clientHeight: height } = this.canvas, ratio = Math.min(devicePixelRatio, 2);
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / height;
    }
    // Near and far go with the distance: numbers lie close to their faces.
    Object.assign(this.camera, { near: 0.05 * view.distance, far: 50 * view.distance });
    this.camera.updateProjectionMatrix();
    const flat = Math.cos(view.pitch) * view.distance / Math.min(1, this.camera.aspect);
    this.camera.position.set(
      view.target.x + flat * Math.sin(view.yaw),
      view.target.y + Math.sin(view.pitch) * view.distance / Math.min(1, this.camera.aspect),
      view.target.z + flat * Math.cos(view.yaw));
    this.camera.lookAt(view.target);
    this.scene.updateMatrixWorld();
    const bodies = this.boxes.filter((box) => box.visible).map((box) => box.body);
    for (const box of this.boxes) {
      box.label.visible = numbers;
      box.mass.visible = masses && box.visible && this.isFirst(box, bodies);
    }
    this.renderer.render(this.scene, this.camera);
  }

  // Whether no other box lies between the camera and the centre of mass of a box.
  isFirst(box, bodies) {
    const from = this.camera.position, way = box.mass.getWorldPosition(new THREE.Vector3()).sub(from).normalize();
    const hit = new THREE.Raycaster(from, way).intersectObjects(bodies, false)[0];
    return !hit || hit.object.parent === box;
  }
}
