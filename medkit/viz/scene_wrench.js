// What the grasp answers, as seen now: the shadow of its wrench space on the screen, forces left, torques right.
// The ball of radius epsilon fits into the wrench space, so its shadow, a disk, fits into both.
function wrenches(grasp) {
  const turn = 2 * Math.PI / 8;
  return grasp.contacts.flatMap(({ point, normal }) => {
    const inward = unit(normal), side = unit(cross(inward, Math.abs(inward[0]) < 0.7 ? [1, 0, 0] : [0, 1, 0])), up = cross(inward, side);
    const arm = add(point, scene.mass, -1);
    return [...Array(8)].map((_, k) => {
      const force = add(add(inward, side, scene.friction * Math.cos(k * turn)), up, scene.friction * Math.sin(k * turn));
      return [force, cross(arm, force).map((t) => t / scene.reach)];
    });
  });
}
// Andrew's chain: corners of the convex hull in order.
function outline(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => list.reduce((kept, p) => {
    const right = () => { const [a, b] = kept.slice(-2); return (b[0] - a[0]) * (p[1] - a[1]) <= (b[1] - a[1]) * (p[0] - a[0]); };
    while (kept.length > 1 && right()) kept.pop();
    kept.push(p);
    return kept;
  }, []);
  return [...half(sorted).slice(0, -1), ...half(sorted.reverse()).slice(0, -1)];
}
function drawWrenches(view) {
  const sheet = byId("wrench"), grasp = shown[current], ratio = window.devicePixelRatio || 1;
  sheet.parentNode.hidden = !grasp || !grasp.contacts.length;
  if (sheet.parentNode.hidden) return;
  const width = sheet.clientWidth, height = sheet.clientHeight, pen = sheet.getContext("2d");
  [sheet.width, sheet.height] = [width * ratio, height * ratio];
  pen.scale(ratio, ratio);
  const right = [view[0], view[4], view[8]], up = [view[1], view[5], view[9]];
  const list = wrenches(grasp);
  [0, 1].forEach((kind) => {
    const flat = outline(list.map((wrench) => [dot(wrench[kind], right), dot(wrench[kind], up)]));
    const half = Math.max(1e-9, ...flat.flat().map(Math.abs), grasp.epsilon || 0), scale = (0.42 * Math.min(width / 2, height)) / half;
    const at = ([x, y]) => [width * (0.25 + 0.5 * kind) + scale * x, 0.5 * height - scale * y];
    pen.beginPath();
    flat.forEach((p) => pen.lineTo(...at(p)));
    pen.closePath();
    pen.fillStyle = scene.colours.hull + "55";
    pen.strokeStyle = scene.colours.hull;
    pen.fill();
    pen.stroke();
    pen.beginPath();
    pen.arc(...at([0, 0]), Math.max(1.5, scale * (grasp.epsilon || 0)), 0, 2 * Math.PI);
    pen.fillStyle = scene.colours.ball;
    pen.fill();
  });
}
