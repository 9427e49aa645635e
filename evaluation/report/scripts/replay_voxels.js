/* Which cells of several levels are drawn in three dimensions, by what a map knows at a frame. */
class Voxels {
  constructor(episode, grid) {
    const { width, walls } = episode;
    Object.assign(this, { grid, width, walls, size: walls.length, rise: (grid.high + 1) * width });
  }

  /* Call ``each`` with every cell of the lowest levels, with its row on its level and its column. */
  eachCell(levels, each) {
    for (let level = 0; level < levels; level++) {
      for (let row = 0; row < this.grid.high; row++) {
        const first = level * this.rise + row * this.width;
        for (let column = 0; column < this.width; column++) each(first + column, row, column);
      }
    }
  }

  /* The cells that a map shows at a frame on the lowest ``levels``: obstacles with an open face, floors, which are free
     cells above an obstacle or on level 0, and free cells beside unknown ones. A face is open unless it touches another
     obstacle that the map shows on these levels. */
  at(known, frame, levels) {
    const { grid, width, walls, size, rise } = this, end = levels * rise;
    const isUnknown = (cell) => known[cell] > frame && !grid.isBetween(Math.floor(cell / width));
    const isWall = (cell) => walls[cell] === 1 && known[cell] <= frame;
    const isOpen = (cell, row, column) => column === 0 || column === width - 1 || row === 0 || row === grid.high - 1
      || cell < rise || cell + rise >= end || !isWall(cell - 1) || !isWall(cell + 1) || !isWall(cell - width)
      || !isWall(cell + width) || !isWall(cell - rise) || !isWall(cell + rise);
    const found = { walls: [], floors: [], frontier: [] };
    this.eachCell(levels, (cell, row, column) => {
      if (known[cell] > frame) return;
      if (walls[cell]) {
        if (isOpen(cell, row, column)) found.walls.push(cell);
        return;
      }
      if (cell < rise || isWall(cell - rise)) found.floors.push(cell);
      if (isFrontier(isUnknown, cell, width, size, rise)) found.frontier.push(cell);
    });
    return found;
  }

  /* Levels below those at the top that are nothing but obstacles: a roof. */
  get underRoof() {
    let levels = this.grid.levels;
    const isRoof = (level) => this.walls.subarray((level - 1) * this.rise, level * this.rise - this.width).every((wall) => wall === 1);
    while (levels > 1 && isRoof(levels)) levels--;
    return levels;
  }

  /* Where the centre of a cell is: to the right its column, up its level, to the front its row. */
  place(row, column) {
    const level = this.grid.levelOf(row);
    return [column + 0.5, level + 0.5, row - level * (this.grid.high + 1) + 0.5];
  }

  placeOf(cell) { return this.place(Math.floor(cell / this.width), cell % this.width); }
}
