// @ts-check
/**
 * Joins two tracks into one: each frame keeps its content. The twin of app/edits/join.py; pure.
 *
 * @typedef {import('../types.js').KeyFrame} KeyFrame
 * @typedef {import('../types.js').Segment} Segment
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {[number, number]} Span   first and last frame, both included
 */
import { OPEN_END, keyAt, keyFramesOf, keyFrameBoxAt, lastKey, newKeyFrame, sameState, stateOf, withAttributes } from './documents.js';

/**
 * `doc` with the frames of `other` that it does not have itself, that it marks as outside, or that lie in `gaps`.
 * Attributes of the whole tracks are merged; those of `doc` take precedence.
 * @param {TrackDoc} doc
 * @param {TrackDoc} other
 * @param {readonly Segment[]} [gaps]   frames in which the engine's tracks have no box
 * @returns {TrackDoc}
 */
export function join(doc, other, gaps = []) {
  doc = withLineEnds(doc);
  other = withLineEnds(other);
  const [visible, otherVisible] = [doc, other].map((each) => visibleSpans(withoutGaps(each, gaps)));
  doc = withoutSegments(doc, subtractSpans(otherVisible, visible));
  /** @type {Record<string, KeyFrame>} */
  const keys = { ...doc.keys };
  const pieces = [...doc.segments];
  for (const [first, last] of subtractSpans(documentSpans(other), documentSpans(doc))) {
    for (const s of other.segments) {
      if (s.first <= last && first <= s.last) {
        pieces.push({ track: s.track, first: Math.max(s.first, first), last: Math.min(s.last, last) });
      }
    }
    const stateBefore = stateAt(keys, first - 1);
    if (endInterpolation(keys, first - 1)) stateBefore.interpolate = false;
    const stateAfter = { ...stateAt(doc.keys, last + 1), interpolate: false };
    /** @type {Record<string, KeyFrame>} */
    const joinedKeys = {};
    for (const k of keyFramesOf(other)) if (first <= k && k <= last) joinedKeys[k] = other.keys[k];
    if (!(first in joinedKeys)) {
      const line = keyFrameBoxAt(other, first);
      const start = stateAt(other.keys, first);
      if (line !== null || !sameState(start, stateBefore)) joinedKeys[first] = newKeyFrame(start, line);
    }
    const edge = keyFrameBoxAt(other, last); // a cut line must end at its interpolated box
    if (edge !== null && !(last in joinedKeys)) joinedKeys[last] = newKeyFrame(stateAt(other.keys, last), edge);
    endInterpolation(joinedKeys, Infinity);
    for (const k of Object.keys(keys)) if (first <= Number(k) && Number(k) <= last) delete keys[k];
    Object.assign(keys, joinedKeys);
    const changed = !sameState(stateAt(keys, last + 1), stateAfter);
    if (!(last + 1 in keys) && last < OPEN_END && changed) keys[last + 1] = newKeyFrame(stateAfter);
  }
  const joined = {
    ...doc,
    segments: pieces.sort((a, b) => a.first - b.first || a.track - b.track),
    keys,
    notes: [...doc.notes, ...other.notes.filter((n) => doc.notes.every((note) => note.id !== n.id))],
  };
  return withAttributes(joined, { ...other.attributes, ...doc.attributes });
}

/**
 * End the interpolation at the last key frame with a box up to a frame, and at those after it. Changes `keys`.
 * @param {Record<string, KeyFrame>} keys
 * @param {number} frame
 * @returns {boolean} whether any of them was interpolated
 */
function endInterpolation(keys, frame) {
  let wasInterpolated = false;
  for (let k = lastKey({ keys }, frame); k !== null; k = lastKey({ keys }, k - 1)) {
    if (keys[k].interpolate) {
      keys[k] = { ...keys[k], interpolate: false };
      wasInterpolated = true;
    }
    if (keys[k].box !== null) break;
  }
  return wasInterpolated;
}

/**
 * The same track with a box at both ends of each interpolated line, so that a line can lose its neighbours. Key frames
 * before the first box are not interpolated: boxes of the other track may come before them.
 * @param {TrackDoc} doc
 * @returns {TrackDoc}
 */
