// @ts-check
/**
 * The frame that shows a track best: a sign is recognised by its largest boxes, and a track begins with its smallest.
 * Pure.
 */

import { keyFramesOf } from './documents.js';
import { lastFrameIn, shownSpan } from './effective.js';
import { area } from './geometry.js';
import { shownSpans } from './shown_spans.js';

/**
 * A box counts as cut by the picture if its edge is closer to the picture's edge than this share of its side; as in
 * app/evidence/tracks.py.
 */
const EDGE_MARGIN_SHARE = 0.05;

/**
 * The frame in which the engine saw the sign best, or the nearest frame that is still part of the track. For a track
 * that a person drew: the key frame with the largest box that the picture does not cut.
 *
 * @param {import('../types.js').TrackDoc} doc
 * @param {import('../types.js').TrackColumns|null} tracks
 * @param {import('./geometry.js').Size} [picture]   unset: no box counts as cut
 * @returns {number|null} null: the track shows nothing
 */
export function clearestFrame(doc, tracks, picture = { width: Infinity, height: Infinity }) {
  const span = shownSpan(doc, tracks);
  if (span === null) return null;
  const views = tracks === null ? [] : engineViews(doc, tracks);
  const engineBest = maxBy(
    views.filter(({ distance }) => distance === 0),
    ({ side }) => side,
  );
  if (engineBest) return engineBest.frame;
  const drawn = keyFramesOf(doc).filter((frame) => doc.keys[frame].box !== null && !doc.keys[frame].outside);
  const largest = maxBy(drawn, (frame) => rankOf(/** @type {import('../types.js').Box} */ (doc.keys[frame].box), picture));
  return largest ?? maxBy(views, ({ distance }) => -distance)?.frame ?? span.first;
}

/**
 * For each range of engine boxes in the track, its frame nearest to the engine's best view of the sign.
 * @param {import('../types.js').TrackDoc} doc
 * @param {import('../types.js').TrackColumns} tracks
 */
function engineViews(doc, tracks) {
  const runs = shownSpans(doc, lastFrameIn(tracks));
  return doc.segments.flatMap(({ track, first, last }) => {
    const at = tracks.id.indexOf(track);
    const clearest = tracks.clearest[at];
    if (at < 0) return [];
    return runs
      .filter(([from, to]) => from <= last && first <= to)
      .map(([from, to]) => {
        const frame = Math.min(Math.max(clearest, first, from), last, to);
        return { frame, distance: Math.abs(clearest - frame), side: tracks.side[at] };
      });
  });
}

/** Whole boxes before cut ones, then by size. @param {import('../types.js').Box} box @param {import('./geometry.js').Size} picture */
function rankOf(box, { width, height }) {
  const [x1, y1, x2, y2] = box;
  const [marginX, marginY] = [EDGE_MARGIN_SHARE * (x2 - x1), EDGE_MARGIN_SHARE * (y2 - y1)];
  const isUncut = x1 > marginX && y1 > marginY && x2 < width - marginX && y2 < height - marginY;
  return (isUncut ? 1e9 : 0) + area(box);
}

/**
 * The first item with the highest rank.
 * @template T
 * @param {readonly T[]} list
 * @param {(one: T) => number} rank
 * @returns {T|undefined}
 */
function maxBy(list, rank) {
  return list.reduce((/** @type {T|undefined} */ found, one) => (found === undefined || rank(one) > rank(found) ? one : found), undefined);
}
