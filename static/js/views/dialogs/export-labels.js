// @ts-check
/** The labels to export, and the class map of the files. */

import { labelFinder } from '../../model/label_finder.js';
import { labelsById, offeredLabels } from '../../model/labels.js';
import { fill, h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { field, tick } from './fields.js';

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
 * @param {Pick<import('../../model/exchange.js').ExportChoice, 'labels'|'not_in_set'|'class_map'>} kept
 * @param {() => void} changed
 */
export function createExportLabels(labels, kept, changed) {
  const offered = offeredLabels(labels);
  const boxes = offered.map((label) => ({
    label,
    ...tick('checkbox', { value: label.key, checked: kept.labels === null || kept.labels.includes(label.key), onchange: tell }, label.name),
  }));
  const summary = h('summary');
  const preview = h('summary', 'Class map');
  const list = h('ol.class-map.small');
  const search = h('input.input', {
    type: 'search',
    placeholder: 'Find a label',
    'aria-label': 'Find a label',
    oninput: () => {
      const found = new Set(labelFinder(labels).search(search.value, offered));
      for (const { label, element } of boxes) element.hidden = !found.has(label);
    },
  });
  const set = (/** @type {boolean} */ on) => {
    for (const { input, element } of boxes) if (!element.hidden) input.checked = on;
    tell();
  };
  /** @template {string} T @param {string} id @param {readonly (readonly [T, string])[]} options @param {T} value */
  const select = (id, options, value) => {
    const element = h('select.select', { id, onchange: tell }, ...options.map(([one, words]) => h('option', { value: one }, words)));
    element.value = value;
    return element;
  };
  const outside = select('export-not-in-set', NOT_IN_SET, kept.not_in_set);
  const map = select('export-class-map', CLASS_MAP, kept.class_map);
  const element = h(
    'div.stack',
    h(
      'details.details',
      summary,
      h(
        'div.row',
        search,
        h('button.btn.btn-small', { onclick: () => set(true) }, 'All'),
        h('button.btn.btn-small', { onclick: () => set(false) }, 'None'),
      ),
      h('div.class-ticks', { role: 'group', 'aria-label': 'Labels' }, ...boxes.map((box) => box.element)),
    ),
    field('Signs that are not in the set', outside),
    h('div.run-fields', field('Labels that the files declare', map)),
    h('details.details', preview, list),
  );

  /** Keys; null: all. */
  function chosen() {
    const on = boxes.filter(({ input }) => input.checked).map(({ input }) => input.value);
    return on.length === boxes.length ? null : on;
  }

  function words() {
    const on = chosen();
    setText(summary, on === null ? 'Labels: all' : `Labels: ${on.length} of ${boxes.length}`);
  }

  function tell() {
    words();
    changed();
  }

  words();
  return {
    element,
    chosen,
    notInSet: () => /** @type {'leave-out'|'ignore'|'class'} */ (outside.value),
    classMap: () => /** @type {'all'|'used'} */ (map.value),
    /** Set whether the format has regions to ignore. @param {boolean} can */
    allowIgnore(can) {
      const option = /** @type {HTMLOptionElement} */ (outside.options[1]);
      option.disabled = !can;
      if (!can && outside.value === 'ignore') outside.value = 'leave-out';
    },
    /** Show the number of tracks by label, once known. @param {Map<number, number>|null} byLabel */
    show(byLabel) {
      const used = new Set(byLabel?.keys());
      const picked = chosen();
      const declared =
        map.value === 'used' && byLabel
          ? [...used].sort((a, b) => a - b).flatMap((id) => labelsById(labels).get(id) ?? [])
          : offered.filter(({ key }) => picked === null || picked.includes(key));
      setText(preview, `Class map: ${plural(declared.length, 'label')}`);
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
