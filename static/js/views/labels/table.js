// @ts-check
/** The labels of a set as a grid. Only visible rows exist. */

import { nextIndex } from '../../model/list_keys.js';
import { labelsById } from '../../model/labels.js';
import { h, setAttribute, setText } from '../dom.js';
import { count } from '../../model/format.js';
import { pictureThatMayMiss, showPicture } from '../pictures.js';

/** @typedef {import('../../types.js').Label} Label */
/** @typedef {Record<string, {tracks: number, videos: number}>|null} Usage */

const COLUMNS = ['', 'Key', 'Name', 'Short', 'Aliases', 'Shape', 'Category', 'Attributes', 'Training', 'Tracks'];
/** Rows kept above and below the visible ones. */
const SPARE = 6;
/** Height of a row, in units. */
const ROW = 11;

/** Why a label is not on offer. @param {Label} label @param {readonly Label[]} labels */
const away = (label, labels) =>
  label.merged_into !== null ? `merged into ${labelsById(labels).get(label.id)?.name}` : label.hidden ? 'hidden' : '';

/**
 * @param {{choose: (label: Label) => void, open: (label: Label) => void, signal: AbortSignal}} setup   choose: select a label; open: open its form
 */
export function createTable({ choose, open, signal }) {
  const body = h('div.label-rows', { role: 'rowgroup' });
  const scroller = h(
    'div.label-scroller',
    { role: 'grid', tabIndex: 0, 'aria-label': 'Labels of the set' },
    h(
      'div.label-row.label-heads',
      { role: 'row' },
      ...COLUMNS.map((text) =>
        h(
          'span',
          { role: 'columnheader', title: text === 'Tracks' ? 'Tracks that people have given the label' : text },
          text || h('span.visually-hidden', 'Picture'),
        ),
      ),
    ),
    body,
  );
  /** @type {readonly Label[]} */ let labels = [];
  /** @type {readonly Label[]} */ let shown = [];
  /** @type {Usage} */ let usage = null;
  /** @type {number|null} */ let selected = null;
  /** @type {Map<number, ReturnType<typeof createRow>>} */ const rows = new Map();
  let height = 44;
  let scheduled = 0;

  function later() {
    if (scheduled === 0) scheduled = requestAnimationFrame(draw);
  }

  function draw() {
    scheduled = 0;
    height = Math.round((Number.parseFloat(getComputedStyle(scroller).getPropertyValue('--u')) || 4) * ROW);
    body.style.setProperty('height', `${shown.length * height}px`);
    const first = Math.max(0, Math.floor(scroller.scrollTop / height) - SPARE);
    const last = Math.min(shown.length, Math.ceil((scroller.scrollTop + scroller.clientHeight) / height) + SPARE);
    const wanted = new Set(shown.slice(first, last).map(({ id }) => id));
    for (const [id, row] of rows) {
      if (wanted.has(id)) continue;
      row.element.remove();
      rows.delete(id);
    }
    for (let place = first; place < last; place += 1) {
      const label = shown[place];
      let row = rows.get(label.id);
      if (!row) {
        row = createRow(label.id);
        rows.set(label.id, row);
        body.append(row.element);
      }
      row.update(label, labels, usage, { place, height, selected: label.id === selected });
    }
    setAttribute(scroller, 'aria-rowcount', shown.length + 1);
    setAttribute(scroller, 'aria-activedescendant', selected !== null && rows.has(selected) ? `label-row-${selected}` : null);
  }

  /** @param {Label} label */
  function go(label) {
    selected = label.id;
    const top = shown.indexOf(label) * height;
    const head = /** @type {HTMLElement} */ (scroller.firstElementChild).offsetHeight;
    if (top < scroller.scrollTop) scroller.scrollTop = top;
    else if (top + height + head > scroller.scrollTop + scroller.clientHeight)
      scroller.scrollTop = top + height + head - scroller.clientHeight;
    choose(label);
    later();
  }

  const labelAt = (/** @type {Event} */ event) => {
    const row = /** @type {HTMLElement} */ (event.target).closest('[data-id]');
    return row instanceof HTMLElement ? shown.find(({ id }) => String(id) === row.dataset.id) : undefined;
  };
  body.addEventListener(
    'click',
    (event) => {
      const label = labelAt(event);
      if (label) go(label);
    },
    { signal },
  );
  body.addEventListener(
    'dblclick',
    (event) => {
      const label = labelAt(event);
      if (label) open(label);
    },
    { signal },
  );
  scroller.addEventListener(
    'keydown',
    (event) => {
      const at = shown.findIndex(({ id }) => id === selected);
      const next = nextIndex(event.key, at, shown.length, { page: Math.max(1, Math.floor(scroller.clientHeight / height) - 2) });
      if (event.key === 'Enter' && at >= 0) open(shown[at]);
      else if (next !== null) go(shown[next]);
      else return;
      event.preventDefault();
      event.stopPropagation();
    },
    { signal },
  );
  scroller.addEventListener('scroll', later, { signal, passive: true });
  const observer = new ResizeObserver(later);
  observer.observe(scroller);

  return {
    element: scroller,
    /**
     * @param {readonly Label[]} all
     * @param {readonly Label[]} some    the labels to show, in order
     * @param {Usage} used               null: not known yet
     * @param {number|null} chosen       id of the selected label
     */
    show(all, some, used, chosen) {
      [labels, shown, usage, selected] = [all, some, used, chosen];
      later();
    },
    destroy() {
      observer.disconnect();
      cancelAnimationFrame(scheduled);
    },
  };
}

/** @param {number} id */
function createRow(id) {
  const picture = pictureThatMayMiss({ class: 'label-picture', loading: 'lazy', decoding: 'async', width: 32, height: 32 });
  const cells = COLUMNS.slice(1).map(() => h('span.truncate', { role: 'gridcell', dir: 'auto' }));
  const element = h(
    'div.label-row',
    { role: 'row', id: `label-row-${id}`, dataset: { id: String(id) } },
    h('span', { role: 'gridcell' }, picture),
    ...cells,
  );
  return {
    element,
    /**
     * @param {Label} label
     * @param {readonly Label[]} labels
     * @param {Usage} usage
     * @param {{place: number, height: number, selected: boolean}} view
     */
    update(label, labels, usage, { place, height, selected }) {
      element.style.setProperty('transform', `translateY(${place * height}px)`);
      element.style.setProperty('height', `${height}px`);
      setAttribute(element, 'aria-rowindex', place + 2);
      setAttribute(element, 'aria-selected', String(selected));
      const gone = away(label, labels);
      element.classList.toggle('label-away', gone !== '');
      showPicture(picture, label.picture);
      const used = usage?.[String(label.id)];
      const texts = [
        label.key,
        label.name + (label.pinned === null ? '' : ` · Ctrl+${label.pinned}`) + (gone && ` · ${gone}`),
        label.short,
        label.aliases.join(', '),
        label.shape,
        label.category,
        label.attributes.map(({ name }) => name).join(', '),
        { sign: 'sign', background: 'background', ignore: 'nothing' }[label.teach],
        usage === null ? '–' : count(used?.tracks ?? 0),
      ];
      cells.forEach((cell, at) => {
        setText(cell, texts[at]);
        setAttribute(cell, 'title', texts[at]);
      });
    },
  };
}
