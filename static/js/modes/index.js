// @ts-check
/**
 * The modes of the pointer in the picture: it selects and changes boxes, draws a new box, or marks tracks for a merge.
 * One mode is active at a time; `changed` switches modes. Pure.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 *
 * @typedef {object} Mode
 * @property {(review: ReviewState) => Partial<ReviewState>} enter   changes of the state when the mode begins
 * @property {(review: ReviewState) => Partial<ReviewState>} exit    changes of the state when the mode ends
 * @property {boolean} changesBoxes                                  whether the selected box has handles, and boxes have a menu
 * @property {string|null} cursor                                    cursor in the whole picture; null: depends on what is under the pointer
 * @property {((review: ReviewState, key: string) => Partial<ReviewState>)|null} onTrackClick   effect of a click on a track; null: it selects the track
 * @property {(review: ReviewState, hasNoBox: boolean) => string} hint   one line above the picture; absent: the selected track has no box in this frame
 */
import { draw } from './draw.js';
import { merge } from './merge.js';
import { select } from './select.js';

/** @type {Record<ReviewState['mode'], Mode>} */
export const MODES = { select, draw, merge };

/** The active mode. @param {ReviewState} review */
export const modeOf = (review) => MODES[review.mode];

/**
 * The changes of the state when the mode changes: the old mode ends and the new one begins. A box that is being dragged
 * is released.
 * @param {ReviewState} review
 * @param {ReviewState['mode']} mode
 * @returns {Partial<ReviewState>}
 */
export const modeChange = (review, mode) => ({ drag: null, ...modeOf(review).exit(review), ...MODES[mode].enter(review), mode });
