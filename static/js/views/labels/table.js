// @ts-check
/** The labels of a set as a grid. Only visible rows exist. */

import { nextIndex } from '../../model/list_keys.js';
import { labelsById } from '../../model/labels.js';
import { h, setAttribute, setText } from '../dom.js';
import { count } from '../../model/format.js';
import { imageWithPlaceholder, setImageSource } from '../images.js';

/** @typedef {import('../../types.js').Label} Label */
/** @typedef {import('../../types.js').LabelUsage|null} Usage */

const COLUMNS = ['', 'Key', 'Name', 'Short', 'Aliases', 'Shape', 'Category', 'Attributes', 'Training', 'Tracks'];
/** Rows kept above and below the visible ones. */
const SPARE_ROWS = 6;
/** Height of a row, in units. */
const ROW_HEIGHT_UNITS = 11;

/** Why a label is not on offer. @param {Label} label @param {readonly Label[]} labels */
const unavailableReason = (label, labels) =>
  label.merged_into !== null ? `merged into ${labelsById(labels).get(label.id)?.name}` : label.hidden ? 'hidden' : '';

/** @param {{onChoose: (label: Label) => void, onOpen: (label: Label) => void}} setup   onChoose: select a label; onOpen: open its form */
export function createLabelTable({ onChoose, onOpen }) {
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
          { role: 'columnheader', title: text === 'Tracks' ? 'Tracks with the label in the current run of each video' : text },
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

  function scheduleDraw() {
    if (scheduled === 0) scheduled = requestAnimationFrame(draw);
  }

  function draw() {
    scheduled = 0;
    height = Math.round((Number.parseFloat(getComputedStyle(scroller).getPropertyValue('--u')) || 4) * ROW_HEIGHT_UNITS);
    body.style.setProperty('height', `${shown.length * height}px`);
    const first = Math.max(0, Math.floor(scroller.scrollTop / height) - SPARE_ROWS);
    const last = Math.min(shown.length, Math.ceil((scroller.scrollTop + scroller.clientHeight) / height) + SPARE_ROWS);
    const visibleIds = new Set(shown.slice(first, last).map(({ id }) => id));
    for (const [id, row] of rows) {
      if (visibleIds.has(id)) continue;
      row.element.remove();
      rows.delete(id);
    }
    for (let index = first; index < last; index += 1) {
      const label = shown[index];
      let row = rows.get(label.id);
      if (!row) {
        row = createRow(label.id);
        rows.set(label.id, row);
        body.append(row.element);
      }
      row.update(label, labels, usage, { place: index, height, selected: label.id === selected });
    }
    setAttribute(scroller, 'aria-rowcount', shown.length + 1);
    setAttribute(scroller, 'aria-activedescendant', selected !== null && rows.has(selected) ? `label-row-${selected}` : null);
  }

  /** @param {Label} label */
  function selectLabel(label) {
    selected = label.id;
    const top = shown.indexOf(label) * height;
    const head = /** @type {HTMLElement} */ (scroller.firstElementChild).offsetHeight;
    if (top < scroller.scrollTop) scroller.scrollTop = top;
    else if (top + height + head > scroller.scrollTop + scroller.clientHeight)
      scroller.scrollTop = top + height + head - scroller.clientHeight;
    onChoose(label);
    scheduleDraw();
  }

  const labelAt = (/** @type {Event} */ event) => {
    const row = /** @type {HTMLElement} */ (event.target).closest('[data-id]');
    return row instanceof HTMLElement ? shown.find(({ id }) => String(id) === row.dataset.id) : undefined;
  };
  body.addEventListener('click', (event) => {
    const label = labelAt(event);
    if (label) selectLabel(label);
  });
  body.addEventListener('dblclick', (event) => {
    const label = labelAt(event);
    if (label) onOpen(label);
  });
  scroller.addEventListener('keydown', (event) => {
    const at = shown.findIndex(({ id }) => id === selected);
    const next = nextIndex(event.key, at, shown.length, { page: Math.max(1, Math.floor(scroller.clientHeight / height) - 2) });
    if (event.key === 'Enter' && at >= 0) onOpen(shown[at]);
    else if (next !== null) selectLabel(shown[next]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  scroller.addEventListener('scroll', scheduleDraw, { passive: true });
  const observer = new ResizeObserver(scheduleDraw);
  observer.observe(scroller);

  return {
    element: scroller,
    /**
     * @param {readonly Label[]} allLabels
     * @param {readonly Label[]} shownLabels   the labels to show, in order
     * @param {Usage} usageByLabel             null: not known yet
     * @param {number|null} selectedId         id of the selected label
     */
    show(allLabels, shownLabels, usageByLabel, selectedId) {
      [labels, shown, usage, selected] = [allLabels, shownLabels, usageByLabel, selectedId];
      scheduleDraw();
    },
    destroy() {
      observer.disconnect();
      cancelAnimationFrame(scheduled);
    },
  };
}

/** @param {number} id */
function createRow(id) {
  const picture = imageWithPlaceholder({ class: 'label-picture', loading: 'lazy', decoding: 'async', width: 32, height: 32 });
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
    update(label, labels, usage, { place: index, height, selected }) {
      element.style.setProperty('transform', `translateY(${index * height}px)`);
      element.style.setProperty('height', `${height}px`);
      setAttribute(element, 'aria-rowindex', index + 2);
      setAttribute(element, 'aria-selected', String(selected));
      const reason = unavailableReason(label, labels);
      element.classList.toggle('label-away', reason !== '');
      setImageSource(picture, label.picture);
      const texts = [
        label.key,
        label.name + (label.pinned === null ? '' : ` · Ctrl+${label.pinned}`) + (reason && ` · ${reason}`),
        label.short,
        label.aliases.join(', '),
        label.shape,
        label.category,
        label.attributes.map(({ name }) => name).join(', '),
        { sign: 'sign', background: 'background', ignore: 'nothing' }[label.teach],
        usage === null ? '–' : count(usage.labels[label.id]?.tracks ?? 0) + (usage.unread ? '+' : ''),
      ];
      cells.forEach((cell, at) => {
        setText(cell, texts[at]);
        setAttribute(cell, 'title', texts[at]);
      });
    },
  };
}
