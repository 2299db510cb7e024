// @ts-check
/**
 * A search field and the labels that match it: arrows move, Enter takes. Shared by all dialogs that ask for a label.
 */

import { labelFinder } from '../../model/label_finder.js';
import { h, reconcile, setText } from '../dom.js';
import { pictureThatMayMiss, showPicture } from '../pictures.js';

/** @typedef {import('../../types.js').Label} Label */

/** Maximum length of the list; typing finds the rest. */
const MOST = 500;
/** Rows drawn per frame: the first ones fill the dialog at once, and 400 labels cause no pause. */
const SLICE = 24;

/**
 * @param {object} setup
 * @param {(label: Label) => void} setup.take
 * @param {(label: Label) => string} [setup.aside]   text after a label's name
 * @param {(text: string) => {text: string, run: () => void}|null} [setup.last]   a last row for the typed text
 * @param {string} setup.placeholder
 * @param {number} [setup.columns]
 */
export function createLabelChoice({ take, aside = () => '', last = () => null, placeholder, columns = 2 }) {
  /** @type {readonly Label[]} */ let labels = [];
  /** @type {readonly Label[]} */ let offered = [];
  /** @type {Label[]} */ let found = [];
  /** @type {{text: string, run: () => void}|null} */ let further = null;
  let present = 0;
  let at = 0;
  let untouched = true;
  const list = h('ul', { class: `labels`, role: 'listbox', id: 'labels', 'aria-label': 'Labels' });
  const none = h('p.muted.labels-none', { role: 'status' });
  const more = h('li.label.label-add', { role: 'option', id: 'label-add', hidden: true, onclick: () => further?.run() });
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
      at = search.value.trim() ? 0 : present;
      untouched = false;
      show();
    },
  });

  /** Drawn rows by label, for reuse while typing. @type {Map<number, HTMLElement>} */
  const rows = new Map();

  /** @param {Label} label */
  function create(label) {
    const row = rows.get(label.id) ?? makeRow(label);
    rows.set(label.id, row);
    return row;
  }

  /** @param {Label} label */
  function makeRow(label) {
    return h(
      'li.label',
      {
        role: 'option',
        id: `label-${label.id}`,
        onclick: () => {
          const now = found.find(({ id }) => id === label.id);
          if (now) take(now);
        },
      },
      pictureThatMayMiss({ class: 'label-picture', width: 32, height: 32, loading: 'lazy', decoding: 'async' }),
      h('span.label-id.muted.small', label.id),
      h('span.truncate.grow', { dir: 'auto' }),
      h('kbd.label-key'),
      h('span.muted.small.label-aside'),
    );
  }

  /** @param {HTMLElement} row @param {Label} label */
  function fillRow(row, label) {
    const [picture, , name, key, beside] = /** @type {HTMLElement[]} */ ([...row.children]);
    showPicture(/** @type {HTMLImageElement} */ (picture), label.picture);
    setText(name, label.name);
    row.title = [label.name, label.key, ...label.aliases].join('\n');
    key.hidden = label.pinned === null;
    setText(key, label.pinned === null ? '' : `Ctrl+${label.pinned}`);
    setText(beside, aside(label));
  }

  function show() {
    const all = labelFinder(labels).search(search.value, offered);
    found = all.slice(0, MOST);
    further = last(search.value.trim());
    more.hidden = further === null;
    setText(more, further?.text ?? '');
    draw(Math.max(SLICE, at + 1));
    mark();
    const hidden = all.length - found.length;
    setText(
      none,
      labels.length === 0
        ? 'The labels are not loaded yet.'
        : found.length === 0 && further === null
          ? 'No label has that name. Try fewer letters.'
          : hidden > 0
            ? `${hidden} more; type to find them.`
            : '',
    );
  }

  let later = 0;

  /** Draw the first rows now and the rest in the following frames. @param {number} count */
  function draw(count) {
    cancelAnimationFrame(later);
    reconcile(list, found.slice(0, count), ({ id }) => String(id), create, fillRow);
    list.append(more);
    if (count < found.length) later = requestAnimationFrame(() => draw(count + SLICE));
  }

  /** @type {Element|null} */
  let marked = null;

  function mark() {
    if (at < found.length && at >= list.childElementCount - 1) draw(at + 1);
    const row = at < 0 ? null : at < found.length ? (list.children[at] ?? null) : further ? more : null;
    if (marked !== row) marked?.setAttribute('aria-selected', 'false');
    marked = row;
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
      at = Math.max(0, Math.min(found.length - (further ? 0 : 1), at < 0 ? 0 : at + step));
      untouched = false;
      mark();
    } else if (event.key === 'Enter') {
      event.preventDefault();
      if (untouched) enter();
      else takeMarked();
    } else if ((event.ctrlKey || event.metaKey) && !event.altKey && !event.shiftKey && /^[1-9]$/.test(event.key)) {
      const pinned = offered.find((label) => label.pinned === Number(event.key));
      if (!pinned) return;
      event.preventDefault();
      take(pinned);
    }
  });

  function takeMarked() {
    const label = found[at];
    if (label) take(label);
    else if (at === found.length) further?.run();
  }

  /** The effect of Enter before any typing or move. */
  let enter = takeMarked;

  return {
    search,
    list,
    none,
    /** @param {() => void} other   the effect of Enter before any typing or move */
    onEnter: (other) => {
      enter = other;
    },
    /**
     * @param {readonly Label[]} known       the whole set; must not be changed later
     * @param {readonly Label[]} some        the labels on offer, in their order
     * @param {number} at_                   index of the present label; -1: none
     */
    offer(known, some, at_) {
      const before = found[at]?.id;
      [labels, offered, present] = [known, some, at_];
      if (untouched) at = present;
      show();
      if (!untouched && before !== undefined) {
        const place = found.findIndex(({ id }) => id === before);
        if (place >= 0) at = place;
        mark();
      }
    },
    /** Scroll to the marked row. Deferred, because the list has no height before the dialog is open. */
    reveal: () => requestAnimationFrame(mark),
  };
}
