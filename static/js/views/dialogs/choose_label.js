// @ts-check
/** Choose one label of a set for another view. */

import { offeredLabels } from '../../model/labels.js';
import { h } from '../dom.js';
import { createLabelPicker } from './label_picker.js';

/**
 * @param {import('./index.js').DialogSetup<'choose-label'>} setup
 * @returns {import('./index.js').DialogContent}
 */
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
