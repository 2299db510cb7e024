// @ts-check
/** The state of a follow, with buttons that accept or drop its proposals. */

import { describeFollowing, isInProgress } from '../../model/following.js';
import { trackName } from '../../model/track_name.js';
import { runOperation } from '../../operations/registry.js';
import { h, setText } from '../dom.js';
import { icon, isIcon } from '../icons.js';
import { toast } from '../../core/toast.js';

const BUTTONS = /** @type {const} */ ([
  ['accept-follow', 'Accept', 'btn-primary'],
  ['cut-before', 'Cut before', ''],
  ['cut-after', 'Cut after', ''],
  ['drop-follow', 'Drop', ''],
]);

/** @param {import('../../page-types.js').App} app */
export function createFollowBar(app) {
  const statusText = h('span.grow.follow-words', { role: 'status' });
  const buttons = BUTTONS.map(([id, text, tone]) => {
    const operation = app.operations.find((one) => one.id === id);
    const buttonIcon = operation?.icon && isIcon(operation.icon) ? icon(operation.icon) : null;
    const button = h(
      'button',
      {
        class: `btn btn-small ${tone}`,
        title: operation?.tooltip ?? text,
        onclick: () => operation && runOperation(app, operation, toast),
      },
      buttonIcon,
      h('span', text),
    );
    return { operation, button };
  });
  const element = h(
    'div.follow-bar',
    { hidden: true, role: 'group', 'aria-label': 'Proposed boxes' },
    statusText,
    ...buttons.map(({ button }) => button),
  );
  /** @type {import('../../state-types.js').ReviewState|null} */ let lastReview = null;
  return {
    element,
    /** @param {import('../../state-types.js').State} state */
    update(state) {
      const { review } = state;
      if (review === lastReview) return;
      lastReview = review;
      const following = review?.following ?? null;
      element.hidden = following === null;
      if (!review || following === null) return;
      element.classList.toggle('follow-under-way', isInProgress(following));
      const description = describeFollowing(following, trackName(following.key, review.docs[following.key]));
      setText(statusText, description);
      statusText.title = description;
      for (const { operation, button } of buttons) button.setAttribute('aria-disabled', String(Boolean(operation?.disabled(state))));
    },
  };
}
