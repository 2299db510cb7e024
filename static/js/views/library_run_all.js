// @ts-check
/** One button that runs the engine on all videos that have no run yet. */

import { videosWithoutRun } from '../model/several_videos.js';
import { openDialog } from '../store/actions/page.js';
import { h, setText } from './dom.js';
import { count } from '../model/format.js';
import { icon } from './icons.js';

/** @typedef {import('../types.js').Video} Video */

/**
 * @param {Pick<import('../page-types.js').App, 'store'>} app
 * @returns {{element: HTMLElement, show: (found: readonly Video[]) => void}}
 */
export function createRunAll({ store }) {
  /** @type {Video[]} */ let videos = [];
  const label = h('span');
  const element = h(
    'button.btn',
    {
      hidden: true,
      title: 'Run the engine on each video that has no run yet',
      onclick: () => {
        store.dispatch(openDialog, { kind: 'run-several', data: { videos } });
      },
    },
    icon('run'),
    label,
  );

  return {
    element,
    show(found) {
      videos = videosWithoutRun(found);
      element.hidden = videos.length < 2;
      setText(label, `Run all new (${count(videos.length)})`);
    },
  };
}
