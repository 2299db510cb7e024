// @ts-check
/** The value lanes of the selected track. One pass per line; several values in one pixel are drawn as their range. */

import { lastIndexAt } from '../../model/detail_columns.js';
import { logPosition } from '../../model/gate_lane.js';

/**
 * @typedef {import('../../model/detail_columns.js').DetailColumns} DetailColumns
 * @typedef {import('./palette.js').Palette} Palette
 * @typedef {{first: number, last: number}} Span
 * @typedef {import('../../model/sub_lanes.js').SubLane} SubLane
 */

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {DetailColumns} columns
 * @param {{width: number, span: Span, tau: number, lanes: readonly SubLane[]}} view
 * @param {Palette} palette
 */
export function paintDetail(ctx, columns, view, palette) {
  const { width, span, tau, lanes } = view;
  const from = Math.max(0, lastIndexAt(columns.frame, Math.floor(span.first)));
  const to = Math.min(columns.count, lastIndexAt(columns.frame, Math.ceil(span.last)) + 2);
  let top = 0;
  for (const lane of lanes) {
    const height = Math.round(lane.height * palette.unit);
    ctx.fillStyle = palette.colour.line;
    ctx.fillRect(0, top + height - 1, width, 1);
    const pad = 4 * palette.unit;
    const area = { x: 0, y: top + pad, width, height: height - 2 * pad, span };
    if (lane.kind === 'gate') paintGate(ctx, columns, from, to, area, tau, palette);
    else if (lane.kind === 'votes') paintVotes(ctx, columns, from, to, area, palette);
    else paintSeries(ctx, columns, lane, from, to, area, palette);
    top += height;
  }
}

/** @typedef {{x: number, y: number, width: number, height: number, span: Span}} Area */

/**
 * @param {CanvasRenderingContext2D} ctx
 * @param {DetailColumns} columns
 * @param {SubLane} lane
 * @param {number} from
 * @param {number} to
 * @param {Area} area
 * @param {Palette} palette
 */
function paintSeries(ctx, columns, lane, from, to, area, palette) {
  const [low, high] = columns.range[lane.series[0]];
  if (low < 0 && high > 0) {
    ctx.fillStyle = palette.colour.grid;
    ctx.fillRect(0, Math.round(area.y + area.height * (high / (high - low))), area.width, 1);
  }
  lane.series.forEach((name, i) => {
    ctx.strokeStyle = i === 0 ? palette.colour.plot : palette.series[1];
    ctx.lineWidth = 1.5 * palette.unit;
    if (i > 0) ctx.setLineDash([4 * palette.unit, 3 * palette.unit]);
    drawLine(ctx, columns, columns.series[name], from, to, area, low, high, palette.unit);
    ctx.setLineDash([]);
  });
}

/**
 * A line with gaps where a step did not take place. A value without neighbours is a dot.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {DetailColumns} columns
 * @param {Float32Array} values
 * @param {number} from
 * @param {number} to
 * @param {Area} area
 * @param {number} low
 * @param {number} high
 * @param {number} unit
 */
function drawLine(ctx, columns, values, from, to, area, low, high, unit) {
  const scale = area.width / (area.span.last - area.span.first);
  const { frame } = columns;
  let isDrawing = false;
  let lastX = -1e9;
  let minY = 0;
  let maxY = 0;
  let previousFrame = -2;
  ctx.beginPath();
  for (let i = from; i < to; i += 1) {
    const value = values[i];
    if (value !== value) {
      isDrawing = false;
      continue;
    }
    const share = Math.min(1, Math.max(0, (value - low) / (high - low)));
    const y = area.y + area.height * (1 - share);
    const x = (frame[i] + 0.5 - area.span.first) * scale;
    if (isDrawing && frame[i] === previousFrame + 1) {
      if (Math.floor(x) === lastX && y >= minY && y <= maxY) {
        previousFrame = frame[i];
        continue;
      }
      ctx.lineTo(x, y);
      if (Math.floor(x) === lastX) {
        minY = Math.min(minY, y);
        maxY = Math.max(maxY, y);
      } else {
        lastX = Math.floor(x);
        minY = maxY = y;
      }
    } else {
      ctx.moveTo(x - unit, y);
      ctx.lineTo(x + unit, y);
      ctx.moveTo(x, y);
      lastX = Math.floor(x);
      minY = maxY = y;
    }
    isDrawing = true;
    previousFrame = frame[i];
  }
  ctx.stroke();
}

