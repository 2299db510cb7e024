// @ts-check
/** The assignments of a video on its card, with a button for reviewers. Hidden in a library of one user. */

import { assignedFrames, may, STATES } from '../model/team.js';
import { openDialog } from '../store/actions/page.js';
import { fill, h } from './dom.js';
import { icon } from './icons.js';

/**
 * @param {import('../page-types.js').App} app
 * @param {string} id   id of the video
 */
export function createAssigned(app, id) {
  const element = h('div.card-assigned.small', { hidden: true });
  let shown = '';
  return {
    element,
    /** @param {import('../types.js').Video} video */
    update(video) {
      const { assignments, session } = app.store.get();
      const mine = assignments.filter(({ video_id }) => video_id === id);
      const gives = session?.person != null && may(session, 'reviewer') && video.state === 'ready';
      const key = JSON.stringify([mine, gives, video.name]);
      if (key === shown) return;
      shown = key;
      element.hidden = mine.length === 0 && !gives;
      fill(
        element,
        ...mine
          .slice(0, 3)
          .map((one) =>
            h(
              'span',
              { class: `state-chip state-${one.state}`, title: `${one.person}: ${STATES[one.state]}, ${assignedFrames(one)}` },
              `${one.person}: ${STATES[one.state]}`,
            ),
          ),
        mine.length > 3 && h('span.muted', `and ${mine.length - 3} more`),
        h('span.grow'),
        gives &&
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
