// @ts-check
/** Choose one label of a set for another view. */

import { offeredLabels } from '../../model/labels.js';
import { h } from '../dom.js';
import { createLabelPicker } from './label_picker.js';

/** @type {import('./index.js').CreateDialog<'choose-label'>} */
export function chooseLabelDialog({ data, close }) {
  const picker = createLabelPicker({
    placeholder: 'Type a name, a code or a number',
    onPick: (label) => {
      close();
      data.take(label);
    },
  });
  picker.offer(data.labels, offeredLabels(data.labels), -1);
  picker.reveal();
  return {
    title: data.title,
    focus: picker.search,
    submit: () => {},
    body: h('div.stack.relabel', picker.search, picker.list, picker.emptyText),
    footer: [h('button.btn', { onclick: close }, 'Cancel')],
  };
}
