// @ts-check
/** One video of the library. Elements are kept while the progress changes, so that focus and hover stay. */

import { isVideoFile } from '../model/exchange.js';
import { reviewAddress } from '../model/route.js';
import { runShare } from '../model/run_progress.js';
import { hasRole } from '../model/team.js';
import { dropVideo, openDialog, putVideo } from '../store/actions/page.js';
import { createCardAssignments } from './library_card_assignments.js';
import { fill, h, setText } from './dom.js';
import { acceptFileDrops } from './file_drop.js';
import { bytes, clock, count, figure, plural } from '../model/format.js';
import { icon } from './icons.js';
import { createProgressBar, setProgress } from './progress_bar.js';
import { imageHiddenUntilSet } from './images.js';
import { runProgress } from '../model/describe_run.js';
import { toast } from '../core/toast.js';
import { toastErrors } from './toast_errors.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../types.js').Run} Run */
/** @typedef {import('../types.js').Video} Video */

/**
 * @param {App} app
 * @param {Video} initialVideo
 * @param {(on: boolean, range: boolean) => void} onChoose   called when the video is selected; range: with all since the last one
 * @returns {{element: HTMLElement, show: (video: Video, runs: Run[]|undefined, chosen: boolean) => void}}
 */
export function createCard(app, initialVideo, onChoose) {
  const picture = imageHiddenUntilSet('img.card-picture', { loading: 'lazy', width: 320, height: 180 });
  const length = h('span.card-length');
  const title = h('h2.card-title.truncate', { id: `video-${initialVideo.id.slice(0, 12)}` });
  const infoText = h('p.card-facts.muted.small');
  const state = h('div.card-state');
  const actions = h('div.card-actions');
  const checkbox = h('input', {
    type: 'checkbox',
    onclick: (/** @type {MouseEvent} */ event) => onChoose(checkbox.checked, event.shiftKey),
  });
  const checkboxLabel = h(
    'label.card-choice',
    { title: 'Select for actions on several videos. With Shift: all since the last one' },
    checkbox,
  );
  const assigned = createCardAssignments(app, initialVideo.id);
  const element = h(
    'li.card',
    { 'aria-labelledby': title.id },
    h('div.card-frame', icon('film'), picture, length, checkboxLabel),
    h('div.card-body', title, infoText, state, assigned.element, actions),
  );
  acceptFileDrops(element, ([file]) => {
    if (!file || isVideoFile(file)) return false;
    app.store.dispatch(openDialog, { kind: 'import', data: { video: initialVideo.id, file } });
    return true;
  });
  /** @type {[Video, Run[]|undefined]|null} */ let shown = null;
  /** @type {string|undefined} */ let shownRole;
  let actionsKey = '';

  /** @param {Video} video @param {Run[]|undefined} runs @param {boolean} chosen */
  function show(video, runs, chosen) {
    assigned.update(video);
    checkbox.checked = chosen;
    element.classList.toggle('card-chosen', chosen);
    const role = app.store.get().session?.person?.role;
    if (role === shownRole && shown && shown[0] === video && shown[1] === runs) return;
    if (shown?.[0] !== video) showInfo(video);
    [shown, shownRole] = [[video, runs], role];
    fill(state, ...stateOf(video, runs));
    const key = [video.state, video.missing, video.latest_run, video.runs, role].join();
    // Rebuilt only if the actions change: progress must not take the focus away.
    if (key !== actionsKey) fill(actions, ...actionsOf(app, video));
    actionsKey = key;
  }

  /** @param {Video} video */
  function showInfo(video) {
    setText(title, video.name);
    checkbox.setAttribute('aria-label', `Choose ${video.name}`);
    title.title = video.path;
    setText(length, clock(video.duration));
    length.hidden = video.duration === null;
    const parts = [
      video.width && video.height ? `${video.width} × ${video.height}` : '',
      video.rate ? `${figure(video.rate)} fps` : '',
      video.frames === null ? '' : plural(video.frames, 'frame'),
      bytes(video.size),
    ];
    setText(
      infoText,
      parts
        .filter(Boolean)
        .map((part) => part.replaceAll(' ', '\u00a0'))
        .join(' · '),
    ); // so that lines break between facts, not inside one
    const url = app.api.thumbnailUrl(video.id);
    if (video.state === 'ready' && picture.getAttribute('src') !== url) {
      picture.src = url;
      picture.hidden = false;
    }
  }

  return { element, show };
}