/**
 * L_positive: circles are confident, crosses rejected; a ring marks a verdict that flips at the dragged tau.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {DetailColumns} columns
 * @param {number} from
 * @param {number} to
 * @param {Area} area
 * @param {number} tau
 * @param {Palette} palette
 */
function paintGate(ctx, columns, from, to, area, tau, palette) {
  const { domain, frame, confident } = columns;
  const values = columns.series.l_positive;
  const scale = area.width / (area.span.last - area.span.first);
  const { unit, colour } = palette;
  ctx.fillStyle = colour.grid;
  ctx.font = palette.smallFont;
  ctx.textBaseline = 'middle';
  for (let decade = domain.low; decade <= domain.high * 1.001; decade *= 10) {
    ctx.fillRect(0, Math.round(area.y + area.height * (1 - logPosition(decade, domain))), area.width, 1);
  }
  const radius = Math.min(3 * unit, Math.max(1.2 * unit, scale * 0.4));
  for (let verdict = 0; verdict < 3; verdict += 1) {
    let lastX = -1;
    let lastY = -1;
    ctx.beginPath();
    for (let i = from; i < to; i += 1) {
      if (confident[i] < 0 || values[i] !== values[i]) continue;
      const isFlipped = values[i] < tau !== (confident[i] === 1);
      if (verdict === 2 ? !isFlipped : confident[i] !== verdict) continue;
      const x = (frame[i] + 0.5 - area.span.first) * scale;
      const y = area.y + area.height * (1 - logPosition(values[i], domain));
      // Skip points on the pixel of the last one, which would be painted over it.
      if (Math.floor(x) === lastX && Math.floor(y) === lastY) continue;
      lastX = Math.floor(x);
      lastY = Math.floor(y);
      if (verdict === 1) {
        ctx.moveTo(x + radius, y);
        ctx.arc(x, y, radius, 0, 2 * Math.PI);
      } else if (verdict === 0) {
        ctx.moveTo(x - radius, y - radius);
        ctx.lineTo(x + radius, y + radius);
        ctx.moveTo(x - radius, y + radius);
        ctx.lineTo(x + radius, y - radius);
      } else {
        ctx.moveTo(x + radius * 2, y);
        ctx.arc(x, y, radius * 2, 0, 2 * Math.PI);
      }
    }
    ctx.lineWidth = 1.5 * unit;
    if (verdict === 1) {
      ctx.fillStyle = colour.good;
      ctx.fill();
    } else {
      ctx.strokeStyle = verdict === 0 ? colour.bad : colour.accent;
      ctx.stroke();
    }
  }
}

/**
 * Stacked shares. The rest of the classes is left blank, and so is a frame without the track.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {DetailColumns} columns
 * @param {number} from
 * @param {number} to
 * @param {Area} area
 * @param {Palette} palette
 */
function paintVotes(ctx, columns, from, to, area, palette) {
  const width = columns.classes.length;
  const scale = area.width / (area.span.last - area.span.first);
  const { votes, frame } = columns;
  ctx.fillStyle = palette.colour.surface2;
  ctx.fillRect(0, area.y, area.width, area.height);
  for (let c = width - 1; c >= 0; c -= 1) {
    ctx.fillStyle = palette.series[c % palette.series.length];
    ctx.beginPath();
    let lastX = -1;
    for (let i = from; i < to; i += 1) {
      const share = votes[i * width + c];
      if (share !== share) continue;
      const left = (frame[i] - area.span.first) * scale;
      if (Math.floor(left) === lastX && i + 1 < to) continue;
      lastX = Math.floor(left);
      // only its own frame: nothing was seen between the parts of a merged track
      ctx.rect(left, area.y + area.height * (1 - share), Math.max(1, scale) + 0.5, area.height * share);
    }
    ctx.fill();
  }
}
