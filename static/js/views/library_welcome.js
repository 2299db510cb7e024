// @ts-check
/** The introduction for new users: the sample drive, its progress, and three hints. */

import { reviewAddress } from '../model/route.js';
import { runShare } from '../model/run_progress.js';
import { openDialog } from '../store/actions/page.js';
import { fill, h } from './dom.js';
import { icon, iconButton } from './icons.js';
import { imageHiddenUntilSet } from './images.js';
import { recall, remember } from '../core/preferences.js';
import { runProgress } from '../model/describe_run.js';

/** @typedef {import('../state-types.js').State} State */

const HINTS = /** @type {const} */ ([
  ['next', 'Walk the queue', 'J opens the next undecided track; the most uncertain come first.'],
  ['draw', 'Correct what is wrong', 'A accepts, L relabels, drag a box to move it. Every change is saved at once.'],
  ['whatif', 'Ask why', 'The lanes below the picture show the values behind each verdict. F1 lists all keys.'],
]);

/** @param {import('../page-types.js').App} app @returns {{element: HTMLElement, update: (state: State) => void}} */
export function createWelcome(app) {
  const action = h('div.welcome-action');
  const picture = imageHiddenUntilSet('img.welcome-picture', { alt: 'A frame of the sample drive' });
  const close = iconButton('close', 'Hide the introduction', () => {
    remember('welcome', 'hidden');
    element.hidden = true;
  });
  close.classList.add('welcome-close');
  const element = h(
    'section.welcome',
    { 'aria-labelledby': 'welcome-title', hidden: true },
    h('div.welcome-frame', picture),
    h(
      'div.welcome-text',
      h('h2.welcome-title', { id: 'welcome-title' }, 'Start with the sample drive'),
      h(
        'p.muted',
        'A short drive with traffic signs ships with the tool. The engine tracks and classifies them; you review what it was unsure of.',
      ),
      action,
      h('ol.hints', ...HINTS.map(([name, title, text]) => h('li.hint', icon(name), h('div', h('h3', title), h('p.muted.small', text))))),
    ),
    close,
  );
  let shownKey = '';

  /** @param {State} state */
  function update(state) {
    const sample = state.session?.sample;
    const video = sample && state.videos?.find(({ id }) => id === sample.video_id);
    // a user with videos of their own needs no introduction
    element.hidden = !video || recall('welcome') === 'hidden' || state.videos?.some((one) => !one.sample) === true;
    if (!video || element.hidden) return;
    const url = app.api.thumbnailUrl(video.id);
    if (video.state === 'ready' && picture.getAttribute('src') !== url) {
      picture.src = url;
      picture.hidden = false;
    }
    const runs = state.runs[video.id];
    const run = runs?.find(({ id }) => id === (video.latest_run ?? sample.run_id)) ?? runs?.[0];
    const nextKey = [video.state, video.latest_run, run?.state, run?.frames_done, run?.note].join();
    if (nextKey === shownKey) return;
    // The button keeps the focus while the numbers beside it change.
    const isReviewable = video.latest_run !== null;
    if (!action.firstElementChild || shownKey.split(',')[1] !== (video.latest_run ?? '') || !isReviewable) {
      fill(
        action,
        isReviewable
          ? h('a.btn.btn-primary.btn-large', { href: reviewAddress(video.id) }, icon('play'), 'Review the sample drive')
          : video.state === 'ready' &&
              h(
                'button.btn.btn-primary.btn-large',
                { onclick: () => app.store.dispatch(openDialog, { kind: 'run', data: { video: video.id } }) },
                icon('run'),
                'Run the engine on it',
              ),
        h('div.welcome-progress'),
      );
    }
    shownKey = nextKey;
    const progress = action.querySelector('.welcome-progress');
    if (!progress) return;
    const isActive = run && (run.state === 'running' || run.state === 'queued');
    if (video.state === 'importing') fill(progress, h('p.small.muted', 'Importing; a few seconds …'));
    else if (video.state === 'failed') fill(progress, h('p.small.field-error', video.error ?? 'The import failed.'));
    else if (isActive)
      fill(
        progress,
        h(
          'p.small.muted',
          isReviewable ? `${runProgress(run).replace(/\.$/, '')}. You can start now: results appear as they are ready.` : runProgress(run),
        ),
        h('span.meter', { style: { '--part': `${runShare(run) * 100}%` } }, h('span')),
      );
    else if (run) fill(progress, h('p.small.muted', runProgress(run)));
    else fill(progress);
  }

  return { element, update };
}
