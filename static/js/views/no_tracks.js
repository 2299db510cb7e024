// @ts-check
/** The reason for an empty list of tracks, with buttons that start a run or resume it. */

import { canResume, whyNoTracks } from '../model/no_tracks.js';
import { openDialog } from '../store/actions/page.js';
import { changeRun } from './change_run.js';
import { h, setText } from './dom.js';
import { icon } from './icons.js';
import { authorName } from '../core/preferences.js';

/** @param {import('../page-types.js').ViewApp} app @param {string} className */
export function createNoTracks(app, className) {
  const text = h('p');
  const resumeButton = h('button.btn.btn-small', { hidden: true, onclick: resumeRun }, icon('run'), 'Resume the run');
  const runButton = h(
    'button.btn.btn-small.btn-primary',
    { hidden: true, title: 'Choose parameters and find the signs of this video', onclick: openRuns },
    icon('run'),
    'Run the engine',
  );
  const byHandButton = h(
    'button.btn.btn-small',
    { hidden: true, title: 'A run without the engine: draw signs (N) and follow them (T)', onclick: annotateByHand },
    icon('draw'),
    'Annotate by hand',
  );
  const element = h('div', { class: `no-tracks muted ${className}`, hidden: true }, text, resumeButton, runButton, byHandButton);

  function openRuns() {
    const video = app.store.get().review?.video.id;
    if (video) app.store.dispatch(openDialog, { kind: 'run', data: { video } });
  }

  async function annotateByHand() {
    const video = app.store.get().review?.video.id;
    if (!video) return;
    byHandButton.disabled = true;
    await changeRun(app, () => app.api.startByHand(video, authorName(app.store.get().session)));
    byHandButton.disabled = false;
  }

  async function resumeRun() {
    const run = app.store.get().review?.run;
    if (!run) return;
    resumeButton.disabled = true;
    await changeRun(app, () => app.api.resumeRun(run.id));
    resumeButton.disabled = false;
  }

  return {
    element,
    /** @param {import('../state-types.js').ReviewState} review @param {number} total   number of tracks @param {string} [fallback]   the text if there are tracks */
    update(review, total, fallback = '') {
      const reason = whyNoTracks(review, total) || fallback;
      setText(text, reason);
      element.hidden = reason === '';
      resumeButton.hidden = !canResume(review, total);
      runButton.hidden = byHandButton.hidden = review.run !== null || review.timebase === null;
    },
  };
}
