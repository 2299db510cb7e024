// @ts-check
/** Following a sign through the video, and accepting the proposals. */

import { docOf, selectedDoc } from '../editing/revisions.js';
import { proposedFrameCount, isInProgress, anchorsAround, requestFrom, requestWith } from '../model/following.js';
import { trackEntries } from '../model/track_entries.js';
import { trackName } from '../model/track_name.js';
import { knownBox } from '../review/known_box.js';
import { selectedTrack } from '../review/shown_tracks.js';
import { cutFollowing, seek, setPlaying } from '../store/actions/review.js';
import { toast } from '../core/toast.js';
import { keyFrameRemedy, missingKeyFrame, needsKeyFrames } from './key_frames.js';
import { needsBox, needsTrack, onReview, operation } from './helpers.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

const GROUP = 'Follow a sign';

/** @param {State} state */
const isOpen = (state) => onReview(state) && state.review?.following != null && state.review.mode !== 'merge';

/** @param {State} state */
const needsProposals = (state) => {
  const following = state.review?.following;
  if (!following || proposedFrameCount(following) > 0) return null;
  return isInProgress(following) ? 'Nothing is proposed yet.' : 'Nothing is proposed: press Escape.';
};

/** Follow the selected track from its box in this frame. @param {App} app @param {'forward'|'backward'|null} only */
function follow(app, only) {
  const { review } = app.store.get();
  const shown = selectedTrack(review);
  if (!review || !shown) return;
  const anchor = { frame: review.frame, box: shown.box };
  const current = review.following;
  if (current?.key === shown.key && only === null) app.following.start(requestWith(current, anchor));
  else app.following.start(requestFrom(docOf(review, shown.key), shown.key, anchor, only));
}

/**
 * Follow a drawn box, unless proposals for another track still wait.
 * @param {App} app
 * @param {import('../state-types.js').Draft} draft
 */
export function followDrawn(app, { key, frame, box }) {
  const current = app.store.get().review?.following;
  if (current)
    toast(
      `Track ${trackName(current.key, app.store.get().review?.docs[current.key])} is still being followed: accept its boxes (Enter) or drop them (Escape). Then press T to follow the new track.`,
      { topic: 'follow' },
    );
  else app.following.start(requestFrom(null, key, { frame, box }, null));
}

/** The entry of the selected track. @param {State} state */
function entryOf({ review }) {
  return review ? (trackEntries(review.tracks, review.docs).find(({ key }) => key === review.selected) ?? null) : null;
}

/** Why the selected track cannot be extended at an end. @param {State} state @param {'first'|'last'} end */
function cannotExtend(state, end) {
  const missing = needsTrack(state);
  const entry = missing ? null : entryOf(state);
  if (missing || !entry || !state.review) return missing ?? 'Select a track first.';
  const edge = end === 'first' ? 0 : (state.review.timebase?.frames ?? 1) - 1;
  if (entry[end] === edge) return `The track already reaches the ${end} frame of the video.`;
  return knownBox(state.review, entry.key, entry[end]) ? null : 'The boxes of this track are still loading.';
}

/** @param {App} app @param {'first'|'last'} end */
function extend(app, end) {
  const state = app.store.get();
  const entry = entryOf(state);
  const box = entry && state.review ? knownBox(state.review, entry.key, entry[end]) : null;
  if (!entry || !state.review || !box) return;
  const anchor = { frame: entry[end], box };
  app.store.dispatch((now) => seek(setPlaying(now, false), anchor.frame));
  app.following.start(requestFrom(docOf(state.review, entry.key), entry.key, anchor, end === 'first' ? 'backward' : 'forward'));
}

/** The boxes that a person set before and after the cursor. @param {State} state */
function anchorsAroundCursor({ review }) {
  if (!review?.selected) return null;
  const { before, after } = anchorsAround(selectedDoc(review), review.frame + 0.5);
  return before && after ? [before, after] : null;
}

/** @param {App} app */
function followBetween(app) {
  const state = app.store.get();
  const anchors = anchorsAroundCursor(state);
  const key = state.review?.selected;
  if (anchors && key) app.following.start({ key, anchors, only: 'between', first: anchors[0].frame, last: anchors[1].frame });
}

/** @type {import('../page-types.js').Operation[]} */
export const following = [
  operation({
    id: 'accept-follow',
    label: 'Accept the proposed boxes',
    keys: ['Enter'],
    icon: 'accept',
    group: GROUP,
    available: isOpen,
    disabled: needsProposals,
    run: (app) => app.following.accept(),
  }),
  operation({
    id: 'drop-follow',
    label: 'Drop the proposed boxes',
    keys: ['Escape'],
    icon: 'close',
    group: GROUP,
    available: (state) => isOpen(state) && state.review?.mode === 'select',
    run: (app) => app.following.drop(),
  }),
  operation({
    id: 'cut-before',
    label: 'Propose nothing before this frame',
    keys: ['['],
    icon: 'previous',
    group: GROUP,
    available: isOpen,
    run: (app) => app.store.dispatch(cutFollowing, 'from'),
  }),
  operation({
    id: 'cut-after',
    label: 'Propose nothing after this frame',
    keys: [']'],
    icon: 'next',
    group: GROUP,
    available: isOpen,
    run: (app) => app.store.dispatch(cutFollowing, 'to'),
  }),
  operation({
    id: 'follow',
    label: 'Follow',
    keys: ['T'],
    icon: 'follow',
    group: GROUP,
    disabled: needsBox,
    tooltip: 'Follow the selected box until the sign is gone: both ways (T), forwards (Shift+T), between two corrected boxes (Alt+T)',
    run: (app) => follow(app, null),
  }),
  operation({
    id: 'follow-forward',
    label: 'Follow forwards',
    keys: ['Shift+T'],
    group: GROUP,
    disabled: needsBox,
    tooltip: 'Follow the selected box from this frame on (Shift+T)',
    run: (app) => follow(app, 'forward'),
  }),
  operation({
    id: 'follow-between',
    label: 'Follow between two key frames',
    keys: ['Alt+T'],
    group: GROUP,
    tooltip: 'Follow between the corrected boxes before and after the cursor (Alt+T)',
    disabled: (state) => needsTrack(state) ?? (anchorsAroundCursor(state) ? null : needsKeyFrames(missingKeyFrame(state))),
    remedy: keyFrameRemedy,
    run: followBetween,
  }),
  operation({
    id: 'extend-first',
    label: 'Extend back to the first frame of the sign',
    short: 'Extend back',
    keys: [','],
    icon: 'extend_first',
    group: GROUP,
    tooltip: 'Follow the track backwards from its first frame (,)',
    disabled: (state) => cannotExtend(state, 'first'),
    run: (app) => extend(app, 'first'),
  }),
  operation({
    id: 'extend-last',
    label: 'Extend on to the last frame of the sign',
    short: 'Extend on',
    keys: ['.'],
    icon: 'extend_last',
    group: GROUP,
    tooltip: 'Follow the track forwards from its last frame (.)',
    disabled: (state) => cannotExtend(state, 'last'),
    run: (app) => extend(app, 'last'),
  }),
];
