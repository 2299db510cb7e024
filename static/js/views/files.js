// @ts-check
/** The screen of all files that were made from runs: exports, recordings, bug bundles, 3-D pages. */

import { openDialog, setOutputs, setRuns } from '../store/actions/page.js';
import { createOutputRow } from './output_row.js';
import { KINDS } from './output_text.js';
import { h, reconcile, setText } from './dom.js';
import { emptyState, errorState, loadingState } from './placeholders.js';
import { bytes, plural } from '../model/format.js';
import { icon } from './icons.js';
import { recall, remember } from '../core/preferences.js';
import { pageHeading } from './headings.js';

/** @typedef {import('../types.js').Output} Output */

/**
 * @param {import('../page-types.js').App} app
 * @returns {import('../page-types.js').View}
 */
export function createFiles(app) {
  const { store, api } = app;
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  const kind = h(
    'select.select',
    {
      'aria-label': 'Kind of file',
      onchange: () => {
        remember('files.kind', kind.value);
        show();
      },
    },
    h('option', { value: '' }, 'All kinds'),
    ...Object.entries(KINDS).map(([value, { many }]) => h('option', { value }, many)),
  );
  kind.value = recall('files.kind') ?? '';
  if (kind.selectedIndex < 0) kind.value = '';
  const total = h('span.muted');
  const list = h('ul.made-list', { 'aria-label': 'Files' });
  const notice = h('div.library-notice', loadingState('Loading the files', { retry: load, signal }));
  const element = h(
    'div.library',
    h(
      'div.library-inner.page-inner',
      pageHeading(
        'Files',
        total,
        kind,
        h('button.btn', { onclick: () => store.dispatch(openDialog, { kind: 'import-bundle' }) }, icon('bug'), 'Open bug bundle'),
        h('button.btn', { onclick: () => store.dispatch(openDialog, { kind: 'export' }) }, icon('export'), 'Export'),
      ),
      notice,
      list,
    ),
  );
  /** @type {WeakMap<HTMLElement, ReturnType<typeof createOutputRow>>} */
  const rows = new WeakMap();
  /** @type {Output[]|null} */
  let shown = null;
  let noticed = 'waiting';

  async function load() {
    try {
      await app.load(() => api.outputs({}, { signal }), setOutputs);
      for (const video of store.get().videos ?? []) {
        if (store.get().runs[video.id] || video.runs === 0) continue;
        await app.load(
          () => api.runs(video.id, { signal }),
          (state, runs) => setRuns(state, video.id, runs),
        );
      }
    } catch (thrown) {
      if (signal.aborted) return;
      noticed = 'error';
      notice.hidden = false;
      notice.replaceChildren(errorState('The files could not be listed', thrown, () => load()));
    }
  }

  function show() {
    const { outputs } = store.get();
    if (outputs === null) return;
    const found = kind.value ? outputs.filter((one) => one.kind === kind.value) : outputs;
    const size = found.reduce((sum, one) => sum + (one.size ?? 0), 0);
    setText(total, found.length ? `${plural(found.length, 'file')}, ${bytes(size)}` : '');
    reconcile(
      list,
      found,
      ({ id }) => id,
      (output) => {
        const row = createOutputRow(app, output);
        rows.set(row.element, row);
        return row.element;
      },
      (item, output) => rows.get(item)?.show(output),
    );
    list.hidden = found.length === 0;
    notice.hidden = found.length > 0;
    const now = found.length ? 'none' : kind.value ? 'kind' : 'empty';
    if (now === noticed) return;
    noticed = now;
    if (now !== 'none') {
      notice.replaceChildren(
        emptyState({
          icon: 'folder',
          title: now === 'kind' ? `No ${KINDS[/** @type {Output['kind']} */ (kind.value)].many.toLowerCase()} yet` : 'No files yet',
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
  }

  void load();
  /** @type {import('../state-types.js').State|null} */
  let last = null;
  return {
    element,
    update(state) {
      if (last && last.outputs === state.outputs && last.runs === state.runs && last.videos === state.videos && shown === state.outputs)
        return;
      [last, shown] = [state, state.outputs];
      show();
    },
    destroy() {
      ended.abort();
      element.remove();
    },
  };
}
