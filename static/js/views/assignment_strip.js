// @ts-check
/** The open assignment above the picture: its instructions and its state. */

import { errorMessage } from '../api/errors.js';
import { assignedFrames, hasRole, STATES } from '../model/team.js';
import { openAssignment, assignmentsForUser } from '../operations/team.js';
import { runOperation } from '../operations/registry.js';
import { openDialog } from '../store/actions/page.js';
import { putAssignment } from '../store/actions/team.js';
import { fill, h } from './dom.js';
import { toast } from '../core/toast.js';

/** @typedef {import('../types.js').Assignment} Assignment */

/**
 * Change an assignment. If somebody else changed it first, show their version and say so.
 *
 * @param {import('../page-types.js').App} app
 * @param {Assignment} assignment
 * @param {Parameters<import('../page-types.js').App['api']['changeAssignment']>[1]} change
 * @param {string} notice   notice after the change is stored
 */
export async function changeAssignment(app, assignment, change, notice) {
  try {
    const stored = await app.api.changeAssignment(assignment, change);
    app.store.dispatch(putAssignment, stored);
    toast(notice, { tone: 'good' });
  } catch (thrown) {
    const current = Reflect.get(Object(thrown), 'details')?.current;
    if (current) app.store.dispatch(putAssignment, current);
    toast(errorMessage(thrown), { tone: 'bad' });
  }
}

/** @type {import('../page-types.js').CreatePart} */
export function createAssignmentStrip(app) {
  const element = h('section.work-strip', { 'aria-label': 'Assignment', hidden: true });
  let shownKey = '';

  /** @param {string} label @param {string} title @param {() => void} run @param {boolean} [primary] */
  const button = (label, title, run, primary = false) =>
    h('button', { class: `btn btn-small ${primary ? 'btn-primary' : ''}`, title, onclick: run }, label);

  /** @param {Assignment} assignment @param {boolean} isOwn @param {boolean} isReviewer */
  function actions(assignment, isOwn, isReviewer) {
    const { person, state } = assignment;
    /** @param {Assignment['state']} to @param {string} notice */
    const change = (to, notice) => void changeAssignment(app, assignment, { state: to }, notice);
    return [
      isOwn &&
        (state === 'assigned' || state === 'returned') &&
        button('Hand in', 'Finish your work and pass it to a reviewer', () => change('in_review', 'Your work is handed in.'), true),
      isOwn && state === 'in_review' && button('Take back', 'Continue to work on it', () => change('assigned', 'The work is yours again.')),
      isReviewer &&
        state === 'in_review' &&
        button('Done', 'Nothing is left to do', () => change('done', `The work of ${person} is marked as done.`), !isOwn),
      isReviewer &&
        state === 'in_review' &&
        button('Return …', 'Return it with a comment on what to do again', () =>
          app.store.dispatch(openDialog, { kind: 'return-work', data: { assignment } }),
        ),
    ];
  }

  return {
    element,
    update(state) {
      const assignment = openAssignment(state);
      const waiting = assignmentsForUser(state);
      const otherCount = [...waiting.own, ...waiting.review].filter(({ id }) => id !== assignment?.id).length;
      const key = JSON.stringify([assignment, otherCount, state.session?.person]);
      if (key === shownKey) return;
      shownKey = key;
      element.hidden = assignment === null;
      if (assignment === null) return;
      const isOwn = assignment.person === state.session?.person?.name;
      const nextOperation = app.operations.find(({ id }) => id === 'next-work');
      fill(
        element,
        h('span', { class: `state-chip state-${assignment.state}` }, STATES[assignment.state]),
        h('span.truncate', `${isOwn ? 'Your work' : `Work of ${assignment.person}`}: ${assignedFrames(assignment)}`),
        assignment.comment &&
          h(
            'span.work-comment.truncate.grow',
            { dir: 'auto', title: `${assignment.changed_by}: ${assignment.comment}` },
            `“${assignment.comment}”`,
          ),
        !assignment.comment && h('span.grow'),
        ...actions(assignment, isOwn, hasRole(state.session, 'reviewer')),
        nextOperation &&
          otherCount > 0 &&
          h(
            'button.btn.btn-small',
            { title: nextOperation.tooltip, onclick: () => runOperation(app, nextOperation, (reason) => toast(reason)) },
            `Next (${otherCount})`,
          ),
      );
    },
  };
}
