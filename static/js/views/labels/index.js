// @ts-check
/** The screen of label sets and their labels. */

import { labelFinder } from '../../model/label_finder.js';
import { offeredLabels } from '../../model/labels.js';
import { openDialog } from '../../store/actions/page.js';
import { fill, h, setText } from '../dom.js';
import { errorState, loadingState } from '../placeholders.js';
import { count, plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { toast } from '../../core/toast.js';
import { toastErrors } from '../toast_errors.js';
import { createLabelTable } from './table.js';

/** @typedef {import('../../types.js').Label} Label */

/** @type {import('../../page-types.js').CreateView} */
export function createLabels(app) {
  const { store, api } = app;
  const lifetime = new AbortController();
  const signal = AbortSignal.any([lifetime.signal, app.signal]);
  /** The shown set; null: not loaded yet. @type {{key: string, version: number, labels: Label[], usage: import('../../types.js').LabelUsage|null}|null} */
  let shown = null;
  /** Key of the requested set. */
  let requestedSet = '';
  /** @type {number|null} */ let selected = null;
  let latestRequest = 0;
  /** @type {readonly import('../../types.js').LabelSetSummary[]|null} */ let heads = null;

  const setSelect = h('select.select', { 'aria-label': 'Label set', onchange: () => void load(setSelect.value) });
  const useButton = h(
    'button.btn',
    { hidden: true, title: 'Use this set for all videos without a set of their own', onclick: () => void useForAll() },
    'Use for the library',
  );
  const totalText = h('span.muted', { role: 'status' });
  const search = h('input.input', {
    type: 'search',
    placeholder: 'Name, key, alias or #number',
    'aria-label': 'Search labels',
    oninput: show,
  });
  const hiddenCheckbox = h('input', { type: 'checkbox', onchange: show });
  const hiddenText = h('span');
  const editButton = h('button.btn', { title: 'Change the selected label (Enter)', onclick: () => openLabel(current()) }, 'Edit');
  const mergeButton = h(
    'button.btn',
    {
      title: 'Merge the selected label into another one; its tracks then count as the other label',
      onclick: () => {
        const label = current();
        if (label)
          dialog((set) => ({
            kind: 'label-merge',
            data: { ...set, label },
          }));
      },
    },
    icon('merge'),
    'Merge into …',
  );
  const hideButton = h('button.btn', { onclick: () => void toggleHidden() });
  const table = createLabelTable({
    onChoose: (label) => {
      selected = label.id;
      showActions();
    },
    onOpen: openLabel,
  });
  const notice = h('div.library-notice', loadingState('Loading the labels', { retry: () => load(requestedSet), signal }));
  const emptyText = h('p.muted', { role: 'status' });
  const element = h(
    'div.labels-page',
    h(
      'div.labels-head',
      h('h1', 'Labels'),
      setSelect,
      useButton,
      totalText,
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
      h('label.tick', hiddenCheckbox, hiddenText),
      h('div.grow'),
      editButton,
      mergeButton,
      hideButton,
    ),
    notice,
    table.element,
    emptyText,
  );

  /** Offer to use a set for the library unless it does. @param {string} key */
  function offerForLibrary(key) {
    useButton.hidden = heads?.find((head) => head.key === key)?.default !== false;
  }

  const current = () => shown?.labels.find(({ id }) => id === selected) ?? null;

  /** @param {(set: {set: string, labels: Label[], usage: import('../../types.js').LabelUsage|null}) => import('../../state-types.js').Dialog} of */
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
    const { key } = shown;
    await toastErrors(async () => {
      const { sentence } = await app.labels.change({ type: label.hidden ? 'show' : 'hide', id: label.id }, key);
      toast(sentence, { tone: 'good' });
    }, signal);
  }

  const useForAll = () =>
    toastErrors(async () => {
      await api.setDefaultLabelSet(requestedSet, { signal });
      await app.labels.reload();
      toast('Videos without a set of their own now use this one.', { tone: 'good' });
    }, signal);

  /** @param {string} key */
  async function load(key) {
    const request = ++latestRequest;
    if (key !== requestedSet) selected = null;
    requestedSet = key;
    offerForLibrary(key);
    if (key === '') {
      await app.labels.reload().catch(failed);
      return;
    }
    try {
      const version = heads?.find((head) => head.key === key)?.version ?? 0;
      const labels = await api.labelsOfSet(key, { signal });
      if (request !== latestRequest) return;
      shown = { key, version, labels, usage: shown?.key === key ? shown.usage : null };
      notice.hidden = true;
      show();
    } catch (thrown) {
      if (request === latestRequest) failed(thrown);
      return;
    }
    try {
      const usage = await api.labelUsage(key, { signal });
      if (request !== latestRequest || !shown) return;
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
      errorState('The labels could not be listed', thrown, () => load(requestedSet)),
    );
  }

  function show() {
    if (!shown) return;
    const { labels, usage } = shown;
    const offered = offeredLabels(labels);
    const found = labelFinder(labels).search(search.value, hiddenCheckbox.checked ? labels : offered);
    setText(totalText, search.value.trim() === '' ? plural(offered.length, 'label') : `${count(found.length)} found`);
    setText(hiddenText, `Show hidden and merged (${labels.length - offered.length})`);
    setText(
      emptyText,
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
    editButton.disabled = label === null;
    mergeButton.disabled = hideButton.disabled = label === null || label.merged_into !== null;
    setText(hideButton, label?.hidden ? 'Show again' : 'Hide');
    hideButton.title =
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
      const key = heads.some((head) => head.key === requestedSet)
        ? requestedSet
        : (heads.find((head) => head.default)?.key ?? heads[0]?.key ?? '');
      fill(setSelect, ...heads.map((head) => h('option', { value: head.key }, `${head.name}${head.default ? ' · the library’s' : ''}`)));
      setSelect.value = key;
      offerForLibrary(key);
      if (key !== shown?.key || heads.find((head) => head.key === key)?.version !== shown?.version) void load(key);
    },
    destroy() {
      lifetime.abort();
      table.destroy();
    },
  };
}
