"use strict";
const scene = JSON.parse(document.getElementById("scene-data").textContent);
const byId = (id) => document.getElementById(id);
const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
const colour = (hex, alpha = 1) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255).concat(alpha);

// Column-major 4 x 4 matrices, as WebGL takes them.
const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
function times(a, b) {
  const out = new Array(16).fill(0);
  for (let c = 0; c < 4; c++)
    for (let r = 0; r < 4; r++)
      for (let k = 0; k < 4; k++) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
  return out;
}
const add = (a, b, s = 1) => a.map((x, k) => x + s * b[k]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / (Math.hypot(...a) || 1));

function lookAt(eye, target, up) {
  const z = unit(add(eye, target, -1)), x = unit(cross(up, z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}
function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2), d = 1 / (near - far);
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) * d, -1, 0, 0, 2 * far * near * d, 0];
}
// A frame at `point` whose z axis is `axis`, stretched by `width` across and `length` along it.
function along(point, axis, width, length) {
  const z = unit(axis), x = unit(cross(Math.abs(z[0]) < 0.8 ? [1, 0, 0] : [0, 1, 0], z)), y = cross(z, x);
  return [...x.map((v) => v * width), 0, ...y.map((v) => v * width), 0, ...z.map((v) => v * length), 0, ...point, 1];
}

// A solid of revolution about z through the points (radius, height).
function lathe(profile, sides = 20) {
  const points = [], faces = [];
  profile.forEach(([radius, height]) => {
    for (let k = 0; k < sides; k++)
      points.push(radius * Math.cos((2 * Math.PI * k) / sides), radius * Math.sin((2 * Math.PI * k) / sides), height);
  });
  for (let row = 0; row + 1 < profile.length; row++)
    for (let k = 0; k < sides; k++) {
      const a = row * sides + k, b = row * sides + ((k + 1) % sides);
      faces.push(a, b, b + sides, a, b + sides, a + sides);
    }
  return [new Float32Array(points), new Uint32Array(faces)];
}
const arc = [...Array(13)].map((_, k) => [Math.sin((Math.PI * k) / 12), -Math.cos((Math.PI * k) / 12)]);

const VERTEX = `#version 300 es
uniform mat4 model, view; in vec3 point; out vec3 world;
void main() { vec4 p = model * vec4(point, 1.0); world = p.xyz; gl_Position = view * p; }`;
const FRAGMENT = `#version 300 es
precision highp float;
uniform vec4 paint; uniform vec3 eye, light; in vec3 world; out vec4 result;
void main() {
  vec3 normal = normalize(cross(dFdx(world), dFdy(world)));
  vec3 towards = normalize(eye - world);
  if (dot(normal, towards) < 0.0) normal = -normal;
  float key = max(dot(normal, light), 0.0), head = max(dot(normal, towards), 0.0);
  vec3 shade = paint.rgb * (0.38 + 0.34 * key + 0.36 * head) + 0.10 * pow(key, 12.0);
  result = vec4(shade * paint.a, paint.a);
}`;

function painter(gl) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.bindAttribLocation(program, 0, "point");
  gl.linkProgram(program);
  gl.useProgram(program);
  const at = Object.fromEntries(["model", "view", "paint", "eye", "light"].map((n) => [n, gl.getUniformLocation(program, n)]));
  const upload = ([points, faces]) => {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, points, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    return { array, count: faces.length };
  };
  const draw = (mesh, model, paint) => {
    gl.uniformMatrix4fv(at.model, false, model);
    gl.uniform4fv(at.paint, paint);
    gl.bindVertexArray(mesh.array);
    gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
  };
  return { at, upload, draw };
}

const canvas = byId("view");
const gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: true });
if (!gl) byId("problem").style.display = "flex";
const paint = gl && painter(gl);
const load = (mesh) => gl && paint.upload([new Float32Array(bytes(mesh.points)), new Uint32Array(bytes(mesh.faces))]);
const objectMesh = load(scene.object), links = scene.links.map((link) => ({ ...link, mesh: load(link) }));
const ball = gl && paint.upload(lathe(arc));
const arrow = gl && paint.upload(lathe([[0, -1], [0.32, -1], [0.32, -0.38], [1, -0.38], [0, 0]]));
const cone = gl && paint.upload(lathe([[0, 0], [1, 1]], 36));
const preshape = new Float32Array(bytes(scene.preshape));

const centre = scene.centre, size = scene.size;
const home = () => ({ target: [...centre], turn: -0.9, lift: 0.45, far: 2.5 * size });
let camera = home(), shown = [], current = 0, waiting = false;

