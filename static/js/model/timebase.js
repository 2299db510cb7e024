// @ts-check
/**
 * Ordinals and times: the frame on screen at a time, and the time of each frame. Built from the server's run-length
 * table, never from a frame rate.
 *
 * @typedef {import('../types.js').FrameTableData} FrameTableData
 */
import { upperBound } from './binary_search.js';

/**
 * @typedef {object} Timebase
 * @property {number} frames
 * @property {(frame: number) => number} secondsAt   presentation time of a frame relative to the first one, s
 * @property {(seconds: number) => number} frameAt   the frame on screen at a time: the last one shown at or before it
 * @property {(frame: number) => boolean} isCorrupt
 * @property {(frame: number) => number|null} nextKey
 * @property {(frame: number) => number|null} previousKey
 */

/** @param {FrameTableData} table @returns {Timebase} */
export function createTimebase(table) {
  const unit = table.time_base[0] / table.time_base[1];
  // one row per run of equal steps: its first frame, the ticks at that frame, ticks per frame
  /** @type {number[]} */
  const starts = [];
  /** @type {number[]} */
  const ticks = [];
  /** @type {number[]} */
  const strides = [];
  let frame = 0;
  let tick = 0;
  for (const [stride, count] of table.steps) {
    starts.push(frame);
    ticks.push(tick);
    strides.push(stride);
    frame += count;
    tick += stride * count;
  }
  const end = tick;
  const keys = Int32Array.from(table.keys);
  const corrupt = Int32Array.from(table.corrupt);

  return {
    frames: table.frames,
    secondsAt(frame) {
      if (starts.length === 0) return 0;
      const row = Math.max(0, upperBound(starts, frame) - 1);
      return (ticks[row] + (frame - starts[row]) * strides[row]) * unit;
    },
    frameAt(seconds) {
      const tick = seconds / unit + 1e-6;
      if (starts.length === 0 || tick <= 0) return 0;
      if (tick >= end) return table.frames - 1;
      const row = Math.max(0, upperBound(ticks, tick) - 1);
      return Math.min(table.frames - 1, starts[row] + Math.floor((tick - ticks[row]) / strides[row]));
    },
    isCorrupt: (frame) => corrupt[upperBound(corrupt, frame) - 1] === frame,
    nextKey: (frame) => keys[upperBound(keys, frame)] ?? null,
    previousKey: (frame) => keys[upperBound(keys, frame - 1) - 1] ?? null,
  };
}
