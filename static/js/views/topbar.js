// @ts-check
/** The top bar: product, video and run, state of saving, theme, help. */

import { formatRoute } from '../model/route.js';
import { listRuns } from '../model/run_groups.js';
import { openDialog, setTheme } from '../store/actions/page.js';
import { unsavedOf } from '../store/unsaved.js';
import { isActive } from './output-words.js';
import { runOperation } from '../operations/registry.js';
import { fill, h, leaveKeysToPicture, setAttribute, setText } from './dom.js';
import { icon, isIcon } from './icons.js';
import { modelsTag } from './model-words.js';
import { createPerson } from './topbar-person.js';
import { runTitle } from '../model/describe_run.js';
import { toast } from '../core/toast.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

const THEMES = /** @type {const} */ ({
  auto: ['light', 'Theme: same as the system'],
  light: ['dark', 'Theme: light'],
  dark: ['auto', 'Theme: dark'],
});

/**
 * @param {App} app
 * @returns {import('../page-types.js').View}
 */
export function createTopBar(app) {
  const { store } = app;
  const videos = h('select.select.topbar-video', {
    'aria-label': 'Video',
    onchange: () => {
      location.hash = formatRoute({ screen: 'review', video: videos.value, run: null, frame: null, track: null });
    },
  });
  const runs = h('select.select.topbar-run', {
    'aria-label': 'Run',
    onchange: () => {
      const route = store.get().route;
      if (route.screen === 'review') location.hash = formatRoute({ ...route, run: runs.value, track: null });
    },
  });
  const manage = h(
    'button.btn',
    {
      title: 'Start a run, see the runs of this video, remove them',
      onclick: () => {
        const { route } = store.get();
        if (route.screen === 'review') store.dispatch(openDialog, { kind: 'run', data: { video: route.video } });
      },
    },
    icon('run'),
    h('span.topbar-words', 'Runs'),
  );
  const compare = h(
    'button.btn',
    {
      title: 'Compare this run with another, with its corrections or with ground truth',
      onclick: () => {
        const { route, review } = store.get();
        if (route.screen === 'review')
          store.dispatch(openDialog, { kind: 'compare', data: { video: route.video, run: review?.run?.id ?? route.run } });
      },
    },
    icon('compare'),
    h('span.topbar-words', 'Compare'),
  );
  const chooser = h('div.topbar-chooser.row', { hidden: true }, videos, runs, manage, compare);
  const save = app.operations.find(({ id }) => id === 'save');
  const saved = h('button.btn.btn-quiet.saved', { title: save?.tooltip, onclick: () => save && runOperation(app, save, toast) });
  leaveKeysToPicture(saved);
  // screen readers do not announce changes inside a button
  const spoken = h('span.visually-hidden', { role: 'status' });
  const theme = h('button.btn.btn-quiet.btn-icon', { onclick: () => store.dispatch((state) => setTheme(state, THEMES[state.theme][0])) });
  const [palette, settings, help] = ['palette', 'preferences', 'help'].map((id) => pageButton(app, id));
  const person = createPerson(app);
  const making = h('span.nav-count', { hidden: true });
  const links = [
    h('a.nav-link', { href: '#/', dataset: { screen: 'library' } }, 'Library'),
    h(
      'a.nav-link',
      { href: '#/search', title: 'Find signs in all videos, and judge or relabel many at once', dataset: { screen: 'search' } },
      'Search',
    ),
    h('a.nav-link', { href: '#/files', dataset: { screen: 'files' } }, 'Files', making),
    h('a.nav-link', { href: '#/labels', dataset: { screen: 'labels' } }, 'Labels'),
    h('a.nav-link', { href: '#/models', dataset: { screen: 'models' } }, 'Models'),
    h('a.nav-link', { href: '#/team', dataset: { screen: 'team' }, hidden: true }, 'Team'),
  ];
  const element = h(
    'header.topbar',
    h(
      'a.brand',
      { href: '#/', title: 'To the library' },
      h('img.brand-mark', { src: '/static/icon.svg', alt: '', width: 20, height: 20 }),
      h('span.topbar-words', 'tsr review'),
    ),
    h('nav.topbar-nav', { 'aria-label': 'Screens' }, ...links),
    chooser,
    h('div.grow'),
    saved,
    spoken,
    person.element,
    palette,
    theme,
    settings,
    help,
  );
  /** @type {Partial<State>} */
  let last = {};

  return {
    element,
    update(state) {
      if (
        state.videos !== last.videos ||
        state.runs !== last.runs ||
        state.models !== last.models ||
        state.route !== last.route ||
        state.review?.run !== last.review?.run
      ) {
        showChooser(state, chooser, videos, runs);
        for (const link of links) setAttribute(link, 'aria-current', link.dataset.screen === state.route.screen ? 'page' : null);
      }
      if (
        state.connection !== last.connection ||
        state.review?.unsaved !== last.review?.unsaved ||
        state.elsewhere !== last.elsewhere ||
        state.route !== last.route
      )
        showSaved(state, saved, spoken);
      if (state.outputs !== last.outputs) {
        const busy = (state.outputs ?? []).filter(isActive).length;
        making.hidden = busy === 0;
        setText(making, busy);
        setAttribute(making, 'title', busy ? `${busy} in progress` : null);
      }
      person.update(state);
      if (state.session !== last.session) links[links.length - 1].hidden = !state.session?.person;
      if (state.theme !== last.theme) {
        fill(theme, icon(state.theme === 'dark' ? 'moon' : state.theme === 'light' ? 'sun' : 'contrast'));
        theme.title = THEMES[state.theme][1];
        theme.setAttribute('aria-label', THEMES[state.theme][1]);
      }
      last = state;
    },
    destroy: () => element.remove(),
  };
}

