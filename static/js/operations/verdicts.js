// @ts-check
/** Judging tracks: accept, false positive, needs work, label, ignore, notes. */

import { verdictOf } from '../model/documents.js';
import { labelAt } from '../model/effective.js';
import { offeredLabels } from '../model/labels.js';
import { trackName } from '../model/track_name.js';
import { selectedDoc } from '../editing/revisions.js';
import { engineClass } from '../review/shown_tracks.js';
import { openDialog } from '../store/actions/page.js';
import { openVideos, reviewedMessage } from '../model/open_videos.js';
import { endOfQueue, nextInQueue, queueCounts, shownQueue } from '../model/queue.js';
import { trackEntries } from '../model/track_entries.js';
import { openTrack } from './navigate.js';
import { NEXT_VIDEO_KEY } from './next_video.js';
import { toast } from '../core/toast.js';
import { editSelected, needsRun, needsTrack, operation } from './helpers.js';

/** @typedef {import('../page-types.js').App} App */

const GROUP = 'Verdict';
const DIGITS = [1, 2, 3, 4, 5, 6, 7, 8, 9];

/**
 * Give a track a verdict, unless it already has it. Another verdict than "rejected" removes an older version's mark
 * "not a sign".
 * @param {{edit: (command: import('../types.js').Command) => boolean}} app
 * @param {import('../state-types.js').ReviewState} review
 * @param {string} key
 * @param {import('../types.js').TrackDoc['review']} verdict
 * @returns {boolean} whether the edit was made
 */
export function setVerdict(app, review, key, verdict) {
  const doc = review.docs[key];
  if (doc?.not_a_sign && verdict !== 'rejected' && !app.edit({ name: 'set_not_a_sign', key, frame: review.frame, value: false }))
    return false;
  return (doc?.review ?? 'open') === verdict || app.edit({ name: 'set_review', key, frame: review.frame, review: verdict });
}

/**
 * Give the selected track a label.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {import('../types.js').Label} label
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function setLabel(app, label, notify = toast) {
  const { review } = app.store.get();
  if (!review?.selected) return;
  const doc = selectedDoc(review);
  const name = `Track ${trackName(review.selected, review.docs[review.selected])}`;
  if (doc && doc.class_id === label.id && labelAt(doc, review.frame, (track) => engineClass(review, track)) === label.id)
    notify(`${name} is ${label.name} already.`, { topic: 'label' });
  else if (editSelected(app, { name: 'relabel_track', class_id: label.id })) notify(`${name}: ${label.name}`, { topic: 'label' });
}

/**
 * Give the selected track the label that is pinned to a digit.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {string} digit
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function setPinnedLabel(app, digit, notify = toast) {
  const label = offeredLabels(app.store.get().labels).find(({ pinned }) => String(pinned) === digit);
  if (label) setLabel(app, label, notify);
  else notify(`No label is pinned to ${digit}. Pin one on the Labels page.`, { topic: 'label' });
}

/**
 * Judge the selected track and go to the next undecided one. A verdict that the track already has stays: one key press
 * too many must not revert it.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {'accepted'|'rejected'|'needs_work'} review
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function judge(app, review, notify = toast) {
  const before = app.store.get();
  const key = before.review?.selected;
  if (!key) return;
  const doc = before.review?.docs[key];
  const present = doc ? verdictOf(doc) : 'open';
  const next = nextInQueue(before, 1);
  if (before.review && !setVerdict(app, before.review, key, review)) return;
  const after = app.store.get();
  const { left } = queueCounts(shownQueue(after));
  if (left === 0) notify(endMessage(after), { topic: 'queue' });
  else if (next !== null) openTrack(app, next);
  else if (present === review) notify(endOfQueue(before, 1), { topic: 'queue' });
}

/** @param {import('../state-types.js').State} state   without an undecided track under the filter */
function endMessage({ review, videos }) {
  const counts = queueCounts(review === null ? [] : trackEntries(review.tracks, review.docs));
  if (counts.left > 0) return 'Every track that the filter shows is decided.';
  const left = openVideos(videos, review?.video.id);
  return `${reviewedMessage(left, counts.total)}${left.next === null ? '' : ` ${NEXT_VIDEO_KEY} opens the next.`}`;
}

/** @type {import('../page-types.js').Operation[]} */
export const verdicts = [
  operation({
    id: 'accept',
    label: 'Accept the track and go to the next',
    short: 'Accept',
    keys: ['A'],
    icon: 'accept',
    group: GROUP,
    disabled: needsTrack,
    run: (app) => judge(app, 'accepted'),
  }),
  operation({
    id: 'reject',
    label: 'False positive, go to the next',
    short: 'False positive',
    keys: ['X'],
    tooltip: 'The track is not a sign: it is not counted, and training uses its boxes as background. Goes to the next (X)',
    icon: 'reject',
    group: GROUP,
    disabled: needsTrack,
    run: (app) => judge(app, 'rejected'),
  }),
  operation({
    id: 'needs-work',
    label: 'The track needs work, go to the next',
    short: 'Needs work',
    keys: ['W'],
    icon: 'needs_work',
    group: GROUP,
    disabled: needsTrack,
    run: (app) => judge(app, 'needs_work'),
  }),
  operation({
    id: 'judge-shown',
    label: 'Bulk review shown tracks …',
    keys: ['Shift+A'],
    group: GROUP,
    disabled: needsRun,
    run: (app) => app.store.dispatch(openDialog, { kind: 'bulk-review' }),
  }),
  operation({
    id: 'relabel',
    label: 'Relabel',
    keys: ['L'],
    icon: 'label',
    group: GROUP,
    disabled: needsTrack,
    tooltip: 'Choose the label of the track, or of this box alone (L). For labels pinned to a digit: (Ctrl+1) to (Ctrl+9)',
    run: (app) => {
      const { review } = app.store.get();
      if (!review?.selected) return;
      app.store.dispatch(openDialog, { kind: 'relabel', data: { key: review.selected, frame: review.frame } });
    },
  }),
  operation({
    id: 'pinned-label',
    label: 'Give a pinned label',
    keys: DIGITS.map((digit) => `Ctrl+${digit}`),
    group: GROUP,
    each: true,
    disabled: needsTrack,
    run: (app, key) => setPinnedLabel(app, String(key).slice(-1)),
  }),
  operation({
    id: 'ignore',
    label: 'Ignore the track, or no longer',
    short: 'Ignore',
    keys: ['U'],
    icon: 'ignore',
    group: GROUP,
    disabled: needsTrack,
    tooltip: 'Neither a sign nor background: comparisons and training ignore the track (U)',
    run: (app) => {
      const { review } = app.store.get();
      editSelected(app, { name: 'ignore', value: !(review?.selected && review.docs[review.selected]?.ignore) });
    },
  }),
  operation({
    id: 'note',
    label: 'Pin a note to this frame',
    short: 'Note',
    keys: ['P'],
    icon: 'note',
    group: GROUP,
    disabled: needsTrack,
    run: (app) => {
      const { review } = app.store.get();
      app.store.dispatch(openDialog, { kind: 'note', data: { key: review?.selected, frame: review?.frame } });
    },
  }),
];
