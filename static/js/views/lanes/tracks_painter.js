// @ts-check
/** The bars of all tracks. Draws what is visible only, at most about one bar a pixel and row; allocates nothing. */

import { lowerBound } from '../../model/lanes_lod.js';

/**
 * @typedef {object} TracksFrame
 * @property {number} width          CSS px
 * @property {number} height
 * @property {number} scroll         px that are scrolled away above
 * @property {number} rowHeight
 * @property {{first: number, last: number}} span
 * @property {string|null} selected  key
 * @property {readonly string[]} marked   keys of those that are to be merged
 */

/** Where the reviewed part of a bar is marked, by state: nothing, accepted, rejected, needs work. */
const MARKS = ['', '✓', '✕', '!'];
/** Half the height of a diamond, as a share of the row. */
const DIAMOND = 0.34;

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {TracksFrame} view
 * @param {import('./palette.js').Palette} palette
 * @param {(classId: number) => {text: string, width: number}} label
 */
export function paintTracks(ctx, index, view, palette, label) {
  const { width, height, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  const firstRow = Math.max(0, Math.floor(scroll / rowHeight));
  const lastRow = Math.min(index.rows - 1, Math.floor((scroll + height) / rowHeight));
  const chosen = view.selected === null ? -1 : (index.barOf.get(view.selected) ?? -1);
  const pad = Math.max(1, Math.round(2 * palette.unit));
  const tall = rowHeight - 2 * pad;
  ctx.fillStyle = palette.colour.selected;
  if (chosen >= 0) ctx.fillRect(0, index.row[chosen] * rowHeight - scroll, width, rowHeight);
  for (const key of view.marked) {
    const b = index.barOf.get(key) ?? -1;
    if (b < 0) continue;
    const from = (index.first[b] - span.first) * scale;
    ctx.fillRect(from - 2 * pad, index.row[b] * rowHeight - scroll, (index.last[b] + 1 - index.first[b]) * scale + 4 * pad, rowHeight);
  }
  for (let source = 0; source < 4; source += 1) {
    // A texture cannot be read on slivers, and costs most there: while they are the rule, plain colour stands for it.
    ctx.fillStyle = scale < 0.25 ? palette.sourceColour[source] : palette.source[source];
    for (let r = firstRow; r <= lastRow; r += 1) {
      const top = r * rowHeight - scroll + pad;
      const stop = index.rowStart[r + 1];
      let painted = -1;
      for (let b = lowerBound(index.last, index.rowStart[r], stop, Math.floor(span.first)); b < stop; b += 1) {
        if (index.first[b] > span.last) break;
        for (let p = index.pieceStart[b]; p < index.pieceStart[b + 1]; p += 1) {
          if (index.pieceSource[p] !== source) continue;
          const from = Math.max(-2, (index.pieceFirst[p] - span.first) * scale);
          const to = Math.min(width + 2, (index.pieceLast[p] + 1 - span.first) * scale);
          if (to < 0 || from > width || to < painted) continue;
          const right = Math.max(to, from + 1);
          ctx.fillRect(Math.round(from), top, Math.max(1, Math.round(right) - Math.round(from)), tall);
          if (right - from < 2) painted = Math.floor(right) + 1;
        }
      }
    }
  }
  paintOutlines(ctx, index, view, palette, chosen, firstRow, lastRow, label);
}

/**
 * Edges, key frames, labels and the selected track's frame: only where a bar is wide enough to show them.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {TracksFrame} view
 * @param {import('./palette.js').Palette} palette
 * @param {number} chosen
 * @param {number} firstRow
 * @param {number} lastRow
 * @param {(classId: number) => {text: string, width: number}} label
 */
function paintOutlines(ctx, index, view, palette, chosen, firstRow, lastRow, label) {
  const { width, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  const { unit, colour } = palette;
  const pad = Math.max(1, Math.round(2 * unit));
  const tall = rowHeight - 2 * pad;
  ctx.font = palette.smallFont;
  ctx.textBaseline = 'middle';
  ctx.lineWidth = 1;
  ctx.strokeStyle = colour.lineStrong;
  ctx.beginPath();
  for (let r = firstRow; r <= lastRow; r += 1) {
    const top = r * rowHeight - scroll + pad;
    const stop = index.rowStart[r + 1];
    for (let b = lowerBound(index.last, index.rowStart[r], stop, Math.floor(span.first)); b < stop; b += 1) {
      if (index.first[b] > span.last) break;
      const from = Math.max(-2, (index.first[b] - span.first) * scale);
      const to = Math.min(width + 2, (index.last[b] + 1 - span.first) * scale);
      if (to - from < 5) continue;
      ctx.rect(from + 0.5, top + 0.5, to - from - 1, tall - 1);
      const name = label(index.classId[b]);
      const at = pastDiamond(index, b, Math.max(from, 0) + 4 * unit, (frame) => (frame + 0.5 - span.first) * scale, rowHeight * DIAMOND, unit);
      if (Math.min(to, width) - at < name.width + 4 * unit) continue;
      ctx.fillStyle = 'rgb(255 255 255 / 0.72)';
      ctx.fillRect(at - 2 * unit, top + 1, name.width + 4 * unit, tall - 2);
      ctx.fillStyle = '#101317';
      ctx.fillText(name.text, at, top + tall / 2 + 0.5);
      const mark = MARKS[index.review[b]];
      if (mark && Math.min(to, width) - at > name.width + 18 * unit) ctx.fillText(mark, at + name.width + 6 * unit, top + tall / 2 + 0.5);
    }
  }
  ctx.stroke();
  paintKeys(ctx, index, view, palette, firstRow, lastRow);
  if (chosen < 0) return;
  const from = (index.first[chosen] - span.first) * scale;
  const to = Math.max(from + 3, (index.last[chosen] + 1 - span.first) * scale);
  ctx.strokeStyle = colour.accent;
  ctx.lineWidth = 2 * unit;
  ctx.strokeRect(from, index.row[chosen] * rowHeight - scroll + pad - 0.5, to - from, tall + 1);
}

/**
 * Where the label of a bar begins: behind the diamond of its first key frame, where that would lie on it.
 *
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {number} b
 * @param {number} at        where it would begin, px
 * @param {(frame: number) => number} toX
 * @param {number} radius    of a diamond, px
 * @param {number} unit
 */
function pastDiamond(index, b, at, toX, radius, unit) {
  if (index.keyStart[b] === index.keyStart[b + 1]) return at;
  const x = toX(index.keyFrame[index.keyStart[b]]);
  return x + radius > at - 2 * unit && x - radius < at + 6 * unit ? x + radius + 3 * unit : at;
}

/**
 * Diamonds on the frames that people set, above labels so that none is hidden.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {TracksFrame} view
 * @param {import('./palette.js').Palette} palette
 * @param {number} firstRow
 * @param {number} lastRow
 */
function paintKeys(ctx, index, view, palette, firstRow, lastRow) {
  if (index.keyFrame.length === 0) return;
  const { width, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  ctx.beginPath();
  for (let r = firstRow; r <= lastRow; r += 1) {
    const middle = (r + 0.5) * rowHeight - scroll;
    const stop = index.rowStart[r + 1];
    for (let b = lowerBound(index.last, index.rowStart[r], stop, Math.floor(span.first)); b < stop; b += 1) {
      if (index.first[b] > span.last) break;
      let drawn = -1e9;
      for (let k = index.keyStart[b]; k < index.keyStart[b + 1]; k += 1) {
        const x = (index.keyFrame[k] + 0.5 - span.first) * scale;
        if (x < -8 || x > width + 8 || x - drawn < 2) continue;
        diamond(ctx, x, middle, rowHeight * DIAMOND);
        drawn = x;
      }
    }
  }
  ctx.fillStyle = palette.sourceColour[3];
  ctx.strokeStyle = '#101317';
  ctx.lineWidth = 1;
  ctx.fill();
  ctx.stroke();
}

/** @param {CanvasRenderingContext2D} ctx @param {number} x @param {number} y @param {number} r */
function diamond(ctx, x, y, r) {
  ctx.moveTo(x, y - r);
  ctx.lineTo(x + r, y);
  ctx.lineTo(x, y + r);
  ctx.lineTo(x - r, y);
  ctx.closePath();
}
