// @ts-check
/**
 * Documents of tracks: people's corrections on top of the engine's boxes. The twin of app/edits/documents.py; pure.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('../types.js').Attributes} Attributes
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').Segment} Segment
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 */

/**
 * Label of a sign that is none of the classes, given by a person. Null means that no person has given a label: the
 * engine's applies.
 */
export const NO_CLASS = -1;

/** Last frame of a part of an engine track that may still grow because its run is not finished. */
export const OPEN_END = 2 ** 31 - 2;

/**
 * The document of an engine track that nobody has changed.
 * @param {Segment} span   the track with its first and last frame
 * @param {boolean} [open] the run is not finished, so the track may grow
 * @returns {TrackDoc}
 */
export function emptyDoc(span, open = false) {
  const { track, first, last } = span;
  return { ...blankDoc(`m${track}`), segments: [{ track, first, last: open ? OPEN_END : last }] };
}

/** A document without boxes. @param {string} key @returns {TrackDoc} */
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
 * The last frame of a part of an engine track; of one that may still grow, the last so far.
 * @param {Segment} part
 * @param {(track: number) => number|null} [lastOf]   last frame so far of a track
 */
export const lastFrameOf = ({ track, first, last }, lastOf) => (last < OPEN_END ? last : Math.max(first, lastOf?.(track) ?? first));

/**
 * The engine's track whose label applies if people give none; null: none.
 * @param {TrackDoc} doc
 * @returns {number|null}
 */
export function originTrack(doc) {
  return doc.key.startsWith('m') ? Number(doc.key.slice(1)) : (doc.segments[0]?.track ?? null);
}

/** Key frames in order. @param {Pick<TrackDoc, 'keys'>} doc @returns {number[]} */
export function keyFramesOf(doc) {
  return Object.keys(doc.keys)
    .map(Number)
    .sort((a, b) => a - b);
}

/**
 * The last key frame at or before a frame.
 * @param {Pick<TrackDoc, 'keys'>} doc
 * @param {number} frame
 * @returns {number|null}
 */
export const lastKey = (doc, frame) => keyFramesOf(doc).findLast((k) => k <= frame) ?? null;

/**
 * The content of the last key frame at or before a frame.
 * @param {Pick<TrackDoc, 'keys'>} doc
 * @param {number} frame
 * @returns {KeyFrame|undefined}
 */
export const keyAt = (doc, frame) => doc.keys[lastKey(doc, frame) ?? -1];

/**
 * A key frame without a label of its own.
 * @param {ReturnType<typeof stateOf>} state
 * @param {Box|null} [box]
 * @returns {KeyFrame}
 */
export const newKeyFrame = (state, box = null) => ({ box, ...state, class_id: null, followed: false });

/**
 * The box from key frames alone: a key frame's own, or interpolated between two; null: none.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {Box|null}
 */
