// @ts-check
/**
 * The content of a track in a frame: its document on top of the engine's boxes. The twin of app/edits/effective.py; pure.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('../types.js').TrackDoc} TrackDoc
 * @typedef {{box: Box, origin: 'engine'|'corrected'|'interpolated', occluded: boolean, class_id: number|null}} EffectiveBox
 */
import { keyAt, originTrack, keyFramesOf, keyFrameBoxAt, lastFrameOf } from './documents.js';

/**
 * The box of a track in a frame, with its origin and its label; null: the track shows nothing there.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @param {(track: number, frame: number) => Box|null} engineBox   the engine's box
 * @param {(track: number) => number|null} [engineClass]           the engine's fused class
 * @returns {EffectiveBox|null}   `class_id` `NO_CLASS`: given by a person; null: neither a person nor `engineClass` gives one
 */
export function boxAt(doc, frame, engineBox, engineClass) {
  if (doc.gone) return null;
  const state = keyAt(doc, frame);
  if (state?.outside) return null;
  const occluded = state?.occluded ?? false;
  const class_id = labelAt(doc, frame, engineClass);
  const line = keyFrameBoxAt(doc, frame);
  if (line !== null) {
    return { box: line, origin: doc.keys[frame]?.box ? 'corrected' : 'interpolated', occluded, class_id };
  }
  const segment = doc.segments.find((s) => s.first <= frame && frame <= s.last);
  const box = segment ? engineBox(segment.track, frame) : null;
  return box === null ? null : { box, origin: 'engine', occluded, class_id };
}

/**
 * The label of a track in a frame.
 * @param {TrackDoc} doc
 * @param {number} frame
 * @param {(track: number) => number|null} [engineClass]
 * @returns {number|null}
 */
export const labelAt = (doc, frame, engineClass) => doc.keys[frame]?.class_id ?? labelOf(doc, engineClass);

/**
 * The label of a whole track: a person's, else the label of the engine's track that it began as.
 * @param {TrackDoc} doc
 * @param {(track: number) => number|null} [engineClass]
 * @returns {number|null}
 */
export function labelOf(doc, engineClass) {
  if (doc.class_id !== null) return doc.class_id;
  const track = originTrack(doc);
  return track === null ? null : (engineClass?.(track) ?? null);
}

/**
 * A function from engine tracks to their last frames so far; null: not known.
 * @param {import('../types.js').TrackColumns|null} [tracks]   of the run
 */
export const lastFrameIn = (tracks) => (/** @type {number} */ track) => tracks?.last[tracks.id.indexOf(track)] ?? null;

/**
 * First and last frame in which a track can show something; null: none.
 * @param {TrackDoc} doc
 * @param {(track: number) => number|null} [lastOf]   last frame so far, of an engine track that may still grow
 * @returns {{first: number, last: number}|null}
 */
export function spanOf(doc, lastOf) {
  if (doc.gone) return null;
  let first = Infinity;
  let last = -Infinity;
  for (const segment of doc.segments) {
    first = Math.min(first, segment.first);
    last = Math.max(last, lastFrameOf(segment, lastOf));
  }
  for (const frame of keyFramesOf(doc)) {
    const { box, outside } = doc.keys[frame];
    if (box === null || outside) continue;
    first = Math.min(first, frame);
    last = Math.max(last, frame);
  }
  return first <= last ? { first, last } : null;
}

/**
 * The same, up to the run's current frame.
 * @param {TrackDoc} doc
 * @param {import('../types.js').TrackColumns|null} [tracks]   of the run
 */
export const shownSpan = (doc, tracks) => spanOf(doc, lastFrameIn(tracks));

/**
 * The track to show after a change that touched several, at its frame: after a split the later half.
 * @param {readonly TrackDoc[]} docs
 * @param {number|null} frame   null: the change is about whole tracks
 * @returns {TrackDoc|null}   null: none of them exists any more
 */
export function subjectOf(docs, frame) {
  const existing = docs.filter((doc) => !doc.gone);
  const atFrame =
    frame === null
      ? undefined
      : existing.find((doc) => {
          const span = spanOf(doc);
          return span !== null && span.first <= frame && frame <= span.last;
        });
  return atFrame ?? existing[0] ?? null;
}
