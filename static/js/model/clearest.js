// @ts-check
/** Where a track is best looked at: a sign is recognised by its largest boxes, and a track begins with its smallest. Pure. */

import { keyFramesOf, lastKey } from './documents.js';
import { shownSpan } from './effective.js';
import { area } from './geometry.js';

/**
 * The last frame in which the engine detected the track, within the stretches that are still its own; of a track that a
 * person drew the key frame with the largest box.
 *
 * @param {import('../types.js').TrackDoc} doc
 * @param {import('../types.js').TrackColumns|null} tracks
 * @returns {number|null} null: the track shows nothing
 */
export function clearestFrame(doc, tracks) {
  const placeOf = (/** @type {number} */ id) => tracks?.id.indexOf(id) ?? -1;
  const span = shownSpan(doc, tracks);
  if (span === null) return null;
  const detected = doc.segments
    .map(({ track, first, last }) => ({ frame: tracks?.clearest[placeOf(track)] ?? -1, first, last }))
    .filter(({ frame, first, last }) => first <= frame && frame <= last && !isOutside(doc, frame))
    .map(({ frame }) => frame);
  if (detected.length > 0) return Math.max(...detected);
  const drawn = keyFramesOf(doc).filter((frame) => doc.keys[frame].box !== null && !doc.keys[frame].outside);
  return drawn.reduce((/** @type {number|null} */ best, frame) => (best === null || sideOf(doc, frame) > sideOf(doc, best) ? frame : best), null) ?? span.first;
}

/** @param {import('../types.js').TrackDoc} doc @param {number} frame */
function isOutside(doc, frame) {
  const before = lastKey(doc, frame);
  return before !== null && doc.keys[before].outside;
}

/** @param {import('../types.js').TrackDoc} doc @param {number} frame */
function sideOf(doc, frame) {
  const { box } = doc.keys[frame];
  return box === null ? 0 : area(box);
}
