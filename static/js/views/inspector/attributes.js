// @ts-check
/** The attributes of the selected track as a small form. */

import { attributeProblem, valueOfText } from '../../model/attributes.js';
import { setAttribute, selectedAttributes } from '../../operations/attributes.js';
import { toast } from '../../core/toast.js';
import { fill, h } from '../dom.js';
import { iconButton } from '../icons.js';

/** @typedef {import('../../model/attributes.js').AttributeRow} AttributeRow */
/** @typedef {import('../../types.js').Attribute} Attribute */

/** @param {import('../../page-types.js').App} app */
export function createAttributes(app) {
  const list = h('div.attributes');
  const element = h('section.inspector-section', { 'aria-label': 'Attributes' }, h('h3', 'Attributes'), list);
  // letters are commands of the review screen, but text in a field
  list.addEventListener('keydown', (event) => {
    if (event.target instanceof HTMLInputElement && event.target.type !== 'checkbox') event.stopPropagation();
    if (event.key === 'Enter' && event.target instanceof HTMLInputElement) {
      isEntered = true;
      event.target.blur();
      isEntered = false;
    }
  });
  let shownKey = '';
  /** Whether Enter commits a value: an invalid one keeps the focus. A press elsewhere takes it. */
  let isEntered = false;

  /** @param {AttributeRow} row @param {Attribute} attribute */
  function field(row, attribute) {
    const { name, kind, mutable, values, low, high } = attribute;
    /** @param {import('../../types.js').AttributeValue|null} value */
    const setValue = (value) => value !== (row.given ? row.value : null) && setAttribute(app, name, value, mutable);
    if (kind === 'checkbox') {
      return h('input', {
        type: 'checkbox',
        'aria-label': name,
        checked: row.value === true,
        title: row.digit <= 9 ? `${name} (Alt+${row.digit})` : '',
        onchange: (/** @type {Event} */ event) => setValue(/** @type {HTMLInputElement} */ (event.target).checked),
      });
    }
    if (kind === 'select') {
      const options = ['', ...values].map((value) =>
        h('option', { value, selected: value === (row.value ?? '') }, value === '' ? 'not said' : value),
      );
      return h(
        'select.select',
        {
          'aria-label': name,
          onchange: (/** @type {Event} */ event) => setValue(/** @type {HTMLSelectElement} */ (event.target).value || null),
        },
        ...options,
      );
    }
    const input = h('input.input', {
      'aria-label': name,
      type: kind === 'number' ? 'number' : 'text',
      step: 'any',
      min: low,
      max: high,
      maxlength: '1000',
      value: row.value === null ? '' : String(row.value),
      dir: 'auto',
    });
    input.addEventListener('change', () => {
      const value = valueOfText(attribute, input.value);
      // a number field without a valid number has an empty value
      const problem = input.validity.badInput ? `${name} must be a number.` : value === null ? null : attributeProblem(attribute, value);
      input.setCustomValidity(problem ?? '');
      if (problem === null) setValue(value);
      else if (isEntered) input.reportValidity();
      else toast(problem, { tone: 'bad', topic: 'attribute' });
    });
    input.addEventListener('input', () => input.setCustomValidity(''));
    return input;
  }

  /** @param {AttributeRow} row */
  function createRow(row) {
    const { name, attribute, value } = row;
    const wholeTrackButton =
      attribute?.mutable &&
      h(
        'button.btn.btn-quiet.btn-small',
        {
          title: 'Give the value of this frame to the whole track',
          disabled: value === null || !(row.given && row.changes),
          onclick: () => setAttribute(app, name, value, false),
        },
        'Whole track',
      );
    const removeButton =
      row.given && iconButton('delete', `Remove ${name}`, () => setAttribute(app, name, null, false), 'Remove the value');
    return h(
      'div.attribute',
      h(
        'span.attribute-name',
        {
          dir: 'auto',
          title:
            attribute === null
              ? 'The label has no such attribute; the value comes from an earlier label'
              : attribute.mutable
                ? 'From this frame on'
                : 'Of the whole track',
        },
        name,
      ),
      attribute === null ? h('span.muted', { dir: 'auto' }, String(value)) : field(row, attribute),
      attribute?.mutable && h('span.small.muted', 'from here on'),
      wholeTrackButton,
      removeButton,
    );
  }

  return {
    element,
    /** @param {import('./index.js').Inspected} inspected */
    update({ state, entry }) {
      const rows = selectedAttributes(state);
      const nextKey = JSON.stringify([entry.key, state.review?.run?.id, rows]);
      element.hidden = rows.length === 0;
      if (nextKey === shownKey) return;
      shownKey = nextKey;
      const focusedLabel = list.contains(document.activeElement) ? document.activeElement?.getAttribute('aria-label') : null;
      fill(list, ...rows.map(createRow));
      if (focusedLabel) /** @type {HTMLElement|null} */ (list.querySelector(`[aria-label="${CSS.escape(focusedLabel)}"]`))?.focus();
    },
  };
}
