/* Where the cells of a map are in its picture. Several levels, which lie one below the other in the data with a row of
   obstacles between, are beside each other in a grid, level 0 first; a map of one level is its own picture. */
class LevelGrid {
  constructor({ width, height, levels = 1 }, columns = 1) {
    const high = (height + 1) / levels - 1;
    Object.assign(this, { levels, columns, high, wide: width });
    this.gap = levels > 1 ? Math.max(2, Math.ceil(Math.max(high, width) / 10)) : 0;
    this.width = columns * (width + this.gap) - this.gap;
    this.height = Math.ceil(levels / columns) * (high + this.gap);
  }

  static options(episode) { return Array.from({ length: episode.levels || 1 }, (_, k) => new LevelGrid(episode, k + 1)); }

  levelOf(row) { return Math.floor(row / (this.high + 1)); }

  /* Whether a row of the data is one between two levels. */
  isBetween(row) { return row % (this.high + 1) === this.high; }

  /* The first row and column of a level in the picture. */
  corner(level) {
    return [Math.floor(level / this.columns) * (this.high + this.gap) + this.gap, (level % this.columns) * (this.wide + this.gap)];
  }

  /* The row and column of a cell in the picture. */
  place(row, column) {
    const level = this.levelOf(row), [down, right] = this.corner(level);
    return [down + row - level * (this.high + 1), right + column];
  }

  /* A cell of the data as text: its level where there are several, row and column. */
  text(row, column) {
    const level = this.levelOf(row), cell = [row - level * (this.high + 1), column];
    return `(${(this.levels > 1 ? [level, ...cell] : cell).join(", ")})`;
  }

  /* Draw only on one level, or everywhere where there is no other. */
  within(level, pen, scale, draw) {
    const [row, column] = this.corner(level);
    pen.save();
    pen.beginPath();
    pen.rect(column * scale, row * scale, this.wide * scale, this.high * scale);
    pen.clip();
    draw();
    pen.restore();
  }

  /* Draw the borders and names of several levels. */
  outline(pen, scale, ratio, inks) {
    const size = Math.min(12 * ratio, 0.7 * this.gap * scale);
    pen.font = `${size}px system-ui, sans-serif`;
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    pen.fillStyle = inks.soft;
    pen.strokeStyle = inks.line;
    pen.lineWidth = ratio;
    for (let level = 0; level < this.levels && this.levels > 1; level++) {
      const [row, column] = this.corner(level), half = ratio / 2;
      pen.strokeRect(column * scale + half, row * scale + half, this.wide * scale - ratio, this.high * scale - ratio);
      pen.fillText(`level ${level}`, column * scale, (row - this.gap / 2) * scale);
    }
  }
}
