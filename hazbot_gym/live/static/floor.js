// The floor that the robot and people can reach: a flood from the path, on a grid that walls divide.

const CELL_M = 0.05;

/** Call `paint(x, y, width, height)` for strips that cover the reachable floor within a box. */
export function reachable({ walls, path }, [left, bottom, right, top], paint) {
  const columns = Math.ceil((right - left) / CELL_M);
  const rows = Math.ceil((top - bottom) / CELL_M);
  const cells = new Uint8Array(columns * rows); // 0 free, 1 wall, 2 reached
  const cellOf = (x, y) => [Math.floor((x - left) / CELL_M), Math.floor((y - bottom) / CELL_M)];
  const isInside = (column, row) => column >= 0 && row >= 0 && column < columns && row < rows;
  for (const [x1, y1, x2, y2] of walls) {
    const steps = Math.ceil((2 * Math.hypot(x2 - x1, y2 - y1)) / CELL_M) + 1;
    for (let k = 0; k <= steps; k += 1) {
      const [column, row] = cellOf(x1 + (k / steps) * (x2 - x1), y1 + (k / steps) * (y2 - y1));
      if (isInside(column, row)) cells[row * columns + column] = 1;
    }
  }
  const open = path.map(([x, y]) => cellOf(x, y));
  while (open.length) {
    const [column, row] = open.pop();
    if (!isInside(column, row) || cells[row * columns + column]) continue;
    cells[row * columns + column] = 2;
    open.push([column + 1, row], [column - 1, row], [column, row + 1], [column, row - 1]);
  }
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0, start = -1; column <= columns; column += 1) {
      const isReached = column < columns && cells[row * columns + column] === 2;
      if (isReached && start < 0) start = column;
      if (isReached || start < 0) continue;
      paint(left + start * CELL_M, bottom + row * CELL_M, (column - start) * CELL_M, CELL_M * 1.02);
      start = -1;
    }
  }
}
