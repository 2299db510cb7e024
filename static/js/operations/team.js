// @ts-check
/** Assignments: go to the next one. */

import { hasRole, nextAssignment, assignmentsToReview, currentAssignment, waitingAssignments } from '../model/team.js';
import { formatRoute } from '../model/route.js';
import { operation } from './helpers.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../types.js').Assignment} Assignment */

/** The address at which an assignment begins. @param {Assignment} assignment */
export const assignmentAddress = ({ video_id, first }) =>
  formatRoute({ screen: 'review', video: video_id, run: null, frame: first > 0 ? first : null, track: null });

/** @param {import('../state-types.js').State} state @returns {Assignment|null} */
export const openAssignment = (state) =>
  state.review ? currentAssignment(state.assignments, state.session, state.review.video.id, state.review.frame) : null;

/** The assignment after the open one. @param {import('../state-types.js').State} state */
export const followingAssignment = (state) => nextAssignment(state.assignments, state.session, openAssignment(state)?.id ?? null);

/** Assignments that wait for the person who is signed in: their own, and those to review. @param {import('../state-types.js').State} state */
export function assignmentsForUser({ assignments, session }) {
  const name = session?.person?.name ?? '';
  return { own: waitingAssignments(assignments, name), review: hasRole(session, 'reviewer') ? assignmentsToReview(assignments, name) : [] };
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
    disabled: (state) => (followingAssignment(state) === null ? 'No other assignment waits for you.' : null),
    run: (app) => {
      const found = followingAssignment(app.store.get());
      if (found) location.hash = assignmentAddress(found);
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
