// @ts-check
/** The reason for an empty list of tracks, with a button if the run can be resumed. */

import { canResume, whyNoTracks } from '../model/no_tracks.js';
import { changeRun } from './change_run.js';
import { h, setText } from './dom.js';
import { icon } from './icons.js';
import { authorName } from '../core/preferences.js';

/**
 * @param {import('./app.js').ViewApp} app
 * @param {string} className
 */
export function createNoTracks(app, className) {
  const text = h('p');
  const resume = h('button.btn.btn-small', { hidden: true, onclick: goOn }, icon('run'), 'Resume the run');
  const byHand = h(
    'button.btn.btn-small',
    { hidden: true, title: 'A run without the engine: draw signs (N) and follow them (T)', onclick: draw },
    icon('draw'),
    'Annotate by hand',
  );
  const element = h('div', { class: `no-tracks muted ${className}`, hidden: true }, text, resume, byHand);

  async function draw() {
    const video = app.store.get().review?.video.id;
    if (!video) return;
    byHand.disabled = true;
    await changeRun(app, () => app.api.startByHand(video, authorName(app.store.get().session)));
    byHand.disabled = false;
  }

  async function goOn() {
    const run = app.store.get().review?.run;
    if (!run) return;
    resume.disabled = true;
    await changeRun(app, () => app.api.resumeRun(run.id));
    resume.disabled = false;
  }

  return {
    element,
    /** @param {import('../state-types.js').ReviewState} review @param {number} total   number of tracks @param {string} [otherwise]   the text if there are tracks */
    update(review, total, otherwise = '') {
      const why = whyNoTracks(review, total) || otherwise;
      setText(text, why);
      element.hidden = why === '';
      resume.hidden = !canResume(review, total);
      byHand.hidden = review.run !== null || review.timebase === null;
    },
  };
}
