// @ts-check
/**
 * Tracks that people have deleted and that can come back. Pure.
 *
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{seq: number, author: string, time: string, keys: readonly string[]}} LogRow
 * @typedef {{author: string, time: string}} Said
 */
import { isEmpty } from './documents.js';
import { spanOf } from './effective.js';

/**
 * Deleted tracks from the first frame on. Merged ones are part of another track, and of what an undo took back nothing is left.
 *
 * @param {Record<string, TrackDoc>} docs
 * @param {(track: number) => number|null} [lastOf]   last frame so far of an engine track that may still grow
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
 * Who said the last word on each track. Of a track that is gone that is who deleted it.
 *
 * @param {ReadonlyMap<string, Said>} before
 * @param {readonly LogRow[]} rows   of the log, later than those before
 * @returns {Map<string, Said>}
 */
export function lastWords(before, rows) {
  const found = new Map(before);
  for (const { keys, author, time } of rows) for (const key of keys) found.set(key, { author, time });
  return found;
}

/**
 * The engine's track and a frame in the middle of what it lends a deleted track; null: it was drawn by hand.
 *
 * @param {TrackDoc} doc
 * @param {number} last   last frame of the whole
 * @returns {{track: number, frame: number}|null}
 */
export function pictureOf({ segments }, last) {
  const [piece] = segments;
  return piece ? { track: piece.track, frame: Math.floor((piece.first + Math.max(piece.first, Math.min(piece.last, last))) / 2) } : null;
}
