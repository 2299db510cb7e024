// @ts-check
/** The command palette: search of commands, controls of the screen, labels, tracks and settings. */

import { nextIndex } from '../../model/list_keys.js';
import { engineName, offeredLabels } from '../../model/labels.js';
import { findItems, prepareItems } from '../../model/palette.js';
import { trackEntries } from '../../model/track_entries.js';
import { needsTrack, onReview } from '../../operations/helpers.js';
import { openTrack } from '../../operations/navigate.js';
import { runOperation } from '../../operations/registry.js';
import { setLabel } from '../../operations/verdicts.js';
import { h, reconcile, setText } from '../dom.js';
import { count, frameSpan } from '../../model/format.js';
import { toast } from '../../core/toast.js';
import { keyHint } from './help.js';
import { controlsOf } from './command_palette_controls.js';

/** @typedef {import('../../page-types.js').App} App */
/** @typedef {import('../../state-types.js').State} State */
/** @typedef {{id: string, text: string, also?: string, kind: string, key: string, reason: string|null, run: () => void}} Item */

/** Maximum length of the list; typing finds the rest. */
const MAX_ITEMS = 60;

/**
 * All items that can be found now: commands, then controls of the screen, labels, and tracks in the order of the run.
 * @param {App} app
 * @param {State} state
 * @param {ReturnType<typeof controlsOf>} [controls]
 * @returns {Item[]}
 */
function paletteItems(app, state, controls = []) {
  /** @type {Item[]} */
  const commands = app.operations
    .filter((operation) => operation.id !== 'palette' && operation.available(state))
    .flatMap((operation) => {
      const { id, label, tooltip, group, keys, each = false } = operation;
      const common = { also: `${tooltip} ${group}`, kind: group, reason: operation.disabled(state) };
      if (!each) return [{ ...common, id, text: label, key: keys[0] ?? '', run: () => runOperation(app, operation, toast) }];
      return keys.map((key) => ({
        ...common,
        id: `${id}-${key}`,
        text: `${label}: ${key.slice(-1)}`,
        key,
        run: () => runOperation(app, operation, toast, key),
      }));
    });
  const commandTexts = new Set(commands.map(({ text }) => text.replace(/ …$/, '')));
  commands.push(
    ...controls.filter(({ text }) => !commandTexts.has(text)).map((control, index) => ({ ...control, id: `control-${index}`, key: '' })),
  );
  const { review, labels } = state;
  if (review === null || !onReview(state)) return commands;
  const reason = needsTrack(state);
  const labelItems = offeredLabels(labels).map((label) => ({
    id: `label-${label.id}`,
    text: label.name,
    also: [label.key, ...label.aliases, 'label relabel'].join(' '),
    kind: 'Label',
    key: label.pinned === null ? '' : `Ctrl+${label.pinned}`,
    reason,
    run: () => setLabel(app, label),
  }));
  const trackItems = trackEntries(review.tracks, review.docs).map((entry) => ({
    id: `track-${entry.key}`,
    text: `Track ${entry.name} · ${engineName(labels, entry.class_id, entry.word)}`,
    also: String(entry.track ?? ''),
    kind: `Frames ${frameSpan(entry.first, entry.last)}`,
    key: '',
    reason: null,
    run: () => openTrack(app, entry.key),
  }));
  return [...commands, ...labelItems, ...trackItems];
}

/** Controls of the screen, and the runs in the bar above it. @param {State} state */
function screenControls({ route }) {
  const screen = route.screen.replace(/^./, (first) => first.toUpperCase());
  return ['#main', '.topbar-chooser'].flatMap((part) => {
    const shown = document.querySelector(part);
    return shown instanceof HTMLElement ? controlsOf(shown, screen) : [];
  });
}

/** @type {import('./index.js').CreateDialog<'palette'>} */
export function commandPaletteDialog({ app, close, signal }) {
  const items = prepareItems(paletteItems(app, app.store.get(), screenControls(app.store.get())));
  /** @type {Item[]} */ let shownItems = [];
  let markedIndex = 0;
  const list = h('ul.palette-list', { role: 'listbox', id: 'palette-list', 'aria-label': 'Found' });
  const statusText = h('p.muted.small.palette-told', { role: 'status' });
  const search = h('input.input', {
    type: 'text',
    role: 'combobox',
    autocomplete: 'off',
    spellcheck: 'false',
    maxlength: 200,
    placeholder: 'Command, label, track or setting',
    'aria-label': 'Find',
    'aria-expanded': 'true',
    'aria-controls': 'palette-list',
    'aria-autocomplete': 'list',
    oninput: show,
  });

  function show() {
    const { found: matching, total } = findItems(items, search.value, MAX_ITEMS);
    shownItems = matching;
    markedIndex = 0;
    reconcile(list, shownItems, ({ id }) => id, createRow);
    setText(
      statusText,
      total === 0
        ? 'Nothing found. Try fewer letters.'
        : total > shownItems.length
          ? `The first ${count(shownItems.length)} of ${count(total)}; type to find the rest.`
          : '',
    );
    markRow();
  }

  /** @param {Item} item */
  function createRow(item) {
    return h(
      'li.palette-item',
      { role: 'option', id: `palette-${item.id}`, 'aria-disabled': item.reason === null ? null : 'true', onclick: () => runItem(item) },
      h('span.palette-text', { dir: 'auto' }, item.text, item.reason && h('span.muted.small.palette-reason', item.reason)),
      h('span.muted.small.palette-kind', item.kind),
      item.key && keyHint(item.key),
    );
  }

  function markRow() {
    for (const row of list.querySelectorAll('[aria-selected="true"]')) row.setAttribute('aria-selected', 'false');
    const row = list.children[markedIndex];
    row?.setAttribute('aria-selected', 'true');
    if (row) search.setAttribute('aria-activedescendant', row.id);
    else search.removeAttribute('aria-activedescendant');
    row?.scrollIntoView({ block: 'nearest' });
  }

  /** @param {Item|undefined} item */
  function runItem(item) {
    if (!item) return;
    if (item.reason !== null) {
      setText(statusText, `${item.text}: ${item.reason}`);
      return;
    }
    // after the palette has closed: a command may open a dialog or move the focus
    signal.addEventListener('abort', () => app.signal.aborted || setTimeout(item.run), { once: true });
    close();
  }

  search.addEventListener('keydown', (event) => {
    const next = nextIndex(event.key, markedIndex, shownItems.length, { page: 10, isInTextField: true });
    if (next !== null) {
      event.preventDefault();
      markedIndex = next;
      markRow();
    } else if (event.key === 'Enter') {
      event.preventDefault();
      runItem(shownItems[markedIndex]);
    } else if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'k') {
      event.preventDefault();
      close();
    }
  });
  show();

  return { title: 'Find anything', size: 'middle', focus: search, body: h('div.palette', search, list, statusText) };
}
