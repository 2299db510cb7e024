// @ts-check
/**
 * The frames in which two versions of a track differ. Pure.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{frame: number, saved: Box|null, mine: Box|null}} Difference   null: no box, or not loaded
 */
import { boxAt } from './effective.js';
import { clamp } from './geometry.js';

/** Maximum number of pictures to compare. */
export const MAX_DIFFERENCES = 3;
/** Edges that differ by less count as equal, px. */
const EQUAL_TOLERANCE_PX = 0.05;
/** Side of the shown region, as a multiple of the boxes' side. */
const REGION_SCALE = 2.5;
/** Minimum height of the region, px. */
const MIN_REGION_HEIGHT_PX = 60;
const ASPECT = 4 / 3;

/**
 * Frames in which one version has a key frame and the boxes differ, those nearest to a frame first.
 *
 * @param {TrackDoc|undefined} saved
 * @param {TrackDoc|undefined} mine
 * @param {(track: number, frame: number) => Box|null} engineBox   null also if it is not loaded
 * @param {number} near
 * @returns {Difference[]}   in frame order
 */
export function differences(saved, mine, engineBox, near) {
  const frames = new Set([saved, mine].flatMap((doc) => Object.keys(doc?.keys ?? {}).map(Number)));
  /** @param {TrackDoc|undefined} doc @param {number} frame */
  const at = (doc, frame) => (doc === undefined ? null : (boxAt(doc, frame, engineBox)?.box ?? null));
  return [...frames]
    .map((frame) => ({ frame, saved: at(saved, frame), mine: at(mine, frame) }))
    .filter((one) => !sameBox(one.saved, one.mine))
    .sort((a, b) => Math.abs(a.frame - near) - Math.abs(b.frame - near) || a.frame - b.frame)
    .slice(0, MAX_DIFFERENCES)
    .sort((a, b) => a.frame - b.frame);
}

/** @param {Box|null} a @param {Box|null} b */
function sameBox(a, b) {
  return a === b || (a !== null && b !== null && a.every((edge, at) => Math.abs(edge - b[at]) <= EQUAL_TOLERANCE_PX));
}

/**
 * The part of a picture around some boxes, inside the picture.
 *
 * @param {readonly Box[]} boxes   at least one
 * @param {number} width           width of the picture, px
 * @param {number} height
 * @returns {{x: number, y: number, width: number, height: number}}
 */
export function regionAround(boxes, width, height) {
  const [left, top] = [0, 1].map((edge) => Math.min(...boxes.map((box) => box[edge])));
  const [right, bottom] = [2, 3].map((edge) => Math.max(...boxes.map((box) => box[edge])));
  const tall = Math.min(
    height,
    width / ASPECT,
    Math.max(MIN_REGION_HEIGHT_PX, REGION_SCALE * Math.max(bottom - top, (right - left) / ASPECT)),
  );
  const wide = tall * ASPECT;
  const x = clamp((left + right - wide) / 2, 0, width - wide);
  return { x, y: clamp((top + bottom - tall) / 2, 0, height - tall), width: wide, height: tall };
}
