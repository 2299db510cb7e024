// @ts-check
/** Assignments at the top of the library: the person's own, and for reviewers those that were handed in. */

import { assignedFrames, STATES } from '../model/team.js';
import { assignmentAddress, assignmentsForUser } from '../operations/team.js';
import { fill, h } from './dom.js';
import { plural } from '../model/format.js';

/** Maximum number of rows of each list; the rest is counted. */
const MOST = 8;

/** @param {import('../types.js').Assignment} one @param {boolean} own */
const row = (one, own) =>
  h(
    'li.work-row',
    h(
      'a.work-link',
      { href: assignmentAddress(one) },
      h('span', { class: `state-chip state-${one.state}` }, STATES[one.state]),
      h('span.work-name.truncate', { dir: 'auto' }, one.video_name),
      h('span.small.muted', own ? assignedFrames(one) : `${one.person}, ${assignedFrames(one)}`),
      one.comment && h('span.work-comment.truncate.grow.small', { dir: 'auto', title: one.comment }, `“${one.comment}”`),
    ),
  );

/** @returns {{element: HTMLElement, update: (state: import('../state-types.js').State) => void}} */
export function createWork() {
  const element = h('section.my-work', { 'aria-label': 'My work', hidden: true });
  let shown = '';
  return {
    element,
    update(state) {
      const { own, review } = assignmentsForUser(state);
      const key = JSON.stringify([own, review]);
      if (key === shown) return;
      shown = key;
      element.hidden = own.length + review.length === 0;
      const lists = /** @type {const} */ ([
        ['My work', own, true],
        ['To review', review, false],
      ]);
      fill(
        element,
        ...lists
          .filter(([, found]) => found.length > 0)
          .map(([title, found, mine]) =>
            h(
              'div.work-list',
              h('h2.work-title', `${title} `, h('span.muted.small', plural(found.length, 'assignment'))),
              h('ul', { 'aria-label': title }, ...found.slice(0, MOST).map((one) => row(one, mine))),
              found.length > MOST && h('p.small.muted', `and ${found.length - MOST} more: Alt+Shift+J opens the next`),
            ),
          ),
      );
    },
  };
}
