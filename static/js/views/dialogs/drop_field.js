// @ts-check
/** A field for one file: a button to choose it, and an area to drop it. */

import { h, setText } from '../dom.js';
import { bytes } from '../../model/format.js';
import { icon } from '../icons.js';
import { acceptFileDrops } from '../file_drop.js';

/** @param {{id: string, label: string, hint: string, accept?: string, onChange: () => void}} options */
export function createDropField({ id, label, hint, accept, onChange }) {
  /** @type {File|null} */ let file = null;
  const input = h('input.visually-hidden', {
    type: 'file',
    id,
    accept,
    tabIndex: -1,
    'aria-label': label,
    onchange: () => {
      if (input.files?.[0]) set(input.files[0]);
      input.value = '';
    },
  });
  const name = h('span.truncate.grow', { 'aria-live': 'polite' }, 'No file chosen');
  const button = h('button.btn', { onclick: () => input.click() }, icon('folder'), 'Choose a file');
  const element = h(
    'div.field.drop-field',
    h('span.field-label', label),
    h('div.drop-area', button, name, input),
    h('span.field-hint', hint),
  );
  acceptFileDrops(element, ([first]) => first && set(first));

  /** @param {File} next */
  function set(next) {
    file = next;
    setText(name, `${next.name}, ${bytes(next.size)}`);
    onChange();
  }

  return { element, button, file: () => file, set };
}
