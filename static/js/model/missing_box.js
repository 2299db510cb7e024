// @ts-check
/** Why the selected track has no box in a frame, and what to do about it. Pure. */
import { trackName } from './track_name.js';

/**
 * @param {string} key
 * @param {import('../types.js').TrackDoc|undefined} doc   its document, if people have changed it
 * @returns {string} the text of the line below the picture
 */
export function whyNoBox(key, doc) {
  if (doc?.merged_into) return `Track ${trackName(key, doc)} is now part of ${trackName(doc.merged_into)}: it was merged.`;
  if (doc?.gone) return `Track ${trackName(key, doc)} is deleted. The list of deleted tracks above the queue restores it.`;
  return 'The selected track has no box in this frame. K copies its nearest box here.';
}
