// @ts-check
/** Marks on the bars of tracks: diamonds on key frames, and names placed clear of them. */

import { firstGap } from '../../model/gaps.js';

/**
 * @typedef {import('../../model/lanes_lod.js').LaneIndex} LaneIndex
 * @typedef {import('./tracks_painter.js').TracksView} TracksFrame
 */

/** Mark of a bar by review state: open, accepted, rejected, needs work. */
const REVIEW_MARKS = ['', '✓', '✕', '!'];
/** Half the height of a diamond, as a share of the row. */
const DIAMOND_HALF_HEIGHT = 0.34;

/**
 * Names of bars that are wide enough. A name is placed between the diamonds if it fits, else over them, because it says
 * more than closely spaced diamonds.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {LaneIndex} index
 * @param {TracksFrame} view
 * @param {import('./palette.js').Palette} palette
 * @param {readonly number[]} bars
 * @param {(classId: number) => {text: string, width: number}} label
 */
export function paintLabels(ctx, index, view, palette, bars, label) {
  const { width, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  const { unit } = palette;
  const pad = Math.max(1, Math.round(2 * unit));
  const halfDiamond = rowHeight * DIAMOND_HALF_HEIGHT;
  ctx.font = palette.smallFont;
  ctx.textBaseline = 'middle';
  for (const b of bars) {
    const left = Math.max(0, (index.first[b] - span.first) * scale) + 2 * unit;
    const right = Math.min(width + 2, (index.last[b] + 1 - span.first) * scale) - 2 * unit;
    const name = label(index.classId[b]);
    const mark = REVIEW_MARKS[index.review[b]];
    const nameWidth = name.width + 4 * unit;
    const markedWidth = mark ? nameWidth + 14 * unit : nameWidth;
    if (right - left < nameWidth) continue;
    const firstKey = index.keyStart[b];
    /** @param {number} neededWidth */
    const gap = (neededWidth) =>
      firstGap(
        left,
        right,
        neededWidth,
        index.keyStart[b + 1] - firstKey,
        (i) => (index.keyFrame[firstKey + i] + 0.5 - span.first) * scale,
        halfDiamond,
      );
    const freeX = gap(markedWidth) ?? gap(nameWidth);
    const x = freeX ?? left;
    const top = index.row[b] * rowHeight - scroll + pad;
    const barHeight = rowHeight - 2 * pad;
    ctx.fillStyle = freeX === null ? 'rgb(255 255 255 / 0.92)' : 'rgb(255 255 255 / 0.72)';
    ctx.fillRect(x, top + 1, nameWidth, barHeight - 2);
    ctx.fillStyle = '#101317';
    ctx.fillText(name.text, x + 2 * unit, top + barHeight / 2 + 0.5);
    if (mark && right - x >= markedWidth) ctx.fillText(mark, x + nameWidth + 4 * unit, top + barHeight / 2 + 0.5);
  }
}

/**
 * Diamonds on key frames.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {LaneIndex} index
 * @param {TracksFrame} view
 * @param {import('./palette.js').Palette} palette
 * @param {readonly number[]} bars
 */
export function paintKeys(ctx, index, view, palette, bars) {
  if (index.keyFrame.length === 0) return;
  const { width, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  ctx.beginPath();
  for (const b of bars) {
    const middle = (index.row[b] + 0.5) * rowHeight - scroll;
    let lastX = -1e9;
    for (let k = index.keyStart[b]; k < index.keyStart[b + 1]; k += 1) {
      const x = (index.keyFrame[k] + 0.5 - span.first) * scale;
      if (x < -8 || x > width + 8 || x - lastX < 2) continue;
      diamond(ctx, x, middle, rowHeight * DIAMOND_HALF_HEIGHT);
      lastX = x;
    }
  }
  ctx.fillStyle = palette.sourceColour[3];
  ctx.strokeStyle = '#101317';
  ctx.lineWidth = 1;
  ctx.fill();
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {number} x @param {number} y @param {number} radius */
function diamond(ctx, x, y, radius) {
  ctx.moveTo(x, y - radius);
  ctx.lineTo(x + radius, y);
  ctx.lineTo(x, y + radius);
  ctx.lineTo(x - radius, y);
  ctx.closePath();
}