/** @param {Video} video @param {Run[]|undefined} runs @returns {HTMLElement[]} */
function stateOf(video, runs) {
  const lines = [];
  if (video.missing) {
    lines.push(
      message('warn', 'The file is missing. Put it back, or add it from its new path; runs and corrections are kept.', video.path),
    );
  }
  if (video.state === 'importing') {
    lines.push(h('p.small', 'Importing: every frame is decoded once …'), meter(null, 'Import'));
  } else if (video.state === 'failed') {
    lines.push(message('bad', video.error ?? 'The import failed without saying why; the terminal of the server has more.'));
  } else {
    const activeRun = runs?.find((run) => run.state === 'running') ?? runs?.find((run) => run.state === 'queued');
    const latestRun = runs?.find((run) => run.id === video.latest_run);
    if (activeRun) lines.push(h('p.small', runProgress(activeRun)), meter(runShare(activeRun), 'Run'));
    else if (latestRun && latestRun.state !== 'complete')
      lines.push(message(latestRun.state === 'failed' ? 'bad' : 'warn', runProgress(latestRun)));
    const { tracks, reviewed } = video.review;
    if (!activeRun && video.latest_run && tracks > 0) {
      lines.push(
        h(
          'p.small',
          reviewed >= tracks ? `All ${plural(tracks, 'track')} reviewed` : `${count(reviewed)} of ${plural(tracks, 'track')} reviewed`,
        ),
        meter(Math.min(1, reviewed / tracks), 'Reviewed', reviewed >= tracks),
      );
    } else if (!activeRun && video.latest_run && latestRun?.state === 'complete') {
      lines.push(
        h(
          'p.small.muted',
          latestRun.tracks
            ? 'Every track is deleted.'
            : latestRun.kind === 'imported'
              ? 'The run has no track yet.'
              : 'The run has found no sign.',
        ),
      );
    } else if (!activeRun && video.runs === 0) {
      lines.push(h('p.small.muted', 'Not run yet'));
    }
    for (const warning of video.warnings) lines.push(message('warn', warning));
  }
  return lines;
}

/** @param {'warn'|'bad'} tone @param {string} text @param {string} [title] */
function message(tone, text, title) {
  return h('p', { class: `card-message card-message-${tone} small`, title }, icon('alert'), h('span', text));
}

/**
 * @param {number|null} part   null: unknown
 * @param {string} label
 * @param {boolean} [good]
 */
function meter(part, label, good = false) {
  const element = createProgressBar(label);
  element.classList.toggle('meter-good', good);
  setProgress(element, part);
  return element;
}

/** @param {App} app @param {Video} video */
function actionsOf(app, video) {
  const openRuns = () => app.store.dispatch(openDialog, { kind: 'run', data: { video: video.id } });
  const { session } = app.store.get();
  const runsText = plural(video.runs, 'run');
  const isReady = video.state === 'ready';
  return [
    isReady &&
      video.latest_run &&
      h('a.btn.btn-primary', { href: reviewAddress(video.id), 'aria-label': `Review ${video.name}` }, icon('eye'), 'Review'),
    isReady && video.latest_run && h('button.btn', { onclick: openRuns, 'aria-label': `${runsText} of ${video.name}` }, runsText),
    isReady &&
      !video.latest_run &&
      h(
        'button.btn.btn-primary',
        { disabled: video.missing, onclick: openRuns, 'aria-label': `Run the engine on ${video.name}` },
        icon('run'),
        'Run the engine',
      ),
    video.state === 'failed' &&
      !video.missing &&
      h('button.btn', { onclick: () => retry(app, video), 'aria-label': `Import ${video.name} again` }, icon('refresh'), 'Import again'),
    h('span.grow'),
    isReady &&
      hasRole(session, 'reviewer') &&
      h(
        'button.btn.btn-quiet.btn-icon',
        {
          'aria-label': `Import annotations for ${video.name}`,
          title: 'Import annotations for this video …',
          onclick: () => app.store.dispatch(openDialog, { kind: 'import', data: { video: video.id } }),
        },
        icon('import'),
      ),
    hasRole(session, 'admin') &&
      h(
        'button.btn.btn-quiet.btn-icon',
        {
          'aria-label': `Remove ${video.name} from the library`,
          title: 'Remove from the library …',
          onclick: () => confirmRemoval(app, video),
        },
        icon('delete'),
      ),
  ];
}

/** @param {App} app @param {Video} video */
const retry = (app, video) => toastErrors(() => app.load(() => app.api.addVideo(video.path), putVideo));

/** @param {App} app @param {Video} video */
function confirmRemoval(app, video) {
  const { tracks, reviewed } = video.review;
  const reviewedText = reviewed ? ` (${reviewed} of ${plural(tracks, 'track')} reviewed)` : '';
  const lossText = `${plural(video.runs, 'run')}, all corrections and notes on ${video.runs === 1 ? 'it' : 'them'}${reviewedText}, and its ground truth`;
  app.store.dispatch(openDialog, {
    kind: 'confirm',
    data: {
      title: 'Remove this video?',
      text: video.runs
        ? `${video.name} will be removed from the library with ${lossText}. This cannot be undone.`
        : `${video.name} will be removed from the library.`,
      note: 'A file that was added from a folder stays where it is. The copy of an upload is deleted.',
      confirm: 'Remove',
      danger: true,
      run: async () => {
        await app.api.removeVideo(video.id);
        app.store.dispatch(dropVideo, video.id);
        toast(`${video.name} was removed.`);
      },
    },
  });
}
