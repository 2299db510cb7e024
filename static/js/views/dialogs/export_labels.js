// @ts-check
/** The labels to export, and the class map of the files. */

import { labelFinder } from '../../model/label_finder.js';
import { labelsById, offeredLabels } from '../../model/labels.js';
import { fill, h, selectInput, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { choiceInput, field } from './fields.js';

/** @typedef {import('../../types.js').Label} Label */

const NOT_IN_SET = /** @type {const} */ ([
  ['leave-out', 'leave out'],
  ['ignore', 'export as regions to ignore'],
  ['class', 'export as a separate class'],
]);
const CLASS_MAP = /** @type {const} */ ([
  ['all', 'all labels of the set'],
  ['used', 'only exported labels'],
]);

/**
 * @param {readonly Label[]} labels
 * @param {Pick<import('../../model/exchange.js').ExportChoice, 'labels'|'not_in_set'|'class_map'>} initial
 * @param {() => void} onChange
 */
export function createExportLabels(labels, initial, onChange) {
  const offered = offeredLabels(labels);
  const checkboxes = offered.map((label) => ({
    label,
    ...choiceInput(
      'checkbox',
      { value: label.key, checked: initial.labels === null || initial.labels.includes(label.key), onchange: onLabelsChange },
      label.name,
    ),
  }));
  const summary = h('summary');
  const classMapSummary = h('summary', 'Class map');
  const list = h('ol.class-map.small');
  const search = h('input.input', {
    type: 'search',
    placeholder: 'Find a label',
    'aria-label': 'Find a label',
    oninput: () => {
      const found = new Set(labelFinder(labels).search(search.value, offered));
      for (const { label, element } of checkboxes) element.hidden = !found.has(label);
    },
  });
  const checkVisible = (/** @type {boolean} */ isChecked) => {
    for (const { input, element } of checkboxes) if (!element.hidden) input.checked = isChecked;
    onLabelsChange();
  };
  const notInSetSelect = selectInput({ id: 'export-not-in-set', onchange: onLabelsChange }, NOT_IN_SET, initial.not_in_set);
  const classMapSelect = selectInput({ id: 'export-class-map', onchange: onLabelsChange }, CLASS_MAP, initial.class_map);
  const element = h(
    'div.stack',
    h(
      'details.details',
      summary,
      h(
        'div.row',
        search,
        h('button.btn.btn-small', { onclick: () => checkVisible(true) }, 'All'),
        h('button.btn.btn-small', { onclick: () => checkVisible(false) }, 'None'),
      ),
      h('div.class-ticks', { role: 'group', 'aria-label': 'Labels' }, ...checkboxes.map((box) => box.element)),
    ),
    field('Signs that are not in the set', notInSetSelect),
    h('div.run-fields', field('Labels that the files declare', classMapSelect)),
    h('details.details', classMapSummary, list),
  );

  /** Keys; null: all. */
  function chosenKeys() {
    const checkedKeys = checkboxes.filter(({ input }) => input.checked).map(({ input }) => input.value);
    return checkedKeys.length === checkboxes.length ? null : checkedKeys;
  }

  function showSummary() {
    const checkedKeys = chosenKeys();
    setText(summary, checkedKeys === null ? 'Labels: all' : `Labels: ${checkedKeys.length} of ${checkboxes.length}`);
  }

  function onLabelsChange() {
    showSummary();
    onChange();
  }

  showSummary();
  return {
    element,
    chosen: chosenKeys,
    notInSet: () => /** @type {'leave-out'|'ignore'|'class'} */ (notInSetSelect.value),
    classMap: () => /** @type {'all'|'used'} */ (classMapSelect.value),
    /** Set whether the format has regions to ignore. @param {boolean} isAllowed */
    allowIgnore(isAllowed) {
      notInSetSelect.options[1].disabled = !isAllowed;
      if (!isAllowed && notInSetSelect.value === 'ignore') notInSetSelect.value = 'leave-out';
    },
    /** Show the number of tracks by label, once known. @param {Map<number, number>|null} byLabel */
    show(byLabel) {
      const used = new Set(byLabel?.keys());
      const keys = chosenKeys();
      const declared =
        classMapSelect.value === 'used' && byLabel
          ? [...used].sort((a, b) => a - b).flatMap((id) => labelsById(labels).get(id) ?? [])
          : offered.filter(({ key }) => keys === null || keys.includes(key));
      setText(classMapSummary, `Class map: ${plural(declared.length, 'label')}`);
      fill(
        list,
        ...declared.map(({ id, name }) =>
          h(
            'li',
            h('span.muted.label-id', id),
            h('span.grow', { dir: 'auto' }, name),
            byLabel && h('span.muted', plural(byLabel.get(id) ?? 0, 'track')),
          ),
        ),
      );
    },
  };
}
