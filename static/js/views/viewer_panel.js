// @ts-check
/**
 * The views beside the picture: the recording in the Rerun viewer, and the 3-D view. Their modules are loaded on first
 * use.
 */

import { changeReview } from '../store/actions/review.js';
import { fill, h, setText } from './dom.js';
import { errorState, loadingState } from './placeholders.js';
import { icon } from './icons.js';

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
 * @param {(large: boolean) => void} resize   called when the panel takes the whole screen, and when it no longer does
 * @returns {View}
 */
export function createViewerPanel(app, resize) {
  const title = h('h2.beside-title.truncate');
  const grow = h(
    'button.btn.btn-quiet.btn-icon.btn-small',
    { 'aria-pressed': 'false', 'aria-label': 'Over the whole screen', title: 'Over the whole screen', onclick: () => enlarge(!large) },
    icon('fit'),
  );
  const place = h('div.beside-body');
  const element = h(
    'section.beside',
    { 'aria-label': 'Beside the picture', hidden: true },
    h(
      'header.beside-head',
      title,
      h('span.grow'),
      grow,
      h(
        'button.btn.btn-quiet.btn-icon.btn-small',
        {
          'aria-label': 'Close this view',
          title: 'Close this view',
          onclick: () => app.store.dispatch(changeReview, { beside: null }),
        },
        icon('close'),
      ),
    ),
    place,
  );
  /** @type {'recording'|'scene3d'|null} */
  let shown = null;
  /** @type {View|null} */
  let view = null;
  /** @type {State|null} */
  let last = null;
  let large = false;

  /** @param {boolean} value */
  function enlarge(value) {
    large = value;
    grow.setAttribute('aria-pressed', String(value));
    resize(value);
  }

  /** @param {'recording'|'scene3d'|null} kind */
  async function open(kind) {
    view?.destroy();
    view = null;
    shown = kind;
    element.hidden = kind === null;
    if (kind === null) {
      enlarge(false);
      fill(place);
      return;
    }
    setText(title, KINDS[kind].title);
    element.setAttribute('aria-label', KINDS[kind].title);
    fill(place, loadingState('Loading the view', { signal: app.signal }));
    try {
      const made = await KINDS[kind].create(app);
      if (shown !== kind) {
        made.destroy();
        return;
      }
      view = made;
      fill(place, made.element);
      if (last) made.update(last);
    } catch (thrown) {
      if (shown === kind)
        fill(
          place,
          errorState('The view cannot be shown', thrown, () => open(kind)),
        );
    }
  }

  return {
    element,
    update(state) {
      last = state;
      const kind = state.review?.beside ?? null;
      if (kind !== shown) void open(kind);
      else view?.update(state);
    },
    destroy() {
      shown = null;
      view?.destroy();
      element.remove();
    },
  };
}
