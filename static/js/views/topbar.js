// @ts-check
/** The top bar: product, video and run, state of saving, theme, help. */

import { formatRoute, runAddress } from '../model/route.js';
import { listRuns } from '../model/run_groups.js';
import { openDialog, setTheme } from '../store/actions/page.js';
import { unsavedOf } from '../store/unsaved.js';
import { isActive } from './output_text.js';
import { runOperation } from '../operations/registry.js';
import { fill, h, returnFocusToPicture, setAttribute, setText } from './dom.js';
import { icon, isIcon } from './icons.js';
import { modelVersionSuffix } from './model_version_text.js';
import { createPerson } from './topbar_person.js';
import { runTitle } from '../model/describe_run.js';
import { toast } from '../core/toast.js';

/** @typedef {import('../page-types.js').App} App */
/** @typedef {import('../state-types.js').State} State */

const THEMES = /** @type {const} */ ({
  auto: ['light', 'Theme: same as the system'],
  light: ['dark', 'Theme: light'],
  dark: ['auto', 'Theme: dark'],
});

/** @type {import('../page-types.js').CreatePart} */
export function createTopBar(app) {
  const { store } = app;
  const videoSelect = h('select.select.topbar-video', {
    'aria-label': 'Video',
    onchange: () => {
      location.hash = formatRoute({ screen: 'review', video: videoSelect.value, run: null, frame: null, track: null });
    },
  });
  const runSelect = h('select.select.topbar-run', {
    'aria-label': 'Run',
    onchange: () => {
      const { route } = store.get();
      if (route.screen === 'review') location.hash = runAddress(store.get(), route.video, runSelect.value);
    },
  });
  const runsButton = h(
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
  const chooser = h('div.topbar-chooser.row', { hidden: true }, videoSelect, runSelect, runsButton, compare);
  const saveOperation = app.operations.find(({ id }) => id === 'save');
  const saveButton = h('button.btn.btn-quiet.saved', {
    title: saveOperation?.tooltip,
    onclick: () => saveOperation && runOperation(app, saveOperation, toast),
  });
  returnFocusToPicture(saveButton);
  // screen readers do not announce changes inside a button
  const announcement = h('span.visually-hidden', { role: 'status' });
  const theme = h('button.btn.btn-quiet.btn-icon', { onclick: () => store.dispatch((state) => setTheme(state, THEMES[state.theme][0])) });
  const [palette, settings, help] = ['palette', 'preferences', 'help'].map((id) => pageButton(app, id));
  const person = createPerson(app);
  const activeCount = h('span.nav-count', { hidden: true });
  const links = [
    h('a.nav-link', { href: '#/', dataset: { screen: 'library' } }, 'Library'),
    h(
      'a.nav-link',
      { href: '#/search', title: 'Find signs in all videos, and review or relabel many at once', dataset: { screen: 'search' } },
      'Search',
    ),
    h('a.nav-link', { href: '#/files', dataset: { screen: 'files' } }, 'Files', activeCount),
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
    saveButton,
    announcement,
    person.element,
    palette,
    theme,
    settings,
    help,
  );
  /** @type {Partial<State>} */ let lastState = {};

  return {
    element,
    update(state) {
      if (
        state.videos !== lastState.videos ||
        state.runs !== lastState.runs ||
        state.models !== lastState.models ||
        state.route !== lastState.route ||
        state.review?.run !== lastState.review?.run
      ) {
        showChooser(state, chooser, videoSelect, runSelect);
        for (const link of links) setAttribute(link, 'aria-current', link.dataset.screen === state.route.screen ? 'page' : null);
      }
      if (
        state.connection !== lastState.connection ||
        state.review?.unsaved !== lastState.review?.unsaved ||
        state.elsewhere !== lastState.elsewhere ||
        state.route !== lastState.route
      )
        showSaved(state, saveButton, announcement);
      if (state.outputs !== lastState.outputs) {
        const active = (state.outputs ?? []).filter(isActive).length;
        activeCount.hidden = active === 0;
        setText(activeCount, active);
        setAttribute(activeCount, 'title', active ? `${active} in progress` : null);
      }
      person.update(state);
      if (state.session !== lastState.session) links[links.length - 1].hidden = !state.session?.person;
      if (state.theme !== lastState.theme) {
        fill(theme, icon(state.theme === 'dark' ? 'moon' : state.theme === 'light' ? 'sun' : 'contrast'));
        theme.title = THEMES[state.theme][1];
        theme.setAttribute('aria-label', THEMES[state.theme][1]);
      }
      lastState = state;
    },
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

/** @param {State} state @param {HTMLElement} chooser @param {HTMLSelectElement} videoSelect @param {HTMLSelectElement} runSelect */
function showChooser(state, chooser, videoSelect, runSelect) {
  const { route } = state;
  chooser.hidden = route.screen !== 'review';
  if (route.screen !== 'review') return;
  setOptions(
    videoSelect,
    (state.videos ?? []).filter((video) => video.state === 'ready').map((video) => [video.id, video.name]),
    route.video,
    'not in the library',
  );
  const videoRuns = state.runs[route.video] ?? (state.review?.run ? [state.review.run] : []);
  setOptions(
    runSelect,
    listRuns(videoRuns).map(({ run, isWhatIf: under }) => [
      run.id,
      `${under ? '↳ ' : ''}${runTitle(run)}${modelVersionSuffix(run, state.models)}`,
    ]),
    state.review?.run?.id ?? route.run ?? '',
    'no longer exists',
  );
  runSelect.hidden = videoRuns.length === 0;
}

/**
 * @param {HTMLSelectElement} select
 * @param {[string, string][]} pairs   value, text
 * @param {string} chosen
 * @param {string} missingText   text for a chosen value that is not among them
 */
function setOptions(select, pairs, chosen, missingText) {
  if (chosen && pairs.length && !pairs.some(([value]) => value === chosen)) pairs = [[chosen, missingText], ...pairs];
  const isUnchanged =
    select.options.length === pairs.length &&
    pairs.every(([value, text], index) => select.options[index].value === value && select.options[index].text === text);
  // An open list must not change under the pointer without need.
  if (!isUnchanged) fill(select, ...pairs.map(([value, text]) => h('option', { value }, text)));
  if (select.value !== chosen) select.value = chosen;
  // in a narrow bar the name is truncated
  setAttribute(select, 'title', pairs.find(([value]) => value === chosen)?.[1] ?? null);
}

/** @param {State} state @param {HTMLElement} saveButton @param {HTMLElement} announcement */
function showSaved(state, saveButton, announcement) {
  const { unsaved, held } = unsavedOf(state);
  const offline = state.connection === 'offline';
  const kind = offline ? 'offline' : held ? 'held' : unsaved ? 'unsaved' : 'saved';
  saveButton.hidden = state.route.screen !== 'review' && !offline && unsaved === 0;
  const text = describeSaveState(offline, unsaved, held);
  setText(announcement, saveButton.hidden ? '' : text);
  if (saveButton.dataset.kind === kind && saveButton.textContent === text) return;
  saveButton.dataset.kind = kind;
  fill(saveButton, icon(ICONS[kind]), h('span', text));
}

/** @type {Record<'offline'|'held'|'unsaved'|'saved', import('./icons.js').IconName>} */
const ICONS = { offline: 'offline', held: 'alert', unsaved: 'refresh', saved: 'saved' };

/**
 * @param {boolean} offline
 * @param {number} unsaved   changes that the server has not confirmed
 * @param {number} held      those of them that need a decision
 */
export function describeSaveState(offline, unsaved, held) {
  if (offline) return unsaved ? `Offline, ${unsaved} to save` : 'Offline';
  if (held) return `${held} to decide on${unsaved > held ? `, saving ${unsaved - held} …` : ''}`;
  return unsaved ? `Saving ${unsaved} …` : 'All saved';
}
