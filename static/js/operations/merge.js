// @ts-check
/** Merging tracks. If they have boxes in the same frames, the user decides which boxes stay. */

import { docOf } from '../editing/revisions.js';
import { labelOf } from '../model/effective.js';
import { engineGaps } from '../model/engine_gaps.js';
import { subtractSpans } from '../model/join.js';
import { intersectSpans, countFrames } from '../model/shown_spans.js';
import { trackEntries } from '../model/track_entries.js';
import { trackName } from '../model/track_name.js';
import { engineClass } from '../review/shown_tracks.js';
import { openDialog } from '../store/actions/page.js';
import { select, setMode } from '../store/actions/review.js';
import { plural } from '../model/format.js';
import { toast } from '../core/toast.js';

/**
 * @typedef {import('../page-types.js').App} App
 * @typedef {import('../state-types.js').ReviewState} ReviewState
 * @typedef {import('../model/join.js').Span} Span
 */

/**
 * The frames in which tracks of a merge have more than one box; tracks of one sign have none. A track is compared with
 * all tracks before it, not only with the first.
 *
 * @param {ReviewState} review
 * @param {string} key
 * @param {readonly string[]} others   tracks that become part of it, in this order
 * @returns {{key: string, stays: string[], runs: Span[]}[]} for each track that shares frames: the tracks whose boxes stay there, and the frames
 */
export function sharedFrames(review, key, others) {
  const runsOf = new Map(trackEntries(review.tracks, review.docs).map((entry) => [entry.key, entry.spans]));
  const found = [];
  const joined = [key];
  /** Frames that have a box so far. @type {Span[]} */
  let covered = [...(runsOf.get(key) ?? [])];
  for (const other of others) {
    const otherRuns = [...(runsOf.get(other) ?? [])];
    const runs = intersectSpans(covered, otherRuns);
    if (runs.length > 0)
      found.push({ key: other, stays: joined.filter((one) => intersectSpans(runsOf.get(one) ?? [], otherRuns).length > 0), runs });
    covered = [...covered, ...subtractSpans(otherRuns, covered)];
    joined.push(other);
  }
  return found;
}

/**
 * The decision that a merge needs, in words.
 * @param {ReviewState} review
 * @param {ReturnType<typeof sharedFrames>[number]} shared
 */
export function describeSharedFrames(review, { key, stays, runs }) {
  const names = stays.map((one) => trackName(one, review.docs[one]));
  return (
    `Tracks ${names.join(', ')} and ${trackName(key, review.docs[key])} have boxes in ${plural(countFrames(runs), 'common frame')} (${runs[0][0]}–${/** @type {Span} */ (runs.at(-1))[1]}). One frame of a track has one box: ` +
    `the box of ${names.length > 1 ? 'the track marked first' : names[0]} stays, and the box of ${trackName(key, review.docs[key])} is removed.`
  );
}

/**
 * Merge tracks, and select the result.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {string} key
 * @param {readonly string[]} others
 * @returns {boolean} whether the merge was made
 */
export function mergeTracks(app, key, others) {
  const { review } = app.store.get();
  if (!review) return false;
  const doc = review.docs[key];
  const class_id = doc ? labelOf(doc, (track) => engineClass(review, track)) : null;
  const merged = [key, ...others].flatMap((each) => docOf(review, each) ?? []);
  const gaps = engineGaps(review.lanes, new Set(merged.flatMap(({ segments }) => segments.map(({ track }) => track))));
  if (!app.edit({ name: 'merge', frame: review.frame, key, others: [...others], class_id, gaps })) return false;
  app.store.dispatch((state) => select(setMode(state, 'select'), key));
  return true;
}

/**
 * The merge key: start to mark tracks, or merge the marked ones. If they share frames, a dialog asks first.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {(text: string) => void} [notify]
 */
export function merge(app, notify = toast) {
  const { review } = app.store.get();
  if (!review) return;
  if (review.mode !== 'merge') {
    app.store.dispatch(setMode, 'merge');
    return;
  }
  const [key, ...others] = review.marked;
  if (key && others.length) {
    if (sharedFrames(review, key, others).length > 0) app.store.dispatch(openDialog, { kind: 'merge', data: { marked: review.marked } });
    else if (!mergeTracks(app, key, others)) app.store.dispatch((state) => select(setMode(state, 'select'), key));
  } else if (key) {
    notify('Mark a second track first: click it in the picture, in the lanes or in the queue. Escape leaves the merge.');
  } else {
    app.store.dispatch(setMode, 'select');
  }
}
