// @ts-check
/** Judging tracks: accept, reject, needs work, label, not a sign, notes. */

import { openDialog } from '../store/actions/page.js';
import { endOfQueue, nextInQueue, queueCounts, shownQueue } from '../model/queue.js';
import { openTrack } from './navigate.js';
import { toast } from '../views/toasts.js';
import { editSelected, needsRun, needsTrack, operation } from './helpers.js';

/** @typedef {import('../page-types.js').App} App */

const GROUP = 'Verdict';

/**
 * Judge the selected track and go on with the next one that is left. A verdict that it has already stays: a key that is
 * pressed once too often must not take it back.
 * @param {Pick<App, 'store'|'edit'>} app
 * @param {'accepted'|'rejected'|'needs_work'} review
 * @param {(text: string, options: import('../views/toasts.js').ToastOptions) => void} [say]
 */
export function judge(app, review, say = toast) {
  const before = app.store.get();
  const key = before.review?.selected;
  if (!key) return;
  const present = before.review?.docs[key]?.review ?? 'open';
  const next = nextInQueue(before, 1);
  if (present !== review && !editSelected(app, { name: 'set_review', review })) return;
  const { left } = queueCounts(shownQueue(app.store.get()));
  if (left === 0) say('Nothing in the queue is left to be decided.', { topic: 'queue' });
  else if (next !== null) openTrack(app, next);
  else if (present === review) say(endOfQueue(before, 1), { topic: 'queue' });
}

/** @type {import('../page-types.js').Operation[]} */
export const verdicts = [
  operation({ id: 'accept', label: 'Accept the track and go to the next', keys: ['A'], icon: 'accept', group: GROUP, disabled: needsTrack, run: (app) => judge(app, 'accepted') }),
  operation({ id: 'reject', label: 'Reject the track and go to the next', keys: ['X'], icon: 'reject', group: GROUP, disabled: needsTrack, run: (app) => judge(app, 'rejected') }),
  operation({ id: 'needs-work', label: 'The track needs work, go to the next', keys: ['W'], icon: 'needs_work', group: GROUP, disabled: needsTrack, run: (app) => judge(app, 'needs_work') }),
  operation({
    id: 'judge-shown', label: 'Judge all shown tracks …', keys: ['Shift+A'], group: GROUP, disabled: needsRun,
    run: (app) => app.store.dispatch((state) => openDialog(state, { kind: 'judge' })),
  }),
  operation({
    id: 'relabel', label: 'Relabel', keys: ['L'], icon: 'label', group: GROUP, disabled: needsTrack,
    tooltip: 'Choose the class of the track, or of this box alone (L)',
    run: (app) => {
      const { review } = app.store.get();
      if (!review?.selected) return;
      app.store.dispatch((state) => openDialog(state, { kind: 'relabel', data: { key: review.selected, frame: review.frame } }));
    },
  }),
  operation({
    id: 'not-a-sign', label: 'Not a sign', keys: ['Shift+X'], icon: 'not_a_sign', group: GROUP, disabled: needsTrack,
    run: (app) => {
      const { review } = app.store.get();
      const present = review?.selected ? review.docs[review.selected]?.not_a_sign ?? false : false;
      editSelected(app, { name: 'set_not_a_sign', value: !present });
    },
  }),
  operation({
    id: 'note', label: 'Pin a note to this frame', keys: ['P'], icon: 'note', group: GROUP, disabled: needsTrack,
    run: (app) => {
      const { review } = app.store.get();
      app.store.dispatch((state) => openDialog(state, { kind: 'note', data: { key: review?.selected, frame: review?.frame } }));
    },
  }),
];
