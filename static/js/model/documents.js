// @ts-check
/**
 * Documents of tracks: what people said, over the engine's boxes. The twin of app/edits/documents.py; pure.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').Segment} Segment
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */

/** Label of a sign that is none of the classes, as a person says; null is no word about it: the engine's stands. */
export const NO_CLASS = -1;

/** Last frame of a piece of an engine track that may still grow, because its run goes on. */
export const OPEN_END = 2 ** 31 - 2;

/**
 * The document of an engine track that nobody has touched.
 * @param {Segment} span   the track, its first and last frame
 * @param {boolean} [open] true: the run goes on, the track may grow
 * @returns {TrackDoc}
 */
export function emptyDoc(span, open = false) {
  const { track, first, last } = span;
  return { ...blankDoc(`m${track}`), segments: [{ track, first, last: open ? OPEN_END : last }] };
}

/**
 * A document without boxes.
 * @param {string} key
 * @returns {TrackDoc}
 */
export function blankDoc(key) {
  return {
    key,
    revision: 0,
    class_id: null,
    review: 'open',
    not_a_sign: false,
    segments: [],
    keys: {},
    notes: [],
    gone: false,
    merged_into: null,
  };
}

/**
 * The engine's track whose label stands where people give none; null: there is none.
 * @param {TrackDoc} doc
 * @returns {number|null}
 */
export function beganAs(doc) {
  return doc.key.startsWith('m') ? Number(doc.key.slice(1)) : (doc.segments[0]?.track ?? null);
}

/**
 * Key frames in order.
 * @param {TrackDoc} doc
 * @returns {number[]}
 */
export function keyFramesOf(doc) {
  return Object.keys(doc.keys)
    .map(Number)
    .sort((a, b) => a - b);
}

/**
 * The last key frame at or before a frame.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {number|null}
 */
export function lastKey(doc, frame) {
  return keyFramesOf(doc).filter((k) => k <= frame).at(-1) ?? null;
}

/**
 * The first key frame after a frame.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {number|null}
 */
export function nextKey(doc, frame) {
  return keyFramesOf(doc).find((k) => k > frame) ?? null;
}

/**
 * The last key frame before a frame.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {number|null}
 */
export function prevKey(doc, frame) {
  return keyFramesOf(doc).filter((k) => k < frame).at(-1) ?? null;
}

/**
 * The box that key frames alone give, their own or on the line between two; null: they give none.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {Box|null}
 */
export function lineAt(doc, frame) {
  const frames = keyFramesOf(doc);
  const before = frames.filter((k) => k <= frame).at(-1);
  if (before === undefined || doc.keys[before].outside) return null;
  const own = doc.keys[before].box;
  if (before === frame && own !== null) return own;
  if (!doc.keys[before].interpolate) return null;
  const start = frames.filter((k) => k <= frame && doc.keys[k].box !== null).at(-1);
  const end = frames.find((k) => k > frame && (doc.keys[k].box !== null || doc.keys[k].outside));
  if (start === undefined || end === undefined) return null;
  const a = doc.keys[start].box;
  const b = doc.keys[end].box;
  if (a === null || b === null) return null;
  const share = (frame - start) / (end - start);
  /** @param {0|1|2|3} i */
  const at = (i) => a[i] + share * (b[i] - a[i]);
  return [at(0), at(1), at(2), at(3)];
}

/**
 * Whether the track shows something at a frame or later; a piece of the engine's may lack single frames.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {boolean}
 */
export function showsFrom(doc, frame) {
  const starts = [frame, ...keyFramesOf(doc).filter((k) => k > frame)];
  return starts.some((start, i) => {
    const held = lastKey(doc, start);
    if (held !== null && doc.keys[held].outside) return false;
    const following = starts[i + 1] ?? Infinity;
    return lineAt(doc, start) !== null || doc.segments.some((s) => s.last >= start && s.first < following);
  });
}

/**
 * Whether nothing of the track is left in any frame.
 * @param {TrackDoc} doc
 * @returns {boolean}
 */
export function isEmpty(doc) {
  return doc.segments.length === 0 && !Object.values(doc.keys).some((key) => key.box !== null && !key.outside);
}

/**
 * The verdict on a track. Documents of older versions say by a mark of its own that it is no sign.
 * @param {TrackDoc} doc
 * @returns {TrackDoc['review']}
 */
export const verdictOf = (doc) => (doc.not_a_sign ? 'rejected' : doc.review);
