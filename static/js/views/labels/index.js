// @ts-check
/** The screen of label sets and their labels. */

import { sentence } from '../../api/errors.js';
import { labelFinder } from '../../model/label_finder.js';
import { offeredLabels } from '../../model/labels.js';
import { openDialog } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { failure, waiting } from '../empty.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { toast } from '../../core/toast.js';
import { createTable } from './table.js';

/** @typedef {import('../../types.js').Label} Label */

/**
 * @param {import('../../page-types.js').App} app
 * @returns {import('../../page-types.js').View}
 */
export function createLabels(app) {
  const { store, api } = app;
  const ended = new AbortController();
  const signal = AbortSignal.any([ended.signal, app.signal]);
  /** The shown set; null: not loaded yet. @type {{key: string, version: number, labels: Label[], usage: import('./table.js').Usage}|null} */
  let shown = null;
  /** Key of the requested set. */
  let wanted = '';
  /** @type {number|null} */ let selected = null;
  let asked = 0;
  /** @type {readonly import('../../types.js').LabelSetSummary[]|null} */
  let heads = null;

  const sets = h('select.select', { 'aria-label': 'Label set', onchange: () => void load(sets.value) });
  const use = h(
    'button.btn',
    { hidden: true, title: 'Use this set for all videos without a set of their own', onclick: () => void useForAll() },
    'Use for the library',
  );
  const total = h('span.muted', { role: 'status' });
  const search = h('input.input', {
    type: 'search',
    placeholder: 'Name, key, alias or #number',
    'aria-label': 'Search labels',
    oninput: show,
  });
  const hidden = h('input', { type: 'checkbox', onchange: show });
  const hiddenText = h('span');
  const edit = h('button.btn', { title: 'Change the selected label (Enter)', onclick: () => openLabel(current()) }, 'Edit');
  const merge = h(
    'button.btn',
    {
      title: 'Merge the selected label into another one; its tracks then count as the other label',
      onclick: () => {
        const label = current();
        if (label)
          dialog((set) => ({
            kind: 'label-merge',
            data: { ...set, label, usage: set.usage && (set.usage[String(label.id)] ?? { tracks: 0, videos: 0 }) },
          }));
      },
    },
    icon('merge'),
    'Merge into …',
  );
  const hide = h('button.btn', { onclick: () => void toggleHidden() });
  const table = createTable({
    signal,
    choose: (label) => {
      selected = label.id;
      showActions();
    },
    open: openLabel,
  });
  const notice = h('div.library-notice', waiting('Loading the labels', { retry: () => load(wanted), signal }));
  const none = h('p.muted', { role: 'status' });
  const element = h(
    'div.labels-page',
    h(
      'div.labels-head',
      h('h1', 'Labels'),
      sets,
      use,
      total,
      h('div.grow'),
      h(
        'button.btn',
        { title: 'Who changed what and when; undo a change', onclick: () => dialog((set) => ({ kind: 'label-history', data: set })) },
        icon('undo'),
        'History',
      ),
      h(
        'button.btn',
        {
          title: 'Import labels from a file or another set, or save this set as a file',
          onclick: () => dialog((set) => ({ kind: 'label-files', data: set })),
        },
        icon('import'),
        'Files',
      ),
      h('button.btn.btn-primary', { onclick: () => openLabel(null) }, icon('add'), 'Add a label'),
    ),
    h(
      'div.labels-head',
      h('div.input-with-icon.library-search', icon('search'), search),
      h('label.tick', hidden, hiddenText),
      h('div.grow'),
      edit,
      merge,
      hide,
    ),
    notice,
    table.element,
    none,
  );

  const current = () => shown?.labels.find(({ id }) => id === selected) ?? null;

  /** @param {(set: {set: string, labels: Label[], usage: import('./table.js').Usage}) => import('../../state-types.js').Dialog} of */
  function dialog(of) {
    if (shown === null) return;
    const { key: set, labels, usage } = shown;
    store.dispatch(openDialog, of({ set, labels, usage }));
  }

  /** @param {Label|null} label   null: a new one */
  function openLabel(label) {
    dialog((set) => ({ kind: 'label', data: { ...set, label } }));
  }

  async function toggleHidden() {
    const label = current();
    if (!label || !shown) return;
    try {
      const { sentence: said } = await app.labels.change({ type: label.hidden ? 'show' : 'hide', id: label.id }, shown.key);
      toast(said, { tone: 'good' });
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad' });
    }
  }

  async function useForAll() {
    try {
      await api.setDefaultLabelSet(wanted, { signal });
      await app.labels.reload();
      toast('Videos without a set of their own now use this one.', { tone: 'good' });
    } catch (thrown) {
      if (!signal.aborted) toast(sentence(thrown), { tone: 'bad' });
    }
  }

  /** @param {string} key */
  async function load(key) {
    const mine = ++asked;
    if (key !== wanted) selected = null;
    wanted = key;
    if (key === '') {
      await app.labels.reload().catch(failed);
      return;
    }
    try {
      const version = heads?.find((head) => head.key === key)?.version ?? 0;
      const labels = await api.labelsOfSet(key, { signal });
      if (mine !== asked) return;
      shown = { key, version, labels, usage: shown?.key === key ? shown.usage : null };
      notice.hidden = true;
      show();
    } catch (thrown) {
      if (mine === asked) failed(thrown);
      return;
    }
    try {
      const usage = await api.labelUsage(key, { signal });
      if (mine !== asked || !shown) return;
      shown = { ...shown, usage };
      show();
    } catch {
      // the table shows that usage is not known
    }
  }

  /** @param {unknown} thrown */
  function failed(thrown) {
    if (signal.aborted) return;
    notice.hidden = false;
    fill(
      notice,
      failure('The labels could not be listed', thrown, () => load(wanted)),
    );
  }

  function show() {
    if (!shown) return;
    const { labels, usage } = shown;
    const offered = offeredLabels(labels);
    const found = labelFinder(labels).search(search.value, hidden.checked ? labels : offered);
    setText(total, search.value.trim() === '' ? plural(offered.length, 'label') : `${count(found.length)} found`);
    setText(hiddenText, `Show hidden and merged (${labels.length - offered.length})`);
    setText(
      none,
      found.length > 0
        ? ''
        : labels.length === 0
          ? 'The set has no label yet. Add one, or import some under Files.'
          : 'No label has that name. Hidden and merged labels are shown only if selected above.',
    );
    table.show(labels, found, usage, selected);
    showActions();
  }

  function showActions() {
    const label = current();
    edit.disabled = label === null;
    merge.disabled = hide.disabled = label === null || label.merged_into !== null;
    setText(hide, label?.hidden ? 'Show again' : 'Hide');
    hide.title =
      label?.merged_into != null
        ? 'It was merged; undo that in the history'
        : label?.hidden
          ? 'Offer the label again'
          : 'Stop offering the label; tracks that have it keep it';
  }

  showActions();
  return {
    element,
    update(state) {
      if (state.labelSets === heads || state.labelSets === null) return;
      heads = state.labelSets;
      const key = heads.some((head) => head.key === wanted) ? wanted : (heads.find((head) => head.default)?.key ?? heads[0]?.key ?? '');
      fill(sets, ...heads.map((head) => h('option', { value: head.key }, `${head.name}${head.default ? ' · the library’s' : ''}`)));
      sets.value = key;
      use.hidden = heads.find((head) => head.key === key)?.default !== false;
      if (key !== shown?.key || heads.find((head) => head.key === key)?.version !== shown?.version) void load(key);
    },
    destroy() {
      ended.abort();
      table.destroy();
      element.remove();
    },
  };
}
