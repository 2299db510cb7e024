// @ts-check
/** Assignments at the top of the library: the person's own, and for reviewers those that were handed in. */

import { assignedFrames, STATES } from '../model/team.js';
import { assignmentAddress, assignmentsForUser } from '../operations/team.js';
import { fill, h } from './dom.js';
import { plural } from '../model/format.js';

/** Maximum number of rows of each list; the rest is counted. */
const MAX_ROWS = 8;

/** @param {import('../types.js').Assignment} assignment @param {boolean} isOwn */
const row = (assignment, isOwn) =>
  h(
    'li.work-row',
    h(
      'a.work-link',
      { href: assignmentAddress(assignment) },
      h('span', { class: `state-chip state-${assignment.state}` }, STATES[assignment.state]),
      h('span.work-name.truncate', { dir: 'auto' }, assignment.video_name),
      h('span.small.muted', isOwn ? assignedFrames(assignment) : `${assignment.person}, ${assignedFrames(assignment)}`),
      assignment.comment &&
        h('span.work-comment.truncate.grow.small', { dir: 'auto', title: assignment.comment }, `“${assignment.comment}”`),
    ),
  );

/** @returns {{element: HTMLElement, update: (state: import('../state-types.js').State) => void}} */
export function createAssignmentLists() {
  const element = h('section.my-work', { 'aria-label': 'My work', hidden: true });
  let shownKey = '';
  return {
    element,
    update(state) {
      const { own: assignedToPerson, review } = assignmentsForUser(state);
      const key = JSON.stringify([assignedToPerson, review]);
      if (key === shownKey) return;
      shownKey = key;
      element.hidden = assignedToPerson.length + review.length === 0;
      const lists = /** @type {const} */ ([
        ['My work', assignedToPerson, true],
        ['To review', review, false],
      ]);
      fill(
        element,
        ...lists
          .filter(([, assignments]) => assignments.length > 0)
          .map(([title, assignments, isOwn]) =>
            h(
              'div.work-list',
              h('h2.work-title', `${title} `, h('span.muted.small', plural(assignments.length, 'assignment'))),
              h('ul', { 'aria-label': title }, ...assignments.slice(0, MAX_ROWS).map((assignment) => row(assignment, isOwn))),
              assignments.length > MAX_ROWS && h('p.small.muted', `and ${assignments.length - MAX_ROWS} more: Alt+Shift+J opens the next`),
            ),
          ),
      );
    },
  };
}
