// @ts-check
/** The current sign of the ground truth: the chosen one, else the one that overlaps the selected track. Pure. */

import { shownTracks } from './shown_tracks.js';
import { area, contains, iou } from '../model/geometry.js';

/**
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').Box} Box
 *
 * @typedef {object} ChosenTruth
 * @property {number} sign            its number in the ground truth
 * @property {Box|null} box           null: none in this frame
 * @property {number|null} class_id
 * @property {{key: string, iou: number}|null} on   the track with the largest overlap here; the selected track takes precedence
 */

/** The boxes of the ground truth in the cursor's frame, from left to right; none while the layer is hidden. @param {ReviewState} review */
const shownTruth = (review) => (review.layers.truth ? [...(review.truth[review.frame] ?? [])].sort((a, b) => a.box[0] - b.box[0]) : []);

/** @param {ReviewState} review @returns {ChosenTruth|null} null: none */
export function chosenTruth(review) {
  if (!review.layers.truth || review.truthId === null) return null;
  const tracks = shownTracks(review);
  const truthBoxes = shownTruth(review);
  if (review.truthSign !== null) {
    const chosen = truthBoxes.find(({ track }) => track === review.truthSign) ?? null;
    const overlap = chosen ? largestOverlap(tracks, chosen.box) : null;
    return {
      sign: review.truthSign,
      box: chosen?.box ?? null,
      class_id: chosen?.class_id ?? null,
      on: overlap && { key: overlap.item.key, iou: overlap.iou },
    };
  }
  const selected = tracks.find(({ key }) => key === review.selected);
  const found = selected ? largestOverlap(truthBoxes, selected.box) : null;
  return selected && found
    ? { sign: found.item.track, box: found.item.box, class_id: found.item.class_id, on: { key: selected.key, iou: found.iou } }
    : null;
}

/** The next sign of the ground truth in this frame, from left to right, then from the start; null: none. @param {ReviewState} review @returns {number|null} */
export function nextTruth(review) {
  const signs = shownTruth(review).map(({ track }) => track);
  return signs[(signs.indexOf(chosenTruth(review)?.sign ?? -1) + 1) % signs.length] ?? null;
}

/** The sign of the ground truth under a point of the picture, the smallest if there are several; null: none. @param {ReviewState} review @param {number} x @param {number} y @returns {number|null} */
export function truthAt(review, x, y) {
  const containing = shownTruth(review)
    .filter(({ box }) => contains(box, x, y))
    .sort((a, b) => area(a.box) - area(b.box));
  return containing[0]?.track ?? null;
}

/**
 * @template {{box: Box}} T
 * @param {readonly T[]} items
 * @param {Box} box
 * @returns {{item: T, iou: number}|null} the item with the largest overlap; null: none overlaps
 */
function largestOverlap(items, box) {
  const found = items.map((item) => ({ item, iou: iou(item.box, box) })).sort((a, b) => b.iou - a.iou)[0];
  return found && found.iou > 0 ? found : null;
}