function eyeOf(c) {
  return add(c.target, [Math.cos(c.lift) * Math.cos(c.turn), Math.cos(c.lift) * Math.sin(c.turn), Math.sin(c.lift)], c.far);
}
function render() {
  waiting = false;
  if (!gl) return;
  const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth * ratio, height = canvas.clientHeight * ratio;
  if (canvas.width !== Math.round(width) || canvas.height !== Math.round(height)) [canvas.width, canvas.height] = [Math.round(width), Math.round(height)];
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  const eye = eyeOf(camera), view = lookAt(eye, camera.target, [0, 0, 1]);
  const aspect = canvas.width / Math.max(canvas.height, 1);
  gl.uniformMatrix4fv(paint.at.view, false, times(perspective(0.6, aspect, 0.02 * camera.far, 20 * camera.far), view));
  gl.uniform3fv(paint.at.eye, eye);
  gl.uniform3fv(paint.at.light, unit([0.5, 0.9, 0.7].reduce((sum, w, k) => add(sum, [view[k], view[4 + k], view[8 + k]], w * [-1, 1, 1][k]), [0, 0, 0])));
  drawScene();
  drawWrenches(view);
}
function drawScene() {
  const grasp = shown[current], alpha = (id) => Number(byId(id).value);
  const solids = [[() => gl && paint.draw(objectMesh, IDENTITY, colour(scene.object.colour, alpha("object-alpha"))), alpha("object-alpha")]];
  if (grasp) solids.push([() => drawHand(grasp, alpha("hand-alpha")), alpha("hand-alpha")]);
  solids.sort((a, b) => b[1] - a[1]).forEach(([draw, opacity]) => {
    if (opacity <= 0) return;
    gl.depthMask(opacity > 0.99);
    if (opacity > 0.99) return draw();
    // first the depth, then the nearest surface only: no jumble of inner faces
    gl.depthMask(true);
    gl.colorMask(false, false, false, false);
    draw();
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    draw();
    gl.depthFunc(gl.LESS);
  });
  gl.depthMask(true);
  if (!grasp || byId("pregrasp").checked) return;
  gl.depthMask(false);
  gl.depthFunc(gl.GREATER);
  drawContacts(grasp, 0.35);
  gl.depthMask(true);
  gl.depthFunc(gl.LESS);
  drawContacts(grasp, 1);
}
function linkPose(grasp, k) {
  const part = (poses) => Array.from(poses.subarray(16 * k, 16 * k + 16));
  return byId("pregrasp").checked && grasp.pregrasp ? times(grasp.pregrasp, part(preshape)) : part(grasp.poses);
}
function drawHand(grasp, opacity) {
  links.forEach((link, k) => paint.draw(link.mesh, linkPose(grasp, k), colour(link.colour, opacity)));
}
function drawContacts(grasp, opacity) {
  const small = scene.mark;
  grasp.contacts.forEach(({ point, normal }) => {
    if (byId("contacts").checked) {
      paint.draw(ball, along(point, normal, small, small), colour(scene.colours.contact, opacity));
      paint.draw(arrow, along(point, normal, 0.7 * small, 9 * small), colour(scene.colours.normal, opacity));
    }
    if (byId("cones").checked) {
      const length = 5 * small;
      paint.draw(cone, along(point, normal, scene.friction * length, length), colour(scene.colours.cone, 0.55 * opacity));
    }
  });
}
function redraw() {
  if (!waiting) requestAnimationFrame(render);
  waiting = true;
}

