// @ts-check
/**
 * The views beside the picture: the recording in the Rerun viewer, and the 3-D view. Their modules are loaded on first
 * use.
 */

import { changeReview } from '../store/actions/review.js';
import { fill, h, setText } from './dom.js';
import { errorState, loadingState } from './placeholders.js';
import { iconButton } from './icons.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../page-types.js').View} View */
/** @typedef {import('../state-types.js').State} State */

/** @type {Record<'recording'|'scene3d', {title: string, create: (app: App) => Promise<View>}>} */
const KINDS = {
  recording: { title: 'Recording', create: async (app) => (await import('./recording/index.js')).createRecordingView(app) },
  scene3d: { title: '3-D view', create: async (app) => (await import('./scene3d/index.js')).createScene3dView(app) },
};

/**
 * @param {App} app
 * @param {(isEnlarged: boolean) => void} onResize   called when the panel takes the whole screen, and when it no longer does
 * @returns {View}
 */
export function createViewerPanel(app, onResize) {
  const title = h('h2.beside-title.truncate');
  const enlargeButton = iconButton('fit', 'Over the whole screen', () => setEnlarged(!isEnlarged));
  enlargeButton.setAttribute('aria-pressed', 'false');
  const container = h('div.beside-body');
  const element = h(
    'section.beside',
    { 'aria-label': 'Beside the picture', hidden: true },
    h(
      'header.beside-head',
      title,
      h('span.grow'),
      enlargeButton,
      iconButton('close', 'Close this view', () => app.store.dispatch(changeReview, { beside: null })),
    ),
    container,
  );
  /** @type {'recording'|'scene3d'|null} */ let shownKind = null;
  /** @type {View|null} */ let view = null;
  /** @type {State|null} */ let lastState = null;
  let isEnlarged = false;
  let latestRequest = 0;

  /** @param {boolean} value */
  function setEnlarged(value) {
    isEnlarged = value;
    enlargeButton.setAttribute('aria-pressed', String(value));
    onResize(value);
  }

  /** @param {'recording'|'scene3d'|null} kind */
  async function open(kind) {
    const request = ++latestRequest;
    view?.destroy();
    view = null;
    shownKind = kind;
    element.hidden = kind === null;
    if (kind === null) {
      setEnlarged(false);
      fill(container);
      return;
    }
    setText(title, KINDS[kind].title);
    element.setAttribute('aria-label', KINDS[kind].title);
    fill(container, loadingState('Loading the view', { signal: app.signal }));
    try {
      const created = await KINDS[kind].create(app);
      if (request !== latestRequest) {
        created.destroy();
        return;
      }
      view = created;
      fill(container, created.element);
      if (lastState) created.update(lastState);
    } catch (thrown) {
      if (request === latestRequest)
        fill(
          container,
          errorState('The view cannot be shown', thrown, () => open(kind)),
        );
    }
  }

  return {
    element,
    update(state) {
      lastState = state;
      const kind = state.review?.beside ?? null;
      if (kind !== shownKind) void open(kind);
      else view?.update(state);
    },
    destroy() {
      latestRequest += 1;
      view?.destroy();
    },
  };
}