/** A button for an operation of the whole page. @param {App} app @param {string} id */
function pageButton(app, id) {
  const operation = app.operations.find((one) => one.id === id);
  if (!operation?.icon || !isIcon(operation.icon)) throw new RangeError(`There is no operation ${id} with an icon.`);
  return h(
    'button.btn.btn-quiet.btn-icon',
    { 'aria-label': operation.label, title: operation.tooltip, onclick: () => runOperation(app, operation) },
    icon(operation.icon),
  );
}

/**
 * @param {State} state
 * @param {HTMLElement} chooser
 * @param {HTMLSelectElement} videos
 * @param {HTMLSelectElement} runs
 */
function showChooser(state, chooser, videos, runs) {
  const { route } = state;
  chooser.hidden = route.screen !== 'review';
  if (route.screen !== 'review') return;
  options(
    videos,
    (state.videos ?? []).filter((video) => video.state === 'ready').map((video) => [video.id, video.name]),
    route.video,
    'not in the library',
  );
  const own = state.runs[route.video] ?? (state.review?.run ? [state.review.run] : []);
  options(
    runs,
    listRuns(own).map(({ run, isWhatIf: under }) => [run.id, `${under ? '↳ ' : ''}${runTitle(run)}${modelsTag(run, state.models)}`]),
    state.review?.run?.id ?? route.run ?? '',
    'no longer exists',
  );
  runs.hidden = own.length === 0;
}

/**
 * @param {HTMLSelectElement} select
 * @param {[string, string][]} pairs   value, text
 * @param {string} chosen
 * @param {string} absent   text for a chosen value that is not among them
 */
function options(select, pairs, chosen, absent) {
  if (chosen && pairs.length && !pairs.some(([value]) => value === chosen)) pairs = [[chosen, absent], ...pairs];
  const same =
    select.options.length === pairs.length &&
    pairs.every(([value, text], at) => select.options[at].value === value && select.options[at].text === text);
  // An open list must not change under the pointer without need.
  if (!same) fill(select, ...pairs.map(([value, text]) => h('option', { value }, text)));
  if (select.value !== chosen) select.value = chosen;
  // in a narrow bar the name is truncated
  setAttribute(select, 'title', pairs.find(([value]) => value === chosen)?.[1] ?? null);
}

/**
 * @param {State} state
 * @param {HTMLElement} saved
 * @param {HTMLElement} spoken
 */
function showSaved(state, saved, spoken) {
  const { unsaved, held } = unsavedOf(state);
  const offline = state.connection === 'offline';
  const kind = offline ? 'offline' : held ? 'held' : unsaved ? 'unsaved' : 'saved';
  saved.hidden = state.route.screen !== 'review' && !offline && unsaved === 0;
  const text = savedWords(offline, unsaved, held);
  setText(spoken, saved.hidden ? '' : text);
  if (saved.dataset.kind === kind && saved.textContent === text) return;
  saved.dataset.kind = kind;
  fill(saved, icon(ICONS[kind]), h('span', text));
}

/** @type {Record<'offline'|'held'|'unsaved'|'saved', import('./icons.js').IconName>} */
const ICONS = { offline: 'offline', held: 'alert', unsaved: 'refresh', saved: 'saved' };

/**
 * @param {boolean} offline
 * @param {number} unsaved   changes that the server has not confirmed
 * @param {number} held      those of them that need a decision
 */
export function savedWords(offline, unsaved, held) {
  if (offline) return unsaved ? `Offline, ${unsaved} to save` : 'Offline';
  if (held) return `${held} to decide on${unsaved > held ? `, saving ${unsaved - held} …` : ''}`;
  return unsaved ? `Saving ${unsaved} …` : 'All saved';
}
