// @ts-check
/** The frame of every screen: top bar, banners, the screen that the route names, dialogs, notices. */

import { createBanners } from './banners.js';
import { createCompare } from './compare.js';
import { createDialogs } from './dialogs/index.js';
import { h } from './dom.js';
import { createFiles } from './files.js';
import { createLabels } from './labels/index.js';
import { createLibrary } from './library.js';
import { createUploads } from './library_uploads.js';
import { createModels } from './models.js';
import { createReview } from './review.js';
import { createSearch } from './search/index.js';
import { createTeam } from './team.js';
import { createToasts } from './toasts.js';
import { createTooltip } from './tooltip.js';
import { createTopBar } from './topbar.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */
/** @typedef {import('../page-types.js').View} View */

/** @type {Record<import('../state-types.js').Route['screen'], {title: string, create: (app: App, uploads: ReturnType<typeof createUploads>) => View}>} */
const SCREENS = {
  library: { title: 'Library', create: createLibrary },
  review: { title: 'Review', create: createReview },
  search: { title: 'Search', create: createSearch },
  compare: { title: 'Compare', create: createCompare },
  models: { title: 'Models', create: createModels },
  files: { title: 'Files', create: createFiles },
  labels: { title: 'Labels', create: createLabels },
  team: { title: 'Team', create: createTeam },
};

/**
 * Put a theme on the page.
 *
 * @param {'light'|'dark'|'auto'} theme
 */
function applyTheme(theme) {
  const dark = theme === 'dark' || (theme === 'auto' && matchMedia('(prefers-color-scheme: dark)').matches);
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
}

/** @type {import('../page-types.js').CreatePart} */
export function createShell(app) {
  const topBar = createTopBar(app);
  const banners = createBanners(app);
  const dialogs = createDialogs(app);
  const toasts = createToasts(app);
  const uploads = createUploads(app);
  const main = h('main.screen', { id: 'main', tabIndex: -1 });
  const element = h('div.shell', topBar.element, banners.element, main, dialogs.element, toasts.element, createTooltip(app.signal));
  /** @type {{name: string, view: View}|null} */ let screen = null;
  /** @type {State['theme']|null} */ let theme = null;
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => theme && applyTheme(theme));

  /** @param {State} state */
  function showTheme(state) {
    if (state.theme === theme) return;
    theme = state.theme;
    applyTheme(theme);
  }

  /** @param {State} state */
  function showScreen(state) {
    const name = state.route.screen;
    if (screen?.name !== name) {
      const first = screen === null;
      screen?.view.destroy();
      const view = SCREENS[name].create(app, uploads);
      main.replaceChildren(view.element);
      screen = { name, view };
      // Screen readers and Tab start in the new screen; for the first screen the browser's own start is right.
      if (!first) main.focus({ preventScroll: true });
    }
    screen.view.update(state);
    const title = state.route.screen === 'review' && state.review ? state.review.video.name : SCREENS[name].title;
    if (document.title !== `${title} – tsr`) document.title = `${title} – tsr`;
  }

  return {
    element,
    update(state) {
      showTheme(state);
      topBar.update(state);
      banners.update(state);
      showScreen(state);
      dialogs.update(state);
      toasts.update(state);
    },
  };
}
