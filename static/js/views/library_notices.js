// @ts-check
/** Notices of the library in place of videos. */

import { h } from './dom.js';
import { emptyState, errorState } from './placeholders.js';
import { icon } from './icons.js';

/** @param {() => void} addVideo @param {() => void} upload */
export const noVideoNotice = (addVideo, upload) =>
  emptyState({
    icon: 'film',
    title: 'No video yet',
    text: 'Add a video from this machine, upload one, or drop files anywhere on this page. Nothing leaves this machine.',
    actions: [
      h('button.btn.btn-primary', { onclick: addVideo }, icon('folder'), 'Add from folder'),
      h('button.btn', { onclick: upload }, icon('upload'), 'Upload'),
    ],
  });

/** @param {() => void} clear */
export const noMatchNotice = (clear) =>
  emptyState({
    icon: 'search',
    title: 'No video matches',
    text: 'The search covers names and folders; every word must occur. The filters cover the tracks of the run that opens with a video.',
    actions: [h('button.btn', { onclick: clear }, 'Clear search and filters')],
  });

/** @param {unknown} thrown @param {() => void} retry */
export const loadErrorNotice = (thrown, retry) => errorState('The videos could not be loaded', thrown, retry);
