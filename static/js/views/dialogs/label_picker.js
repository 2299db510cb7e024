// @ts-check
/**
 * A search field and the labels that match it: arrows move, Enter takes. Shared by all dialogs that ask for a label.
 */

import { labelFinder } from '../../model/label_finder.js';
import { h, reconcile, setText } from '../dom.js';
import { imageWithPlaceholder, setImageSource } from '../images.js';

/** @typedef {import('../../types.js').Label} Label */

/** Maximum length of the list; typing finds the rest. */
const MAX_ROWS = 500;
/** Rows drawn per frame: the first ones fill the dialog at once, and 400 labels cause no pause. */
const ROWS_PER_FRAME = 24;

/**
 * @param {object} setup
 * @param {(label: Label) => void} setup.onPick
 * @param {(label: Label) => string} [setup.noteAfterName]   text after a label's name
 * @param {(text: string) => {text: string, run: () => void}|null} [setup.furtherRow]   a last row for the typed text
 * @param {string} setup.placeholder
 * @param {number} [setup.columns]
 */
export function createLabelPicker({ onPick, noteAfterName = () => '', furtherRow = () => null, placeholder, columns = 2 }) {
  /** @type {readonly Label[]} */ let labels = [];
  /** @type {readonly Label[]} */ let offered = [];
  /** @type {Label[]} */ let matching = [];
  /** @type {{text: string, run: () => void}|null} */ let extraRow = null;
  let presentIndex = 0;
  let markedIndex = 0;
  let isUntouched = true;
  const list = h('ul', { class: `labels`, role: 'listbox', id: 'labels', 'aria-label': 'Labels' });
  const emptyText = h('p.muted.labels-none', { role: 'status' });
  const extraRowElement = h('li.label.label-add', { role: 'option', id: 'label-add', hidden: true, onclick: () => extraRow?.run() });
  const search = h('input.input', {
    type: 'text',
    role: 'combobox',
    autocomplete: 'off',
    spellcheck: 'false',
    placeholder,
    maxlength: 200,
    'aria-label': 'Label',
    'aria-expanded': 'true',
    'aria-controls': 'labels',
    'aria-autocomplete': 'list',
    oninput: () => {
      markedIndex = search.value.trim() ? 0 : presentIndex;
      isUntouched = false;
      show();
    },
  });

  /** Drawn rows by label, for reuse while typing. @type {Map<number, HTMLElement>} */
  const rows = new Map();

  /** @param {Label} label */
  function reusedRow(label) {
    const row = rows.get(label.id) ?? createRow(label);
    rows.set(label.id, row);
    return row;
  }

  /** @param {Label} label */
  function createRow(label) {
    return h(
      'li.label',
      {
        role: 'option',
        id: `label-${label.id}`,
        onclick: () => {
          const currentLabel = matching.find(({ id }) => id === label.id);
          if (currentLabel) onPick(currentLabel);
        },
      },
      imageWithPlaceholder({ class: 'label-picture', width: 32, height: 32, loading: 'lazy', decoding: 'async' }),
      h('span.label-id.muted.small', label.id),
      h('span.truncate.grow', { dir: 'auto' }),
      h('kbd.label-key'),
      h('span.muted.small.label-aside'),
    );
  }

  /** @param {HTMLElement} row @param {Label} label */
  function fillRow(row, label) {
    const [picture, , name, key, noteElement] = /** @type {HTMLElement[]} */ ([...row.children]);
    setImageSource(/** @type {HTMLImageElement} */ (picture), label.picture);
    setText(name, label.name);
    row.title = [label.name, label.key, ...label.aliases].join('\n');
    key.hidden = label.pinned === null;
    setText(key, label.pinned === null ? '' : `Ctrl+${label.pinned}`);
    setText(noteElement, noteAfterName(label));
  }

  function show() {
    const matches = labelFinder(labels).search(search.value, offered);
    matching = matches.slice(0, MAX_ROWS);
    extraRow = furtherRow(search.value.trim());
    extraRowElement.hidden = extraRow === null;
    setText(extraRowElement, extraRow?.text ?? '');
    draw(Math.max(ROWS_PER_FRAME, markedIndex + 1));
    markRow();
    const hidden = matches.length - matching.length;
    setText(
      emptyText,
      labels.length === 0
        ? 'The labels are not loaded yet.'
        : matching.length === 0 && extraRow === null
          ? 'No label has that name. Try fewer letters.'
          : hidden > 0
            ? `${hidden} more; type to find them.`
            : '',
    );
  }

  let drawRequest = 0;

  /** Draw the first rows now and the rest in the following frames. @param {number} rowCount */
  function draw(rowCount) {
    cancelAnimationFrame(drawRequest);
    reconcile(list, matching.slice(0, rowCount), ({ id }) => String(id), reusedRow, fillRow);
    list.append(extraRowElement);
    if (rowCount < matching.length) drawRequest = requestAnimationFrame(() => draw(rowCount + ROWS_PER_FRAME));
  }

  /** @type {Element|null} */ let markedRow = null;

  function markRow() {
    if (markedIndex < matching.length && markedIndex >= list.childElementCount - 1) draw(markedIndex + 1);
    const row =
      markedIndex < 0 ? null : markedIndex < matching.length ? (list.children[markedIndex] ?? null) : extraRow ? extraRowElement : null;
    if (markedRow !== row) markedRow?.setAttribute('aria-selected', 'false');
    markedRow = row;
    row?.setAttribute('aria-selected', 'true');
    if (row) search.setAttribute('aria-activedescendant', row.id);
    else search.removeAttribute('aria-activedescendant');
    row?.scrollIntoView({ block: 'nearest' });
  }

  search.addEventListener('keydown', (event) => {
    const steps = /** @type {Record<string, number>} */ ({ ArrowDown: columns, ArrowUp: -columns, PageDown: 10, PageUp: -10 });
    // Left and right move in the list only if they do not move in the text.
    if (!search.value) Object.assign(steps, { ArrowRight: 1, ArrowLeft: -1 });
    const step = steps[event.key];
    if (step !== undefined) {
      event.preventDefault();
      markedIndex = Math.max(0, Math.min(matching.length - (extraRow ? 0 : 1), markedIndex < 0 ? 0 : markedIndex + step));
      isUntouched = false;
      markRow();
    } else if (event.key === 'Enter') {
      event.preventDefault();
      if (isUntouched) onEnter();
      else pickMarked();
    } else if ((event.ctrlKey || event.metaKey) && !event.altKey && !event.shiftKey && /^[1-9]$/.test(event.key)) {
      const pinned = offered.find((label) => label.pinned === Number(event.key));
      if (!pinned) return;
      event.preventDefault();
      onPick(pinned);
    }
  });

  function pickMarked() {
    const label = matching[markedIndex];
    if (label) onPick(label);
    else if (markedIndex === matching.length) extraRow?.run();
  }

  /** The effect of Enter before any typing or move. */
  let onEnter = pickMarked;

  return {
    search,
    list,
    emptyText,
    /** @param {() => void} action   the effect of Enter before any typing or move */
    onEnter: (action) => {
      onEnter = action;
    },
    /**
     * @param {readonly Label[]} allLabels       the whole set; must not be changed later
     * @param {readonly Label[]} offeredLabels   the labels on offer, in their order
     * @param {number} index                     index of the present label; -1: none
     */
    offer(allLabels, offeredLabels, index) {
      const markedId = matching[markedIndex]?.id;
      [labels, offered, presentIndex] = [allLabels, offeredLabels, index];
      if (isUntouched) markedIndex = presentIndex;
      show();
      if (!isUntouched && markedId !== undefined) {
        const newIndex = matching.findIndex(({ id }) => id === markedId);
        if (newIndex >= 0) markedIndex = newIndex;
        markRow();
      }
    },
    /** Scroll to the marked row. Deferred, because the list has no height before the dialog is open. */
    reveal: () => requestAnimationFrame(markRow),
  };
}
