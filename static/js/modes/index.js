// @ts-check
/**
 * What the pointer does in the picture: selects and changes boxes, draws a new one, or marks tracks for a merge. One mode
 * holds at a time; `changed` leads from one to the next. Pure.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 *
 * @typedef {object} Mode
 * @property {(review: ReviewState) => Partial<ReviewState>} enter   what changes as it begins
 * @property {(review: ReviewState) => Partial<ReviewState>} exit    what is left behind as it ends
 * @property {boolean} changesBoxes                                  the selected box has handles, and boxes have a menu
 * @property {string|null} cursor                                    everywhere in the picture; null: that of what lies under the pointer
 * @property {((review: ReviewState, key: string) => Partial<ReviewState>)|null} take   what a click on a track does; null: it selects
 * @property {(review: ReviewState, absent: boolean) => string} hint   one line over the picture; absent: the selected track has no box here
 */
import { draw } from './draw.js';
import { merge } from './merge.js';
import { select } from './select.js';

/** @type {Record<ReviewState['mode'], Mode>} */
export const MODES = { select, draw, merge };

/** The mode that holds. @param {ReviewState} review */
export const modeOf = (review) => MODES[review.mode];

/**
 * What changes with the mode: the old one ends, the new one begins. A box in the hand is let go.
 * @param {ReviewState} review
 * @param {ReviewState['mode']} mode
 * @returns {Partial<ReviewState>}
 */
export const changed = (review, mode) => ({ drag: null, ...modeOf(review).exit(review), ...MODES[mode].enter(review), mode });