export function keyFrameBoxAt(doc, frame) {
  const frames = keyFramesOf(doc);
  const before = frames.findLast((k) => k <= frame);
  if (before === undefined || doc.keys[before].outside) return null;
  const box = doc.keys[before].box;
  if (before === frame && box !== null) return box;
  if (!doc.keys[before].interpolate) return null;
  const start = frames.findLast((k) => k <= frame && doc.keys[k].box !== null);
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
 * The boxes that a track needs if it is cut before a frame, by frame: where a line ends and begins then. They lie apart
 * from the cut if key frames without a box interrupt the line.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {[number, Box][]}
 */
export function lineEnds(doc, frame) {
  const frames = keyFramesOf(doc);
  /** @param {number[]} keys */
  const upToBox = (keys) => {
    const at = keys.findIndex((k) => doc.keys[k].box !== null);
    return at < 0 ? keys : keys.slice(0, at);
  };
  const earlier = upToBox(frames.filter((k) => k < frame).reverse());
  const later = upToBox(frames.filter((k) => k >= frame));
  return [
    [frame, ...later],
    [frame - 1, ...earlier.map((k) => k - 1)],
  ].flatMap((places) => {
    const place = places.find((f) => keyFrameBoxAt(doc, f) !== null);
    return place === undefined ? [] : [/** @type {[number, Box]} */ ([place, keyFrameBoxAt(doc, place)])];
  });
}

/**
 * The state that holds from a key frame up to the next one, without fields at their defaults.
 * @param {KeyFrame} [key]   unset: the state before the first key frame
 */
export function stateOf(key) {
  const { occluded = false, outside = false, interpolate = false, attributes = {} } = key ?? {};
  return { occluded, outside, interpolate, ...nonDefaultFields({ attributes }) };
}

/** @param {ReturnType<typeof stateOf>} a @param {ReturnType<typeof stateOf>} b */
export function sameState(a, b) {
  const same = a.occluded === b.occluded && a.outside === b.outside && a.interpolate === b.interpolate;
  return same && sameAttributes(a.attributes, b.attributes);
}

/** @param {Attributes} [a] @param {Attributes} [b] */
export function sameAttributes(a = {}, b = {}) {
  const names = Object.keys(a);
  return names.length === Object.keys(b).length && names.every((name) => Object.hasOwn(b, name) && a[name] === b[name]);
}

/**
 * Fields to merge into a document or a key frame. Fields at their defaults are absent, as in the server's data.
 * @param {{attributes?: Attributes, ignore?: boolean}} fields
 * @returns {{attributes?: Attributes, ignore?: boolean}}
 */
export function nonDefaultFields({ attributes = {}, ignore = false }) {
  return { ...(Object.keys(attributes).length ? { attributes } : {}), ...(ignore ? { ignore } : {}) };
}

/**
 * The same document or key frame with other attributes.
 * @template {{attributes?: Attributes}} T
 * @param {T} item
 * @param {Attributes} attributes
 * @returns {T}
 */
export function withAttributes(item, attributes) {
  const { attributes: _before, ...others } = item;
  return /** @type {T} */ ({ ...others, ...nonDefaultFields({ attributes }) });
}

/** The attributes of a track in a frame. @param {TrackDoc} doc @param {number} frame @returns {Attributes} */
export const attributesAt = (doc, frame) => ({ ...doc.attributes, ...keyAt(doc, frame)?.attributes });

/**
 * The document with a key frame: the existing one, else the state that holds there, with changes.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @param {Partial<KeyFrame>} changes
 * @returns {TrackDoc}
 */
export function withKey(doc, frame, changes) {
  let present = doc.keys[frame];
  if (!present) {
    const before = keyAt(doc, frame);
    const state = stateOf(before);
    present = newKeyFrame(before ? state : { ...state, interpolate: doc.segments.length === 0 });
  }
  return { ...doc, keys: { ...doc.keys, [frame]: { ...present, ...changes } } };
}

/**
 * Whether the track shows something at a frame or later. A part from the engine may lack single frames.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @returns {boolean}
 */
export function showsFrom(doc, frame) {
  const starts = [frame, ...keyFramesOf(doc).filter((k) => k > frame)];
  return starts.some((start, i) => {
    if (keyAt(doc, start)?.outside) return false;
    const following = starts[i + 1] ?? Infinity;
    return keyFrameBoxAt(doc, start) !== null || doc.segments.some((s) => s.last >= start && s.first < following);
  });
}

/** Whether the track has nothing in any frame. @param {TrackDoc} doc @returns {boolean} */
export function isEmpty(doc) {
  return doc.segments.length === 0 && !Object.values(doc.keys).some((key) => key.box !== null && !key.outside);
}

/**
 * The verdict on a track. Documents of older versions have a separate mark for "not a sign".
 * @param {TrackDoc} doc
 * @returns {TrackDoc['review']}
 */
export const verdictOf = (doc) => (doc.not_a_sign ? 'rejected' : doc.review);

/** @param {TrackDoc} doc @param {number} first @param {number} last @returns {Record<string, KeyFrame>} */
export function keysWithin(doc, first, last) {
  return Object.fromEntries(Object.entries(doc.keys).filter(([k]) => first <= Number(k) && Number(k) <= last));
}

/**
 * The parts of segments within `first` to `last`, both included.
 * @param {Segment[]} segments
 * @param {number} first
 * @param {number} last
 * @returns {Segment[]}
 */
export function clipSegments(segments, first, last) {
  return segments
    .map((s) => ({ track: s.track, first: Math.max(s.first, first), last: Math.min(s.last, last) }))
    .filter((s) => s.first <= s.last);
}
