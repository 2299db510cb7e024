// @ts-check
/** The open assignment above the picture: its instructions and its state. */

import { sentence } from '../api/errors.js';
import { assignedFrames, may, STATES } from '../model/team.js';
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
 * @param {Assignment} known
 * @param {Parameters<import('../page-types.js').App['api']['changeAssignment']>[1]} change
 * @param {string} done   notice after the change is stored
 */
export async function changeWork(app, known, change, done) {
  try {
    const now = await app.api.changeAssignment(known, change);
    app.store.dispatch(putAssignment, now);
    toast(done, { tone: 'good' });
  } catch (thrown) {
    const current = Reflect.get(Object(thrown), 'details')?.current;
    if (current) app.store.dispatch(putAssignment, current);
    toast(sentence(thrown), { tone: 'bad' });
  }
}

/**
 * @param {import('../page-types.js').App} app
 * @returns {import('../page-types.js').View}
 */
export function createWorkStrip(app) {
  const element = h('section.work-strip', { 'aria-label': 'Assignment', hidden: true });
  let shown = '';

  /** @param {string} label @param {string} title @param {() => void} run @param {boolean} [primary] */
  const button = (label, title, run, primary = false) =>
    h('button', { class: `btn btn-small ${primary ? 'btn-primary' : ''}`, title, onclick: run }, label);

  /** @param {Assignment} work @param {boolean} own @param {boolean} reviewer */
  function actions(work, own, reviewer) {
    const found = [];
    if (own && (work.state === 'assigned' || work.state === 'returned'))
      found.push(
        button(
          'Hand in',
          'Finish your work and pass it to a reviewer',
          () => void changeWork(app, work, { state: 'in_review' }, 'Your work is handed in.'),
          true,
        ),
      );
    if (own && work.state === 'in_review')
      found.push(
        button('Take back', 'Continue to work on it', () => void changeWork(app, work, { state: 'assigned' }, 'The work is yours again.')),
      );
    if (reviewer && work.state === 'in_review') {
      found.push(
        button(
          'Done',
          'Nothing is left to do',
          () => void changeWork(app, work, { state: 'done' }, `The work of ${work.person} is marked as done.`),
          !own,
        ),
      );
      found.push(
        button('Return …', 'Return it with a comment on what to do again', () =>
          app.store.dispatch(openDialog, { kind: 'return-work', data: { assignment: work } }),
        ),
      );
    }
    return found;
  }

  return {
    element,
    update(state) {
      const work = openAssignment(state);
      const waiting = assignmentsForUser(state);
      const others = [...waiting.own, ...waiting.review].filter(({ id }) => id !== work?.id).length;
      const key = JSON.stringify([work, others, state.session?.person]);
      if (key === shown) return;
      shown = key;
      element.hidden = work === null;
      if (work === null) return;
      const own = work.person === state.session?.person?.name;
      const following = app.operations.find(({ id }) => id === 'next-work');
      fill(
        element,
        h('span', { class: `state-chip state-${work.state}` }, STATES[work.state]),
        h('span.truncate', `${own ? 'Your work' : `Work of ${work.person}`}: ${assignedFrames(work)}`),
        work.comment &&
          h('span.work-comment.truncate.grow', { dir: 'auto', title: `${work.changed_by}: ${work.comment}` }, `“${work.comment}”`),
        !work.comment && h('span.grow'),
        ...actions(work, own, may(state.session, 'reviewer')),
        following &&
          others > 0 &&
          h(
            'button.btn.btn-small',
            { title: following.tooltip, onclick: () => runOperation(app, following, (reason) => toast(reason)) },
            `Next (${others})`,
          ),
      );
    },
    destroy: () => element.remove(),
  };
}
