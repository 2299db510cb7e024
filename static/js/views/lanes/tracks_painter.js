// @ts-check
/** The bars of all tracks. Draws only visible bars, at most about one per pixel and row. */

import { lowerBound } from '../../model/lanes_lod.js';
import { paintKeys, paintLabels } from './tracks_labels.js';

/**
 * @typedef {object} TracksView
 * @property {number} width          CSS px
 * @property {number} height
 * @property {number} scroll         scroll offset, px
 * @property {number} rowHeight
 * @property {{first: number, last: number}} span
 * @property {string|null} selected  key
 * @property {readonly string[]} marked   keys of tracks marked for a merge
 */

/** Minimum width of a bar with an edge and a name, px. */
const MIN_LABELLED_WIDTH_PX = 5;

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {TracksView} view
 * @param {import('./palette.js').Palette} palette
 * @param {(classId: number) => {text: string, width: number}} label
 */
export function paintTracks(ctx, index, view, palette, label) {
  const { width, height, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  const firstRow = Math.max(0, Math.floor(scroll / rowHeight));
  const lastRow = Math.min(index.rows - 1, Math.floor((scroll + height) / rowHeight));
  const selectedBar = view.selected === null ? -1 : (index.barOf.get(view.selected) ?? -1);
  const pad = Math.max(1, Math.round(2 * palette.unit));
  const barHeight = rowHeight - 2 * pad;
  ctx.fillStyle = palette.colour.selected;
  if (selectedBar >= 0) ctx.fillRect(0, index.row[selectedBar] * rowHeight - scroll, width, rowHeight);
  for (const key of view.marked) {
    const bar = index.barOf.get(key) ?? -1;
    if (bar < 0) continue;
    const from = (index.first[bar] - span.first) * scale;
    ctx.fillRect(
      from - 2 * pad,
      index.row[bar] * rowHeight - scroll,
      (index.last[bar] + 1 - index.first[bar]) * scale + 4 * pad,
      rowHeight,
    );
  }
  for (let source = 0; source < 4; source += 1) {
    // A texture is illegible on narrow bars and costs most there: if most bars are narrow, use plain colour.
    ctx.fillStyle = scale < 0.25 ? palette.sourceColour[source] : palette.source[source];
    for (let row = firstRow; row <= lastRow; row += 1) {
      const top = row * rowHeight - scroll + pad;
      const stop = index.rowStart[row + 1];
      let paintedTo = -1;
      for (let bar = lowerBound(index.last, index.rowStart[row], stop, Math.floor(span.first)); bar < stop; bar += 1) {
        if (index.first[bar] > span.last) break;
        for (let piece = index.pieceStart[bar]; piece < index.pieceStart[bar + 1]; piece += 1) {
          if (index.pieceSource[piece] !== source) continue;
          const from = Math.max(-2, (index.pieceFirst[piece] - span.first) * scale);
          const to = Math.min(width + 2, (index.pieceLast[piece] + 1 - span.first) * scale);
          if (to < 0 || from > width || to < paintedTo) continue;
          const right = Math.max(to, from + 1);
          ctx.fillRect(Math.round(from), top, Math.max(1, Math.round(right) - Math.round(from)), barHeight);
          if (right - from < 2) paintedTo = Math.floor(right) + 1;
        }
      }
    }
  }
  const visibleBars = barsToMark(index, span, scale, firstRow, lastRow);
  // narrow bars have no legible texture or edge
  const wideBars = visibleBars.filter((bar) => widthOf(index, span, scale, bar) >= MIN_LABELLED_WIDTH_PX);
  paintEdges(ctx, index, view, palette, wideBars);
  paintKeys(ctx, index, view, palette, visibleBars);
  paintLabels(ctx, index, view, palette, wideBars, label);
  for (const key of view.marked) {
    const bar = index.barOf.get(key) ?? -1;
    if (bar >= 0 && bar !== selectedBar) paintOutline(ctx, index, view, palette, bar);
  }
  if (selectedBar >= 0) paintOutline(ctx, index, view, palette, selectedBar);
}

/** Visible width of a bar, px. @param {import('../../model/lanes_lod.js').LaneIndex} index @param {TracksView['span']} span @param {number} scale @param {number} bar */
const widthOf = (index, span, scale, bar) => (Math.min(index.last[bar] + 1, span.last) - Math.max(index.first[bar], span.first)) * scale;

/**
 * Visible bars that are wide enough for an edge or have key frames. Their number is small when there are many bars.
 *
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {TracksView['span']} span
 * @param {number} scale      px per frame
 * @param {number} firstRow
 * @param {number} lastRow
 */
function barsToMark(index, span, scale, firstRow, lastRow) {
  const found = [];
  for (let row = firstRow; row <= lastRow; row += 1) {
    const stop = index.rowStart[row + 1];
    for (
      let bar = lowerBound(index.last, index.rowStart[row], stop, Math.floor(span.first));
      bar < stop && index.first[bar] <= span.last;
      bar += 1
    ) {
      if (index.keyStart[bar] < index.keyStart[bar + 1] || widthOf(index, span, scale, bar) >= MIN_LABELLED_WIDTH_PX) found.push(bar);
    }
  }
  return found;
}

/**
 * Edges of bars.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {TracksView} view
 * @param {import('./palette.js').Palette} palette
 * @param {readonly number[]} bars
 */
function paintEdges(ctx, index, view, palette, bars) {
  const { width, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  const pad = Math.max(1, Math.round(2 * palette.unit));
  ctx.lineWidth = 1;
  ctx.strokeStyle = palette.colour.lineStrong;
  ctx.beginPath();
  for (const bar of bars) {
    const from = Math.max(-2, (index.first[bar] - span.first) * scale);
    const to = Math.min(width + 2, (index.last[bar] + 1 - span.first) * scale);
    ctx.rect(from + 0.5, index.row[bar] * rowHeight - scroll + pad + 0.5, to - from - 1, rowHeight - 2 * pad - 1);
  }
  ctx.stroke();
}

/**
 * The frame around the selected track, and around those marked for a merge.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {import('../../model/lanes_lod.js').LaneIndex} index
 * @param {TracksView} view
 * @param {import('./palette.js').Palette} palette
 * @param {number} bar
 */
function paintOutline(ctx, index, view, palette, bar) {
  const { width, scroll, rowHeight, span } = view;
  const scale = width / (span.last - span.first);
  const pad = Math.max(1, Math.round(2 * palette.unit));
  const from = (index.first[bar] - span.first) * scale;
  const to = Math.max(from + 3, (index.last[bar] + 1 - span.first) * scale);
  ctx.strokeStyle = palette.colour.accent;
  ctx.lineWidth = 2 * palette.unit;
  ctx.strokeRect(from, index.row[bar] * rowHeight - scroll + pad - 0.5, to - from, rowHeight - 2 * pad + 1);
}