function withLineEnds(doc) {
  const keys = { ...doc.keys };
  const frames = keyFramesOf(doc);
  for (const frame of frames) {
    if (doc.keys[frame].box !== null) break;
    keys[frame] = { ...keys[frame], interpolate: false };
  }
  frames.forEach((frame, position) => {
    const key = doc.keys[frame];
    const start = keyFrameBoxAt(doc, frame);
    if (key.box === null && start !== null) keys[frame] = { ...key, box: start };
    const nextFrame = frames[position + 1];
    if (nextFrame === undefined || nextFrame - 1 === frame || keyFrameBoxAt(doc, nextFrame) !== null) return;
    const end = keyFrameBoxAt(doc, nextFrame - 1);
    if (end !== null) keys[nextFrame - 1] = { ...key, box: end, class_id: null, followed: false };
  });
  return { ...doc, keys };
}

/** The state from the last key frame at or before a frame. @param {Record<string, KeyFrame>} keys @param {number} frame */
const stateAt = (keys, frame) => stateOf(keyAt({ keys }, frame));

/** The track without the parts of its segments in these frames. @param {TrackDoc} doc @param {Span[]} spans @returns {TrackDoc} */
function withoutSegments(doc, spans) {
  return { ...doc, segments: doc.segments.flatMap((segment) => partsOutside(segment, spans)) };
}

/**
 * The track without the parts of its segments in the gaps of their engine tracks.
 * @param {TrackDoc} doc
 * @param {readonly Segment[]} gaps
 * @returns {TrackDoc}
 */
function withoutGaps(doc, gaps) {
  /** @param {number} track @returns {Span[]} */
  const spansOf = (track) => gaps.filter((gap) => gap.track === track).map(({ first, last }) => [first, last]);
  return { ...doc, segments: doc.segments.flatMap((segment) => partsOutside(segment, spansOf(segment.track))) };
}

/** The parts of a segment outside of these frames. @param {Segment} segment @param {Span[]} spans @returns {Segment[]} */
function partsOutside({ track, first, last }, spans) {
  return subtractSpans([[first, last]], spans).map(([a, b]) => ({ track, first: a, last: b }));
}

/** The frames that a track has and that are not marked as outside. @param {TrackDoc} doc @returns {Span[]} */
export function visibleSpans(doc) {
  const frames = keyFramesOf(doc);
  /** @type {Span[]} */
  const outside = frames.flatMap((frame, i) => (doc.keys[frame].outside ? [[frame, (frames[i + 1] ?? OPEN_END + 1) - 1]] : []));
  return subtractSpans(documentSpans(doc), outside);
}

/** The frames that a track has, as disjoint spans in order. @param {TrackDoc} doc @returns {Span[]} */
function documentSpans(doc) {
  /** @type {Span[]} */
  const found = doc.segments.map((s) => [s.first, s.last]);
  const frames = keyFramesOf(doc);
  // the same as `keyFrameBoxAt` just before the next key frame, but in one pass from the end: tracks may have thousands of key
  // frames
  let begun = frames.findIndex((frame) => doc.keys[frame].box !== null);
  if (begun < 0) begun = Infinity;
  /** @type {KeyFrame|null} */
  let end = null;
  for (let i = frames.length - 1; i >= 0; i -= 1) {
    const key = doc.keys[frames[i]];
    if (!key.outside) {
      if (key.box !== null) found.push([frames[i], frames[i]]);
      if (key.interpolate && i >= begun && end?.box) found.push([frames[i], frames[i + 1] - 1]);
    }
    if (key.box !== null || key.outside) end = key;
  }
  /** @type {Span[]} */
  const joined = [];
  for (const [first, last] of found.sort((a, b) => a[0] - b[0] || a[1] - b[1])) {
    const top = joined.at(-1);
    if (top && first <= top[1] + 1) top[1] = Math.max(last, top[1]);
    else joined.push([first, last]);
  }
  return joined;
}

/** The parts of spans that no other span covers. @param {Span[]} parts @param {Span[]} others @returns {Span[]} */
export function subtractSpans(parts, others) {
  for (const [low, high] of others) {
    parts = parts.flatMap(([first, last]) => {
      /** @type {Span[]} */
      const sides = [
        [first, Math.min(last, low - 1)],
        [Math.max(first, high + 1), last],
      ];
      return sides.filter(([a, b]) => a <= b);
    });
  }
  return parts;
}
