// @ts-check
/** The assignments of a video on its card, with a button for reviewers. Hidden in a library of one user. */

import { assignedFrames, hasRole, STATES } from '../model/team.js';
import { openDialog } from '../store/actions/page.js';
import { fill, h } from './dom.js';
import { icon } from './icons.js';

/**
 * @param {import('../page-types.js').App} app
 * @param {string} id   id of the video
 */
export function createCardAssignments(app, id) {
  const element = h('div.card-assigned.small', { hidden: true });
  let shownKey = '';
  return {
    element,
    /** @param {import('../types.js').Video} video */
    update(video) {
      const { assignments, session } = app.store.get();
      const videoAssignments = assignments.filter(({ video_id }) => video_id === id);
      const canAssign = session?.person != null && hasRole(session, 'reviewer') && video.state === 'ready';
      const key = JSON.stringify([videoAssignments, canAssign, video.name]);
      if (key === shownKey) return;
      shownKey = key;
      element.hidden = videoAssignments.length === 0 && !canAssign;
      fill(
        element,
        ...videoAssignments.slice(0, 3).map((assignment) =>
          h(
            'span',
            {
              class: `state-chip state-${assignment.state}`,
              title: `${assignment.person}: ${STATES[assignment.state]}, ${assignedFrames(assignment)}`,
            },
            `${assignment.person}: ${STATES[assignment.state]}`,
          ),
        ),
        videoAssignments.length > 3 && h('span.muted', `and ${videoAssignments.length - 3} more`),
        h('span.grow'),
        canAssign &&
          h(
            'button.btn.btn-quiet.btn-small',
            {
              'aria-label': `Assign ${video.name}`,
              title: 'Assign this video, or some of its frames, to somebody …',
              onclick: () => app.store.dispatch(openDialog, { kind: 'assign', data: { video: id } }),
            },
            icon('person'),
            'Assign',
          ),
      );
    },
  };
}
