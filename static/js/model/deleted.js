// @ts-check
/**
 * Deleted tracks that can be restored. Pure.
 *
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{seq: number, author: string, time: string, keys: readonly string[]}} LogRow
 * @typedef {{author: string, time: string}} LastEdit
 */
import { isEmpty } from './documents.js';
import { spanOf } from './effective.js';

/**
 * Deleted tracks, by first frame. Not merged tracks, which are part of another one, and not tracks whose creation was
 * undone.
 *
 * @param {Record<string, TrackDoc>} docs
 * @param {(track: number) => number|null} [lastOf]   last frame so far, of an engine track that may still grow
 * @returns {{doc: TrackDoc, first: number, last: number}[]}   both frames included
 */
export function deletedTracks(docs, lastOf) {
  return Object.values(docs)
    .flatMap((doc) => {
      if (!doc.gone || doc.merged_into !== null || isEmpty(doc)) return [];
      const span = spanOf({ ...doc, gone: false }, lastOf);
      return span ? [{ doc, ...span }] : [];
    })
    .sort((a, b) => a.first - b.first || (a.doc.key < b.doc.key ? -1 : 1));
}

/**
 * The author of the last edit of each track. For a deleted track, the person who deleted it.
 *
 * @param {ReadonlyMap<string, LastEdit>} before
 * @param {readonly LogRow[]} rows   of the log, after the rows in `before`
 * @returns {Map<string, LastEdit>}
 */
export function lastEdits(before, rows) {
  const found = new Map(before);
  for (const { keys, author, time } of rows) for (const key of keys) found.set(key, { author, time });
  return found;
}

/**
 * The engine's track behind a deleted one, and a frame in the middle of its part; null: the track was drawn by hand.
 *
 * @param {TrackDoc} doc
 * @param {number} last   last frame of the track
 * @returns {{track: number, frame: number}|null}
 */
export function exampleFrame({ segments }, last) {
  const [piece] = segments;
  return piece ? { track: piece.track, frame: Math.floor((piece.first + Math.max(piece.first, Math.min(piece.last, last))) / 2) } : null;
}
