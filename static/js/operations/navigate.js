// @ts-check
/** Moving through time. */

import { endOfQueue, nextInQueue, queueCounts, shownQueue } from '../model/queue.js';
import { playOrPause, seek, select, setPlaying, step } from '../store/actions/review.js';
import { clearestFrame } from '../model/clearest.js';
import { spanOf } from '../model/effective.js';
import { sizeOf } from '../model/geometry.js';
import { docOf, selectedDoc } from '../editing/revisions.js';
import { keyFramesOf } from '../model/documents.js';
import { trackName } from '../model/track_name.js';
import { toast } from '../core/toast.js';
import { needsTrack, operation } from './helpers.js';
import { followingAssignment } from './team.js';

/** @typedef {import('../page-types.js').App} App */

const GROUP = 'Time';

/** @param {App} app @param {number|null|undefined} frame */
const seekTo = (app, frame) => {
  if (frame !== null && frame !== undefined) app.store.dispatch((state) => seek(setPlaying(state, false), frame));
};

/**
 * Show a track: select it, and go to its clearest frame.
 * @param {Pick<import('../page-types.js').ViewApp, 'store'>} app
 * @param {string} key
 */
export function openTrack(app, key) {
  const { review } = app.store.get();
  const doc = review && docOf(review, key);
  const clearest = doc && clearestFrame(doc, review.tracks, sizeOf(review.video));
  app.store.dispatch((state) => select(clearest === null ? state : seek(setPlaying(state, false), clearest), key));
}

/**
 * Open the first undecided track of the queue, unless a track is already selected or none is left.
 * @param {Pick<import('../page-types.js').ViewApp, 'store'>} app
 */
export function openFirst(app) {
  const state = app.store.get();
  const key = state.review?.selected === null && queueCounts(shownQueue(state)).left > 0 ? nextInQueue(state, 1) : null;
  if (key !== null) openTrack(app, key);
}

/** @param {App} app @param {1|-1} direction */
function stepInQueue(app, direction) {
  const key = nextInQueue(app.store.get(), direction);
  if (key !== null) openTrack(app, key);
  else
    toast(
      `${endOfQueue(app.store.get(), direction)}${direction > 0 && followingAssignment(app.store.get()) ? ' Press Alt+Shift+J for your next assignment.' : ''}`,
      { topic: 'queue' },
    );
}

/**
 * Go to a key frame of the selected track; without a selection, of the video. After a track's last key frame the cursor
 * stays: a key frame of the video would look like one of the track.
 * @param {App} app
 * @param {1|-1} direction
 * @param {import('../core/toast.js').Notify} [notify]
 */
export function stepToKeyFrame(app, direction, notify = toast) {
  const { review } = app.store.get();
  if (!review?.timebase) return;
  if (review.selected === null) {
    seekTo(app, direction > 0 ? review.timebase.nextKey(review.frame) : review.timebase.previousKey(review.frame));
    return;
  }
  const doc = review.docs[review.selected];
  const frames = doc ? keyFramesOf(doc) : [];
  const found = direction > 0 ? frames.find((k) => k > review.frame) : frames.findLast((k) => k < review.frame);
  const none = frames.length === 0 ? 'no key frame yet' : `no ${direction > 0 ? 'later' : 'earlier'} key frame`;
  if (found === undefined) notify(`Track ${trackName(review.selected, doc)} has ${none}.`, { topic: 'key-frame' });
  else seekTo(app, found);
}

/** A step over some frames. @param {{id: string, label: string, short?: string, keys: string[], icon: string}} fields @param {number} by */
const stepOperation = (fields, by) => operation({ ...fields, group: GROUP, repeats: true, run: (app) => app.store.dispatch(step, by) });

/** @type {import('../page-types.js').Operation[]} */
export const navigation = [
  stepOperation({ id: 'previous-frame', label: 'Previous frame', short: 'Previous', keys: ['D'], icon: 'step_back' }, -1),
  operation({
    id: 'play',
    label: 'Play or pause',
    short: 'Play',
    keys: ['Space'],
    icon: 'play',
    group: GROUP,
    run: (app) => app.store.dispatch(playOrPause),
  }),
  stepOperation({ id: 'next-frame', label: 'Next frame', short: 'Next', keys: ['F'], icon: 'step_forward' }, 1),
  stepOperation({ id: 'back-10', label: 'Back 10', keys: ['C'], icon: 'skip_back' }, -10),
  stepOperation({ id: 'on-10', label: 'Forward 10', keys: ['V'], icon: 'skip_forward' }, 10),
  operation({
    id: 'next-key',
    label: 'Next key frame',
    short: 'Next key',
    keys: ['R'],
    tooltip: 'Next key frame of the selected track; without a selection, of the video (R)',
    icon: 'key_forward',
    group: GROUP,
    repeats: true,
    run: (app) => stepToKeyFrame(app, 1),
  }),
  operation({
    id: 'previous-key',
    label: 'Previous key frame',
    short: 'Previous key',
    keys: ['E'],
    tooltip: 'Previous key frame of the selected track; without a selection, of the video (E)',
    icon: 'key_back',
    group: GROUP,
    repeats: true,
    run: (app) => stepToKeyFrame(app, -1),
  }),
  operation({
    id: 'first-frame',
    label: 'First frame',
    short: 'First',
    keys: ['Home'],
    icon: 'previous',
    group: GROUP,
    run: (app) => seekTo(app, 0),
  }),
  operation({
    id: 'last-frame',
    label: 'Last frame',
    short: 'Last',
    keys: ['End'],
    icon: 'next',
    group: GROUP,
    run: (app) => seekTo(app, (app.store.get().review?.timebase?.frames ?? 1) - 1),
  }),
  operation({
    id: 'go-to-frame',
    label: 'Go to a frame by its number',
    keys: ['G'],
    group: GROUP,
    run: () => /** @type {HTMLInputElement|null} */ (document.querySelector('.picture-frame'))?.focus(),
  }),
  operation({
    id: 'speed',
    label: 'Playing speed',
    keys: [],
    group: GROUP,
    run: () => /** @type {HTMLSelectElement|null} */ (document.querySelector('.picture-speed'))?.focus(),
  }),
  operation({
    id: 'next-in-queue',
    label: 'Next undecided track',
    short: 'Next',
    keys: ['J'],
    icon: 'down',
    group: 'Queue',
    repeats: true,
    run: (app) => stepInQueue(app, 1),
  }),
  operation({
    id: 'previous-in-queue',
    label: 'Previous in the queue',
    short: 'Previous',
    keys: ['Shift+J'],
    icon: 'up',
    group: 'Queue',
    repeats: true,
    run: (app) => stepInQueue(app, -1),
  }),
  operation({
    id: 'to-track',
    label: 'Go to the start of the track',
    short: 'Start',
    keys: ['B'],
    icon: 'to_start',
    group: 'Queue',
    disabled: needsTrack,
    run: (app) => {
      const doc = selectedDoc(app.store.get().review);
      seekTo(app, doc && spanOf(doc)?.first);
    },
  }),
];
