// @ts-check
/**
 * The 3-D view of the current run: viser's page in a frame, with the modes above it.
 *
 * Cursor and selection of the review screen are sent to it; a click on a block comes back as an event of the server,
 * which `main.js` passes on as `tsr:scene3d`. Without WebGL the scene is offered as a file.
 */

import { errorMessage } from '../../api/errors.js';
import { seek, select } from '../../store/actions/review.js';
import { fill, h } from '../dom.js';
import { emptyState, errorState, loadingState } from '../placeholders.js';
import { pollUntilFinished } from '../poll_output.js';
import { icon } from '../icons.js';
import { createScene3dApi } from './api.js';
import { createLatestSender } from '../latest_sender.js';

/** @typedef {import('../../state-types.js').State} State */
/** @typedef {import('./api.js').Mode} Mode */
/** @typedef {import('./api.js').SceneView} Space */

/** Interval of requests while a file is being made, ms. */
const POLL_INTERVAL_MS = 500;
/** @type {{id: Mode, title: string}[]} */
const MODES = [
  { id: 'volume', title: 'Space-time volume' },
  { id: 'prior', title: 'Spatial prior' },
  { id: 'drive', title: 'Metric drive' },
];

/** @param {import('../../page-types.js').App} app @param {{webgl?: () => boolean}} [setup] @returns {import('../../page-types.js').View} */
export function createScene3dView(app, { webgl = hasWebgl } = {}) {
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const api = createScene3dApi({ base: app.api.base, signal });
  /** Id of the run that is shown or being opened. @type {string|null} */
  let run = null;
  /** @type {Space|null} */ let scene3d = null;
  /** @type {Mode} */ let mode = 'volume';
  /** @type {State|null} */ let state = null;
  /** The last message, so that none is sent twice. */
  let sentKey = '';
  let isSaving = false;
  /** Whether the scene has not got the last message. */
  let hasFailed = false;

  const buttons = MODES.map(({ id, title }) => {
    const button = h('button.btn', { 'aria-pressed': 'false', dataset: { mode: id }, onclick: () => choose(id) }, title);
    return button;
  });
  const saveButton = h(
    'button.btn',
    { title: 'One HTML file that needs no server and no network', onclick: () => void saveScene() },
    icon('saved'),
    'Save as file',
  );
  const notice = h('p.scene3d-notice.small', { role: 'status' });
  const body = h('div.scene3d-body');
  const element = h(
    'div.scene3d',
    h('div.scene3d-bar', h('div.scene3d-modes', { role: 'group', 'aria-label': 'Scene' }, ...buttons), saveButton, notice),
    body,
  );
  updateButtons();

  const cursorSender = createLatestSender(
    async (/** @type {{run: string, cursor: import('./api.js').Cursor}} */ { run: id, cursor }) => {
      await api.move(id, cursor);
      if (hasFailed) fill(notice);
      hasFailed = false;
    },
    {
      onError: (thrown) => {
        if (signal.aborted) return;
        fill(notice, errorMessage(thrown));
        hasFailed = true;
        sentKey = ''; // sent again with the next change, if the sender does not repeat it
      },
    },
  );

  addEventListener(
    'tsr:scene3d',
    (event) => {
      const { detail } = /** @type {CustomEvent} */ (event);
      if (!scene3d || detail?.view !== scene3d.view) return;
      if (detail.mode) {
        mode = detail.mode;
        updateButtons();
        sentKey = cursorKey();
      }
      if (detail.track) {
        app.store.dispatch((now) => seek(select(now, detail.track), detail.frame));
        sentKey = cursorKey();
      }
    },
    { signal },
  );

  function updateButtons() {
    for (const button of buttons) button.setAttribute('aria-pressed', String(button.dataset.mode === mode));
  }

  /** @param {Mode} to */
  function choose(to) {
    mode = to;
    updateButtons();
    sendCursor();
  }

  /** Whether the view is visible; a hidden view does nothing. */
  const isVisible = () => element.isConnected && element.getClientRects().length > 0;

  /** @param {string} id */
  async function open(id) {
    run = id;
    scene3d = null;
    sentKey = '';
    fill(notice);
    if (!webgl()) {
      offerFile(
        'Without WebGL the browser cannot draw in three dimensions',
        'Enable hardware acceleration in its settings, or save the scene as a file and open it in another browser.',
      );
      return;
    }
    fill(body, loadingState('Opening the 3-D view', { signal, retry: () => void open(id) }));
    try {
      const found = await api.scene3d(id, null);
      if (run !== id || signal.aborted) return;
      scene3d = found;
      sendCursor();
      const frame = h('iframe.scene3d-frame', {
        src: found.url,
        title: 'Scene in three dimensions',
        allow: 'fullscreen',
        referrerpolicy: 'no-referrer',
      });
      frame.addEventListener('load', () => {
        if (run === id && isCoarse(frame)) fill(notice, 'No graphics card is used here, so the scene is coarser and slower.');
      });
      fill(body, frame);
    } catch (thrown) {
      if (run !== id || signal.aborted) return;
      fill(
        body,
        errorState('The 3-D view cannot be opened', thrown, () => open(id)),
      );
    }
  }

  /** @param {string} title @param {string} text */
  function offerFile(title, text) {
    fill(
      body,
      emptyState({
        icon: 'box',
        title,
        text,
        actions: [h('button.btn.btn-primary', { onclick: () => void saveScene() }, icon('saved'), 'Save the scene as a file')],
      }),
    );
  }

  const cursorKey = () => {
    const review = app.store.get().review;
    return review ? `${review.frame}/${review.selected}/${mode}` : '';
  };

  function sendCursor() {
    const review = app.store.get().review;
    if (!scene3d || run === null || !review) return;
    const nextKey = cursorKey();
    if (nextKey === sentKey) return;
    sentKey = nextKey;
    cursorSender.push({ run, cursor: { frame: review.frame, track: review.selected, view: scene3d.view, mode } });
  }

  async function saveScene() {
    const review = app.store.get().review;
    if (isSaving || !review?.run) return;
    isSaving = true;
    saveButton.disabled = true;
    fill(notice, 'Making the file …');
    try {
      const startedFile = await api.save(review.run.id, { mode, frame: review.frame, track: review.selected });
      const file = await pollUntilFinished(startedFile, api.file, { intervalMs: POLL_INTERVAL_MS, isAbandoned: () => signal.aborted });
      if (file === null) return;
      if (file.state === 'complete') fill(notice, 'Saved: ', h('a', { href: api.fileUrl(file.id), download: '' }, file.name));
      else fill(notice, file.error ?? 'The file was not made.');
    } catch (thrown) {
      if (!signal.aborted) fill(notice, errorMessage(thrown));
    } finally {
      isSaving = false;
      saveButton.disabled = false;
    }
  }

  return {
    element,
    update(next) {
      state = next;
      const id = state.review?.run?.id ?? null;
      if (!isVisible()) return;
      saveButton.hidden = id === null;
      if (id === null) {
        if (run !== null || !body.firstChild) {
          run = null;
          scene3d = null;
          fill(body, emptyState({ icon: 'box', title: 'No run yet', text: 'Track the video first: the scenes are made from a run.' }));
        }
      } else if (id !== run) {
        void open(id);
      } else {
        sendCursor();
      }
    },
    destroy() {
      lifetime.abort();
      cursorSender.stop();
    },
  };
}

/** @returns {boolean} */
function hasWebgl() {
  const canvas = document.createElement('canvas');
  try {
    return (canvas.getContext('webgl2') ?? canvas.getContext('webgl')) !== null;
  } catch {
    return false;
  }
}

/**
 * Whether the page in a frame draws without a graphics card; app/scene3d/page.py then limits its pixels.
 *
 * @param {HTMLIFrameElement} frame
 */
function isCoarse(frame) {
  return new URLSearchParams(frame.contentWindow?.location.search).has('fixedDpr');
}
