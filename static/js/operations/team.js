// @ts-check
/** Assignments: go to the next one. */

import { may, nextWork, toReview, workHere, workOf } from '../model/team.js';
import { formatRoute } from '../model/route.js';
import { operation } from './helpers.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../types.js').Assignment} Assignment */

/** The address at which an assignment begins. @param {Assignment} assignment */
export const placeOfWork = ({ video_id, first }) =>
  formatRoute({ screen: 'review', video: video_id, run: null, frame: first > 0 ? first : null, track: null });

/** @param {import('../state-types.js').State} state @returns {Assignment|null} */
export const openWork = (state) =>
  state.review ? workHere(state.assignments, state.session, state.review.video.id, state.review.frame) : null;

/** The assignment after the open one. @param {import('../state-types.js').State} state */
export const followingWork = (state) => nextWork(state.assignments, state.session, openWork(state)?.id ?? null);

/** Number of assignments that wait for the person who is signed in. @param {import('../state-types.js').State} state */
export function waitingWork({ assignments, session }) {
  const name = session?.person?.name ?? '';
  return { own: workOf(assignments, name), review: may(session, 'reviewer') ? toReview(assignments, name) : [] };
}

/** @type {import('../page-types.js').Operation[]} */
export const team = [
  operation({
    id: 'next-work',
    label: 'Next of my assignments',
    keys: ['Alt+Shift+J'],
    icon: 'forward',
    group: 'Queue',
    available: (state) => state.session?.person != null && (state.route.screen === 'review' || state.route.screen === 'library'),
    disabled: (state) => (followingWork(state) === null ? 'No other assignment waits for you.' : null),
    run: (app) => {
      const found = followingWork(app.store.get());
      if (found) location.hash = placeOfWork(found);
    },
  }),
  operation({
    id: 'sign-in',
    label: 'Sign in',
    keys: [],
    group: 'Queue',
    available: (state) => state.banners.some(({ id }) => id === 'denied'),
    run: () => location.assign(`/sign-in${location.hash}`),
  }),
];
