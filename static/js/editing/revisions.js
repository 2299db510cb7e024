// @ts-check
/**
 * Documents for commands: those that people have made, and new ones for engine tracks that nobody has changed. Pure
 * functions.
 *
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { touchedKeys } from '../model/commands.js';
import { emptyDoc } from '../model/documents.js';

/**
 * The document of a track, new if it has none yet; null: there is no such track.
 * @param {ReviewState} review
 * @param {string} key
 * @returns {TrackDoc|null}
 */
export function docOf(review, key) {
  const doc = review.docs[key];
  if (doc) return doc;
  if (!key.startsWith('m') || review.tracks === null) return null;
  const id = Number(key.slice(1));
  const at = review.tracks.id.indexOf(id);
  if (at < 0) return null;
  return emptyDoc({ track: id, first: review.tracks.first[at], last: review.tracks.last[at] }, review.run?.state !== 'complete');
}

/** The document of the selected track; null: no track is selected. @param {ReviewState|null} review */
export const selectedDoc = (review) => (review?.selected ? docOf(review, review.selected) : null);

/**
 * Documents of all tracks that a command touches.
 * @param {ReviewState} review
 * @param {import('../types.js').Command} command
 * @returns {Record<string, TrackDoc>}
 */
export function docsFor(review, command) {
  const docs = touchedKeys(command).flatMap((key) => docOf(review, key) ?? []);
  return Object.fromEntries(docs.map((doc) => [doc.key, doc]));
}
