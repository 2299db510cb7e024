// @ts-check
/** One button that runs the engine on all videos that have no run yet. */

import {sentence} from '../api/errors.js';
import {notRunYet, oneByOne} from '../model/several_videos.js';
import {openDialog, putRun} from '../store/actions/page.js';
import {h, setText} from './dom.js';
import {count, plural} from './format.js';
import {icon} from './icons.js';
import {toast} from './toasts.js';

/** @typedef {import('../types.js').Video} Video */

/**
 * @param {Pick<import('../page-types.js').App, 'store'|'api'|'load'>} app
 * @returns {{element: HTMLElement, show: (found: readonly Video[]) => void}}
 */
export function createRunAll({store, api, load}) {
  /** @type {Video[]} */
  let videos = [];
  const words = h('span');
  const element = h('button', {class: 'btn', type: 'button', hidden: true, title: 'A run of the engine for each video that has none yet', onclick: ask}, icon('run'), words);

  function ask() {
    const wanted = videos;
    store.dispatch((state) => openDialog(state, {kind: 'confirm', data: {
      title: `Run the engine on ${plural(wanted.length, 'video')}?`,
      text: 'Each that is listed and has no run yet gets one, with the preset “default” and the models in use.',
      confirm: 'Start the runs',
      run: async () => {
        const {done, errors} = await oneByOne(wanted, (video) => load(() => api.startRun(video.id, {preset: 'default', parameters: {}}), putRun), sentence);
        if (done.length) toast(`${plural(done.length, 'run')} ${done.length === 1 ? 'is' : 'are'} started.`, {tone: 'good'});
        if (errors.length) toast(errors.join(' '), {tone: 'bad'});
      },
    }}));
  }

  return {
    element,
    show(found) {
      videos = notRunYet(found);
      element.hidden = videos.length < 2;
      setText(words, `Run all new (${count(videos.length)})`);
    },
  };
}