const words = (text) => text.replaceAll("_", " ");
const digits = (value, unit = "") => (value === null ? "not known" : `${Number(value).toPrecision(3)}${unit}`);
// Look from the side of the hand, a little past it, so that palm, fingers and object are all seen.
function follow(grasp) {
  const origins = links.map((_, k) => linkPose(grasp, k).slice(12, 15));
  const hand = origins.reduce((sum, origin) => add(sum, origin, 1 / origins.length), [0, 0, 0]);
  const side = add(hand, centre, -1), level = Math.hypot(side[0], side[1]);
  camera.target = add(centre, side, 0.5);
  camera.far = 3.2 * (0.5 * Math.hypot(...side) + 0.6 * size);
  if (level > 0.05 * size) camera.turn = Math.atan2(side[1], side[0]) + 0.75;
  camera.lift = Math.max(-0.6, Math.min(1, 0.35 + 0.5 * Math.atan2(side[2], level)));
}
function select(index) {
  current = Math.max(0, Math.min(shown.length - 1, index));
  const grasp = shown[current];
  if (grasp && byId("follow").checked) follow(grasp);
  byId("place").textContent = grasp ? `${current + 1} of ${shown.length}` : "none";
  const rows = grasp ? [
    ["outcome", words(grasp.outcome)], ["epsilon", digits(grasp.epsilon)], ["contacts", grasp.contacts.length],
    ["links touching", new Set(grasp.contacts.map((c) => c.link)).size], ["medial ball", digits(grasp.radius === null ? null : 1000 * grasp.radius, " mm")],
    ["number in file", grasp.number],
  ] : [];
  byId("facts").replaceChildren(...rows.flatMap(([name, value]) => ["dt", "dd"].map((tag, k) => {
    const element = document.createElement(tag);
    element.textContent = k ? value : name;
    return element;
  })));
  [...byId("list").children].forEach((item, k) => item.firstChild.setAttribute("aria-current", k === current));
  const list = byId("list"), row = list.children[current];
  if (row) list.scrollTop = Math.min(row.offsetTop - list.offsetTop, Math.max(list.scrollTop, row.offsetTop - list.offsetTop + row.offsetHeight - list.clientHeight));
  redraw();
}
function filter() {
  const wanted = byId("outcome").value;
  shown = scene.grasps.filter((grasp) => wanted === "all" || grasp.outcome === wanted);
  byId("list").replaceChildren(...shown.map((grasp, k) => {
    const item = document.createElement("li"), button = document.createElement("button");
    [`#${k + 1}`, words(grasp.outcome), grasp.epsilon === null ? "–" : grasp.epsilon.toFixed(3)].forEach((text) => {
      const span = document.createElement("span");
      span.textContent = text;
      button.append(span);
    });
    button.onclick = () => select(k);
    item.append(button);
    return item;
  }));
  select(0);
}

scene.grasps.forEach((grasp) => { grasp.poses = new Float32Array(bytes(grasp.poses)); });
const counts = {};
scene.grasps.forEach((grasp) => { counts[grasp.outcome] = (counts[grasp.outcome] || 0) + 1; });
byId("outcome").replaceChildren(...[["all", scene.grasps.length], ...Object.entries(counts)].map(([name, count]) =>
  new Option(`${name === "all" ? "every outcome" : words(name)} (${count})`, name)));
byId("outcome").onchange = filter;
byId("previous").onclick = () => select(current - 1);
byId("next").onclick = () => select(current + 1);
["object-alpha", "hand-alpha", "contacts", "cones"].forEach((id) => { byId(id).oninput = redraw; });
byId("home").onclick = () => { camera = home(); select(current); };
byId("follow").oninput = byId("pregrasp").oninput = () => select(current);

const pointers = new Map();
const slide = (dx, dy) => {
  const view = lookAt(eyeOf(camera), camera.target, [0, 0, 1]), step = (0.62 * camera.far) / canvas.clientHeight;
  camera.target = add(add(camera.target, [view[0], view[4], view[8]], -dx * step), [view[1], view[5], view[9]], dy * step);
};
const zoom = (factor) => { camera.far = Math.min(Math.max(camera.far * factor, 0.3 * size), 20 * size); };
canvas.onpointerdown = (event) => { pointers.set(event.pointerId, event); canvas.setPointerCapture(event.pointerId); };
canvas.onpointerup = canvas.onpointercancel = (event) => pointers.delete(event.pointerId);
canvas.onpointermove = (event) => {
  const last = pointers.get(event.pointerId);
  if (!last) return;
  const dx = event.clientX - last.clientX, dy = event.clientY - last.clientY;
  if (pointers.size === 2) {
    const other = [...pointers.values()].find((pointer) => pointer.pointerId !== event.pointerId);
    const gap = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
    zoom(gap(last) / Math.max(gap(event), 1));
    slide(0.5 * dx, 0.5 * dy);
  } else if (event.shiftKey || event.buttons & 6) slide(dx, dy);
  else {
    camera.turn -= 0.008 * dx;
    camera.lift = Math.min(Math.max(camera.lift + 0.008 * dy, -1.55), 1.55);
  }
  pointers.set(event.pointerId, event);
  redraw();
};
canvas.oncontextmenu = (event) => event.preventDefault();
canvas.addEventListener("wheel", (event) => { event.preventDefault(); zoom(Math.exp(0.001 * event.deltaY)); redraw(); }, { passive: false });
const KEYS = {
  ArrowLeft: () => select(current - 1), ArrowRight: () => select(current + 1), Home: () => select(0), End: () => select(shown.length - 1),
  r: () => byId("home").click(), c: () => byId("cones").click(), p: () => byId("pregrasp").click(), f: () => byId("follow").click(),
};
document.addEventListener("keydown", (event) => {
  if (["SELECT", "INPUT"].includes(event.target.tagName) || event.ctrlKey || event.altKey || event.metaKey || !KEYS[event.key]) return;
  event.preventDefault();
  KEYS[event.key]();
});
new ResizeObserver(redraw).observe(canvas);
filter();
