// Shapes on a canvas, in the units of its context, and rays and points on segments.

export function trace(context, points) {
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
}

export function stroke(context, points, color, width, dash = []) {
  trace(context, points);
  context.strokeStyle = color;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}

export function fill(context, points, color) {
  trace(context, points);
  context.closePath();
  context.fillStyle = color;
  context.fill();
}

export function disc(context, x, y, radius, color) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fillStyle = color;
  context.fill();
}

export function ring(context, x, y, radius, color, width, dash = []) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.strokeStyle = color;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}

/** Return how far a ray goes before it meets a wall. */
export function free(walls, x, y, ux, uy) {
  let nearestWall = Infinity;
  for (const [x1, y1, x2, y2] of walls) {
    const [sx, sy] = [x2 - x1, y2 - y1];
    const cross = ux * sy - uy * sx;
    if (!cross) continue;
    const away = ((x1 - x) * sy - (y1 - y) * sx) / cross;
    const along = ((x1 - x) * uy - (y1 - y) * ux) / cross;
    if (away >= 0 && along >= 0 && along <= 1) nearestWall = Math.min(nearestWall, away);
  }
  return nearestWall;
}

export function nearest([x1, y1, x2, y2], x, y) {
  const [sx, sy] = [x2 - x1, y2 - y1];
  const along = Math.max(0, Math.min(1, ((x - x1) * sx + (y - y1) * sy) / (sx * sx + sy * sy || 1)));
  return [x1 + along * sx, y1 + along * sy];
}
