// @ts-check
/** Why the selected track shows nothing in a frame, and what can be done about it. Pure. */
import { trackName } from './track_name.js';

/**
 * @param {string} key
 * @param {import('../types.js').TrackDoc|undefined} doc   its document, where people have said something of it
 * @returns {string} for the line below the picture
 */
export function whyNoBox(key, doc) {
  if (doc?.merged_into) return `Track ${trackName(key, doc)} is part of ${trackName(doc.merged_into)} by now: it was merged.`;
  if (doc?.gone) return `Track ${trackName(key, doc)} is deleted. The list of deleted tracks above the queue restores it.`;
  return 'The selected track has no box in this frame. K carries its nearest one here.';
}
