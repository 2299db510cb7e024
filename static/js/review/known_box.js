// @ts-check
/** The box of a track in any frame. It comes from the track's lane, so the frame's overlay is not needed. Pure. */

import { docOf } from '../editing/revisions.js';
import { boxAt } from '../model/effective.js';

/**
 * @param {import('../state-types.js').ReviewState} review
 * @param {string} key
 * @param {number} frame
 * @returns {import('../types.js').Box|null} null: the track shows nothing there, or its lane is not loaded yet
 */
export function knownBox(review, key, frame) {
  const doc = docOf(review, key);
  if (!doc) return null;
  return (
    boxAt(doc, frame, (track, at) => {
      const lane = review.laneOf[track];
      const index = lane ? lane.frame.indexOf(at) : -1;
      return index < 0 ? (review.overlays[at]?.tracks.find(({ id }) => id === track)?.box ?? null) : lane.box[index];
    })?.box ?? null
  );
}
