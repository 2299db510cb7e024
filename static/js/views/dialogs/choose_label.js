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
  const choice = createLabelPicker({
    placeholder: 'Type a name, a code or a number',
    onPick: (label) => {
      close();
      data.take(label);
    },
  });
  choice.offer(data.labels, offeredLabels(data.labels), -1);
  choice.reveal();
  return {
    title: data.title,
    focus: choice.search,
    submit: () => {},
    body: h('div.stack.relabel', choice.search, choice.list, choice.none),
    footer: [h('button.btn', { onclick: close }, 'Cancel')],
  };
}
