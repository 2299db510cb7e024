// @ts-check
/** The time axis and the overview of the whole drive above it. */

import { levelFor } from '../../model/lanes_lod.js';
import { tickStep, timeLabel, toX } from '../../model/time_axis.js';

/**
 * Ticks with the time of their frame, and the frame number if it fits.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {{width: number, height: number, span: {first: number, last: number}, frames: number}} view
 * @param {import('./palette.js').Palette} palette
 * @param {(frame: number) => number} seconds   time of a frame, s
 */
export function paintAxis(ctx, view, palette, seconds) {
  const { width, height, span, frames } = view;
  const { unit, colour } = palette;
  const step = tickStep((span.last - span.first) / width, 112 * unit);
  ctx.font = palette.smallFont;
  ctx.textBaseline = 'middle';
  ctx.strokeStyle = colour.lineStrong;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (let frame = Math.ceil(span.first / step) * step; frame < Math.min(span.last, frames); frame += step) {
    const x = Math.round(toX(span, frame, width)) + 0.5;
    ctx.moveTo(x, 0);
    ctx.lineTo(x, height);
    const minor = step >= 10 ? step / 5 : step;
    for (let m = frame + minor; m < frame + step && minor < step; m += minor) {
      const at = Math.round(toX(span, m, width)) + 0.5;
      ctx.moveTo(at, height - 4 * unit);
      ctx.lineTo(at, height);
    }
    const label = timeLabel(seconds(frame), Math.abs(seconds(Math.min(frame + step, frames - 1)) - seconds(frame)));
    ctx.fillStyle = colour.text2;
    ctx.fillText(label, x + 4 * unit, height / 2);
    const used = ctx.measureText(label).width;
    ctx.fillStyle = colour.text3;
    ctx.fillText(`· ${frame}`, x + used + 8 * unit, height / 2);
  }
  ctx.stroke();
}

/**
 * The number of tracks over the whole drive, shaded by the uncertainty of undecided ones.
 *
 * @param {CanvasRenderingContext2D} ctx
 * @param {{width: number, height: number, frames: number}} view
 * @param {import('../../model/lanes_lod.js').Density} density
 * @param {import('./palette.js').Palette} palette
 */
export function paintOverview(ctx, view, density, palette) {
  const { width, height, frames } = view;
  const level = levelFor(density, frames / width);
  const tracks = density.tracks[level];
  const uncertainty = density.uncertainty[level];
  const bucket = density.bucket * 2 ** level;
  const step = (bucket / frames) * width;
  const band = Math.max(2, Math.round(4 * palette.unit));
  const tall = height - band - 1;
  ctx.fillStyle = palette.colour.heat;
  for (let b = 0; b < tracks.length; b += 1) {
    const part = density.maxTracks > 0 ? tracks[b] / density.maxTracks : 0;
    ctx.globalAlpha = 0.75;
    ctx.fillRect(b * step, tall * (1 - part), Math.max(1, step), tall * part);
  }
  ctx.fillStyle = palette.colour.warn;
  for (let b = 0; b < uncertainty.length; b += 1) {
    if (uncertainty[b] <= 0.05) continue;
    ctx.globalAlpha = uncertainty[b] ** 1.5;
    ctx.fillRect(b * step, height - band, Math.max(1, step), band);
  }
  ctx.globalAlpha = 1;
}
