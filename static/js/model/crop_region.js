// @ts-check
/** The part of a picture that shows some boxes with their surroundings. Pure. */

import { clamp } from './geometry.js';

/** @typedef {import('../types.js').Box} Box */

/** Margin on each side, as a share of the boxes' size. */
const MARGIN_SHARE = 0.4;
/** Minimum side of the part, px: a smaller one is only blur. */
const MIN_SIDE_PX = 24;

/**
 * A square around boxes, moved into the picture and limited by its size.
 *
 * @param {readonly Box[]} boxes   at least one
 * @param {{width: number, height: number}} picture   px
 * @returns {Box} whole px
 */
export function cropRegion(boxes, { width, height }) {
  const [x1, y1] = [Math.min(...boxes.map((box) => box[0])), Math.min(...boxes.map((box) => box[1]))];
  const [x2, y2] = [Math.max(...boxes.map((box) => box[2])), Math.max(...boxes.map((box) => box[3]))];
  const side = Math.ceil(Math.min(width, height, Math.max(MIN_SIDE_PX, Math.max(x2 - x1, y2 - y1) * (1 + 2 * MARGIN_SHARE))));
  const left = clamp(Math.round((x1 + x2 - side) / 2), 0, width - side);
  const top = clamp(Math.round((y1 + y2 - side) / 2), 0, height - side);
  return [left, top, left + side, top + side];
}

/**
 * The place of a box in a part of the picture, for CSS.
 *
 * @param {Box} box
 * @param {Box} region
 * @returns {Record<'left'|'top'|'width'|'height', string>} shares of the region
 */
export function cssPosition(box, region) {
  const [width, height] = [region[2] - region[0], region[3] - region[1]];
  /** @param {number} part @param {number} total */
  const share = (part, total) => `${((100 * part) / total).toFixed(2)}%`;
  return {
    left: share(box[0] - region[0], width),
    top: share(box[1] - region[1], height),
    width: share(box[2] - box[0], width),
    height: share(box[3] - box[1], height),
  };
}
