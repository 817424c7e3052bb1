// The axes, and lengths on demand: the sides of the pallet, and those of one box.

const AXES = "#2f5fd0";

// A text that faces the camera and keeps its size.
function written(text) {
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d");
  const font = "600 40px system-ui, sans-serif";
  pen.font = font;
  canvas.width = Math.ceil(pen.measureText(text).width) + 28;
  canvas.height = 60;
  pen.font = font;
  pen.fillStyle = "#ffffffe6";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.fillStyle = "#14181f";
  pen.textBaseline = "middle";
  pen.fillText(text, 14, 32);
  const texture = new THREE.CanvasTexture(canvas);
  texture.encoding = THREE.sRGBEncoding;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: texture, depthTest: false, sizeAttenuation: false }));
  sprite.scale.set((0.022 * canvas.width) / canvas.height, 0.022, 1);
  sprite.renderOrder = 5;
  sprite.name = text;
  return sprite;
}

// Three lines, each with a text so much of the way along it.
function ruled(lines, colour, along) {
  const group = new THREE.Group();
  for (const { from, to, text } of lines) {
    const geometry = new THREE.BufferGeometry().setFromPoints([from, to].map((at) => new THREE.Vector3(...at)));
    const line = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour, depthTest: false }));
    line.renderOrder = 4;
    const label = written(text);
    label.position.set(...from).lerp(new THREE.Vector3(...to), along);
    group.add(line, label);
  }
  return group;
}

// A length [cm] in the page's unit, as a number.
const inUnit = (length, units) => +(length / units.cm).toFixed(units.decimals);

// The axes: short arrows with their names, beside the corner of the pallet that is seen at the left.
function axesOf([w, , d], names) {
  const group = new THREE.Group(), most = Math.max(w, d), length = 0.14 * most, aside = 0.02 * most;
  names.forEach((name, k) => {
    const way = new THREE.Vector3().setComponent(k, 1), thick = 0.006 * most;
    const paint = new THREE.MeshBasicMaterial({ color: AXES, depthTest: false });
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(thick, thick, length), paint);
    const head = new THREE.Mesh(new THREE.ConeGeometry(3 * thick, 0.3 * length), paint);
    const label = written(`+${name}`), arrow = new THREE.Group();
    shaft.position.y = length / 2;
    head.position.y = length;
    label.position.y = 1.45 * length;
    shaft.renderOrder = head.renderOrder = 4;
    arrow.add(shaft, head, label);
    arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way);
    group.add(arrow);
  });
  group.position.set(-aside, 0, d + aside);
  return group;
}

// The sides of the pallet, from its origin, where x, y and z are 0.
function lengthsOf([w, h, d], units) {
  const said = (length) => `${inUnit(length, units)} ${units.length}`;
  return ruled([
    { from: [0, 0, 0], to: [w, 0, 0], text: said(w) },
    { from: [0, 0, 0], to: [0, h, 0], text: said(h) },
    { from: [0, 0, 0], to: [0, 0, d], text: said(d) },
  ], AXES, 1.04);
}

// The sides of a box about its centre, at the edges that face high x, y and z.
function sidesOf([w, h, d], units) {
  const said = (length) => `${inUnit(length, units)} ${units.length}`;
  const [x, y, z] = [w / 2, h / 2, d / 2];
  return ruled([
    { from: [-x, y, z], to: [x, y, z], text: said(w) },
    { from: [x, -y, z], to: [x, y, z], text: said(h) },
    { from: [x, y, -z], to: [x, y, z], text: said(d) },
  ], "#14181f", 0.5);
}

const LABELLED = 60; // texts of more forces would hide the load

// Arrows that end where a force pushes upwards; the longest is a quarter of the pallet's height.
function forcesOf(forces, [, height], units) {
  const group = new THREE.Group(), most = Math.max(...forces.map((force) => force[3]), 1e-9);
  for (const [x, y, z, kg] of forces) {
    const length = (0.25 * height * kg) / most, up = new THREE.Vector3(0, 1, 0);
    if (length < 0.001 * height) continue;
    const arrow = new THREE.ArrowHelper(up, new THREE.Vector3(x, y - length, z), length, RED, Math.min(0.3 * length, 0.02 * height), 0.012 * height);
    for (const part of [arrow.line, arrow.cone]) Object.assign(part.material, { depthTest: false });
    arrow.line.renderOrder = arrow.cone.renderOrder = 4;
    group.add(arrow);
    if (forces.length > LABELLED) continue;
    const label = written(`${+(kg / units.kg).toPrecision(3)} ${units.weight}`);
    label.position.set(x, y - length, z);
    group.add(label);
  }
  return group;
}
