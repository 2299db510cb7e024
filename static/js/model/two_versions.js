// @ts-check
/**
 * Where two versions of a track differ in the picture. Pure.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{frame: number, saved: Box|null, mine: Box|null}} Difference   null: nothing there, or not known here
 */
import { boxAt } from './effective.js';

/** Pictures that are worth looking at before one decides. */
export const MOST = 3;
/** An edge that moved by less is the same, px. */
const SAME = 0.05;
/** The part of the picture that is shown, in sides of what it is about. */
const AROUND = 2.5;
/** Height of the smallest part, px. */
const LEAST = 60;
const ASPECT = 4 / 3;

/**
 * Frames in which one of them has a key frame and their boxes differ, those nearest to a frame.
 *
 * @param {TrackDoc|undefined} saved
 * @param {TrackDoc|undefined} mine
 * @param {(track: number, frame: number) => Box|null} engineBox   null also where it is not loaded
 * @param {number} near
 * @returns {Difference[]}   in order
 */
export function differences(saved, mine, engineBox, near) {
  const frames = new Set([saved, mine].flatMap((doc) => Object.keys(doc?.keys ?? {}).map(Number)));
  /** @param {TrackDoc|undefined} doc @param {number} frame */
  const at = (doc, frame) => (doc === undefined ? null : (boxAt(doc, frame, engineBox)?.box ?? null));
  return [...frames]
    .map((frame) => ({ frame, saved: at(saved, frame), mine: at(mine, frame) }))
    .filter((one) => !sameBox(one.saved, one.mine))
    .sort((a, b) => Math.abs(a.frame - near) - Math.abs(b.frame - near) || a.frame - b.frame)
    .slice(0, MOST)
    .sort((a, b) => a.frame - b.frame);
}

/** @param {Box|null} a @param {Box|null} b */
function sameBox(a, b) {
  return a === b || (a !== null && b !== null && a.every((edge, at) => Math.abs(edge - b[at]) <= SAME));
}

/**
 * The part of a picture around some boxes, within it.
 *
 * @param {readonly Box[]} boxes   at least one
 * @param {number} width           of the picture, px
 * @param {number} height
 * @returns {{x: number, y: number, width: number, height: number}}
 */
export function partAround(boxes, width, height) {
  const [left, top] = [0, 1].map((edge) => Math.min(...boxes.map((box) => box[edge])));
  const [right, bottom] = [2, 3].map((edge) => Math.max(...boxes.map((box) => box[edge])));
  const tall = Math.min(height, width / ASPECT, Math.max(LEAST, AROUND * Math.max(bottom - top, (right - left) / ASPECT)));
  const wide = tall * ASPECT;
  /** @param {number} middle @param {number} side @param {number} whole */
  const begin = (middle, side, whole) => Math.max(0, Math.min(middle - side / 2, whole - side));
  return { x: begin((left + right) / 2, wide, width), y: begin((top + bottom) / 2, tall, height), width: wide, height: tall };
}
