// @ts-check
/** The screen of all files that were made from runs: exports, recordings, bug bundles, 3-D pages. */

import { openDialog, setOutputs, setVideos } from '../store/actions/page.js';
import { createOutputRow } from './output_row.js';
import { KINDS } from './output_text.js';
import { h, reconcile, selectInput, setText } from './dom.js';
import { emptyState, errorState, loadingState } from './placeholders.js';
import { bytes, plural } from '../model/format.js';
import { icon } from './icons.js';
import { recall, remember } from '../core/preferences.js';
import { pageHeading } from './headings.js';
import { loadMissingRuns } from './load_runs.js';

/** @typedef {import('../types.js').Output} Output */

/** @type {import('../page-types.js').CreateView} */
export function createFiles(app) {
  const { store, api } = app;
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  const kindSelect = selectInput(
    {
      'aria-label': 'Kind of file',
      onchange: () => {
        remember('files.kind', kindSelect.value);
        show();
      },
    },
    [['', 'All kinds'], ...Object.entries(KINDS).map(([value, { pluralName }]) => /** @type {const} */ ([value, pluralName]))],
    recall('files.kind') ?? '',
  );
  if (kindSelect.selectedIndex < 0) kindSelect.value = '';
  const totalText = h('span.muted');
  const list = h('ul.made-list', { 'aria-label': 'Files' });
  const notice = h('div.library-notice', loadingState('Loading the files', { retry: load, signal }));
  const element = h(
    'div.library',
    h(
      'div.library-inner.page-inner',
      pageHeading(
        'Files',
        totalText,
        kindSelect,
        h('button.btn', { onclick: () => store.dispatch(openDialog, { kind: 'import-bundle' }) }, icon('bug'), 'Open bug bundle'),
        h('button.btn', { onclick: () => store.dispatch(openDialog, { kind: 'export' }) }, icon('export'), 'Export'),
      ),
      notice,
      list,
    ),
  );
  /** @type {WeakMap<HTMLElement, ReturnType<typeof createOutputRow>>} */ const rows = new WeakMap();
  /** The title of the notice; empty: it waits, or shows an error. */
  let noticeTitle = '';

  async function load() {
    try {
      await app.load(() => api.outputs({}, { signal }), setOutputs);
      if (store.get().videos === null) await app.load(() => api.videos({ signal }), setVideos);
      for (const video of store.get().videos ?? []) {
        if (video.runs > 0) await loadMissingRuns(app, video.id, { signal });
      }
    } catch (thrown) {
      if (signal.aborted) return;
      noticeTitle = '';
      notice.hidden = false;
      notice.replaceChildren(errorState('The files could not be listed', thrown, () => load()));
    }
  }

  function show() {
    const { outputs } = store.get();
    if (outputs === null) return;
    const listed = kindSelect.value ? outputs.filter((output) => output.kind === kindSelect.value) : outputs;
    const size = listed.reduce((sum, output) => sum + (output.size ?? 0), 0);
    setText(totalText, listed.length ? `${plural(listed.length, 'file')}, ${bytes(size)}` : '');
    reconcile(
      list,
      listed,
      ({ id }) => id,
      (output) => {
        const row = createOutputRow(app, output);
        rows.set(row.element, row);
        return row.element;
      },
      (item, output) => rows.get(item)?.show(output),
    );
    list.hidden = listed.length === 0;
    notice.hidden = listed.length > 0;
    if (listed.length > 0) return;
    const kind = kindSelect.value ? KINDS[/** @type {Output['kind']} */ (kindSelect.value)].pluralName.toLowerCase() : 'files';
    const title = `No ${kind} yet`;
    if (title === noticeTitle) return;
    noticeTitle = title;
    notice.replaceChildren(
      emptyState({
        icon: 'folder',
        title,
        text: 'Exports, recordings, bug bundles and 3-D pages are listed here for download or removal.',
        actions: [
          h(
            'button.btn.btn-primary',
            { onclick: () => store.dispatch(openDialog, { kind: 'export' }) },
            icon('export'),
            'Export annotations',
          ),
        ],
      }),
    );
  }

  void load();
  /** @type {import('../state-types.js').State|null} */ let lastState = null;
  return {
    element,
    update(state) {
      if (lastState?.outputs !== state.outputs || lastState?.runs !== state.runs || lastState?.videos !== state.videos) show();
      lastState = state;
    },
    destroy: () => lifetime.abort(),
  };
}
