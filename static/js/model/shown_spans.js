// @ts-check
/**
 * The frames in which a track shows something, from its document alone. Pure.
 *
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {import('./join.js').Span} Span   first and last frame, both included
 */
import { OPEN_END, lastFrameOf } from './documents.js';
import { visibleSpans } from './join.js';

/** Documents are replaced and never modified, so an edit recomputes only the new ones. @type {WeakMap<TrackDoc, Span[]>} */
const cache = new WeakMap();

/**
 * Ranges of frames that are not marked as outside. In them the engine's track may lack single frames.
 *
 * @param {TrackDoc} doc
 * @param {(track: number) => number|null} [lastOf]   last frame so far, of an engine track that may still grow
 * @returns {readonly Span[]} disjoint, in order
 */
export function shownSpans(doc, lastOf) {
  if (doc.gone) return [];
  if (doc.segments.some(({ last }) => last >= OPEN_END)) {
    const segments = doc.segments.map((piece) => ({ ...piece, last: lastFrameOf(piece, lastOf) }));
    return visibleSpans({ ...doc, segments });
  }
  const found = cache.get(doc) ?? visibleSpans(doc);
  cache.set(doc, found);
  return found;
}

/** Number of frames of ranges between two frames, both included. @param {readonly Span[]} spans @param {number} [first] @param {number} [last] */
export const countFrames = (spans, first = 0, last = OPEN_END) =>
  spans.reduce((sum, [a, b]) => sum + Math.max(0, Math.min(b, last) - Math.max(a, first) + 1), 0);

/** The intersection of two lists of ranges. @param {readonly Span[]} spans @param {readonly Span[]} others @returns {Span[]} in the order of `others` */
export const intersectSpans = (spans, others) =>
  others.flatMap(([first, last]) =>
    spans.filter(([a, b]) => a <= last && first <= b).map(([a, b]) => /** @type {Span} */ ([Math.max(a, first), Math.min(b, last)])),
  );
