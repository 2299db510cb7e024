// @ts-check
/** Fields that several dialogs share. */

import { ApiError, errorMessage } from '../../api/errors.js';
import { h } from '../dom.js';

/** @typedef {import('../dom.js').Children} Children */

/**
 * A labelled control.
 *
 * @param {string} label
 * @param {HTMLElement} control   with an id
 * @param {string} [hint]
 * @returns {HTMLElement}
 */
export function field(label, control, hint) {
  if (hint) control.setAttribute('aria-describedby', `${control.id}-hint`);
  return h(
    'div.field',
    h('label.field-label', { for: control.id }, label),
    control,
    hint && h('span.field-hint', { id: `${control.id}-hint` }, hint),
  );
}

/**
 * A group of controls whose heading screen readers read with each control.
 *
 * @param {string} legend
 * @param {...Children} children
 */
export function group(legend, ...children) {
  return h('fieldset.field', h('legend.field-label', legend), ...children);
}

/**
 * A checkbox or radio button with its label.
 *
 * @param {'checkbox'|'radio'} type
 * @param {{name?: string, value?: string, checked?: boolean, disabled?: boolean, title?: string, onchange?: () => void}} props
 * @param {...Children} content
 */
export function choiceInput(type, props, ...content) {
  const input = h('input', { type, ...props });
  return { input, element: h('label.tick', { title: props.title }, input, h('span', ...content)) };
}

/**
 * A field for one line of text.
 *
 * @param {string} id
 * @param {import('../dom.js').Props} props
 */
export const textInput = (id, props) => h('input.input', { type: 'text', id, autocomplete: 'off', ...props });

/**
 * A short field for a number.
 *
 * @param {string} id
 * @param {string} value
 * @param {() => void} oninput
 * @param {Record<string, unknown>} [props]
 */
export const numberInput = (id, value, oninput, props = {}) => textInput(id, { inputmode: 'decimal', value, oninput, ...props });

/**
 * The label of a switch of a format: `first_frame` becomes `First frame`.
 *
 * @param {string} name
 */
export const switchLabel = (name) => name.charAt(0).toUpperCase() + name.slice(1).replaceAll(/[_-]/g, ' ');

/**
 * The message of an error, after the name of the refused field if the message does not name it.
 *
 * @param {unknown} thrown
 */
export function messageWithField(thrown) {
  const prefix = thrown instanceof ApiError && thrown.field ? `${thrown.field}: ` : '';
  const message = errorMessage(thrown);
  return message.startsWith(prefix) ? message : prefix + message;
}
