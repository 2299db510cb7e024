// @ts-check
/**
 * Documents for commands: those that people have made, fresh ones for the engine's tracks that nobody touched. Pure.
 *
 * @typedef {import('../types.js').ReviewState} ReviewState
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */
import { touchedKeys } from '../model/commands.js';
import { OPEN_END, emptyDoc } from '../model/documents.js';

/**
 * The document of a track, also of one that has none yet; null: there is no such track.
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

/**
 * Tracks of which people have said what should have come out: accepted, rejected or corrected; notes alone say nothing.
 * @param {ReviewState} review
 * @returns {string[]}
 */
export function correctedKeys(review) {
  return Object.values(review.docs).filter((doc) => isCorrected(doc, docOf({ ...review, docs: {} }, doc.key))).map((doc) => doc.key);
}

/**
 * @param {TrackDoc} doc
 * @param {TrackDoc|null} fresh   as the engine has it; null: a person's own track
 * @returns {boolean}
 */
function isCorrected(doc, fresh) {
  if (doc.gone) return doc.merged_into === null && fresh !== null;
  const judged = doc.not_a_sign || doc.class_id !== null || doc.review === 'accepted' || doc.review === 'rejected';
  return judged || Object.keys(doc.keys).length > 0 || !sameSegments(doc.segments, fresh?.segments ?? []);
}

/**
 * @param {TrackDoc['segments']} a
 * @param {TrackDoc['segments']} b   of the engine's track, which may have grown since
 * @returns {boolean}
 */
function sameSegments(a, b) {
  return a.length === b.length && a.every((piece, i) => piece.track === b[i].track && piece.first === b[i].first && (piece.last === b[i].last || piece.last >= OPEN_END));
}

/**
 * Documents of all tracks that a command touches.
 * @param {ReviewState} review
 * @param {import('../types.js').Command} command
 * @returns {Record<string, TrackDoc>}
 */
export function docsFor(review, command) {
  /** @type {Record<string, TrackDoc>} */
  const docs = {};
  for (const key of touchedKeys(command)) {
    const doc = docOf(review, key);
    if (doc) docs[key] = doc;
  }
  return docs;
}
