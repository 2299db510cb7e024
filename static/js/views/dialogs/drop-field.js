// @ts-check
/** A field for one file: a button to choose it, and an area to drop it on. */

import { h, setText } from '../dom.js';
import { bytes } from '../../model/format.js';
import { icon } from '../icons.js';
import { acceptDrops } from '../drops.js';

/**
 * @param {{id: string, label: string, hint: string, accept?: string, onChange: () => void}} options
 */
export function createDropField({ id, label, hint, accept, onChange }) {
  /** @type {File|null} */
  let file = null;
  const input = h('input', {
    type: 'file',
    id,
    accept,
    class: 'visually-hidden',
    tabIndex: -1,
    'aria-label': label,
    onchange: () => {
      if (input.files?.[0]) set(input.files[0]);
      input.value = '';
    },
  });
  const name = h('span', { class: 'truncate grow', 'aria-live': 'polite' }, 'No file chosen');
  const button = h('button', { class: 'btn', type: 'button', onclick: () => input.click() }, icon('folder'), 'Choose a file');
  const element = h(
    'div',
    { class: 'field drop-field' },
    h('span', { class: 'field-label' }, label),
    h('div', { class: 'drop-area' }, button, name, input),
    h('span', { class: 'field-hint' }, hint),
  );
  acceptDrops(element, ([first]) => first && set(first));

  /** @param {File} next */
  function set(next) {
    file = next;
    setText(name, `${next.name}, ${bytes(next.size)}`);
    onChange();
  }

  return { element, button, file: () => file, set };
}
