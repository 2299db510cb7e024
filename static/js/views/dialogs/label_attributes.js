// @ts-check
/** The attributes of a label, as rows that can be changed, added and removed. */

import { KINDS, NEW_ATTRIBUTE } from '../../model/label_form.js';
import { fill, h, selectInput } from '../dom.js';
import { icon } from '../icons.js';
import { choiceInput, field } from './fields.js';

/** @typedef {import('../../model/label_form.js').AttributeForm} AttributeForm */

const DEFAULTS = /** @type {const} */ ([
  ['', 'none'],
  ['true', 'yes'],
  ['false', 'no'],
]);

/** @param {readonly AttributeForm[]} initialForms */
export function createAttributeRows(initialForms) {
  /** @type {AttributeForm[]} */ let attributeForms = initialForms.map((one) => ({ ...one }));
  const list = h('div.stack');
  const addButton = h(
    'button.btn.btn-small',
    {
      onclick: () => {
        attributeForms = [...attributeForms, { ...NEW_ATTRIBUTE }];
        show();
        const name = /** @type {HTMLElement} */ (list.querySelector(`#attribute-${attributeForms.length - 1}-name`));
        name.scrollIntoView({ block: 'nearest' });
        name.focus();
      },
    },
    icon('add'),
    'Add an attribute',
  );
  const element = h('div.stack', list, h('div.row', addButton));

  function show() {
    fill(list, ...attributeForms.map((form, index) => row(form, index)));
  }

  /** @param {AttributeForm} form @param {number} index */
  function row(form, index) {
    const fieldId = (/** @type {string} */ part) => `attribute-${index}-${part}`;
    /** @param {'name'|'low'|'high'|'start'} part @param {string} label @param {Record<string, unknown>} [props] */
    const textField = (part, label, props = {}) => {
      const input = h('input.input', {
        type: 'text',
        id: fieldId(part),
        autocomplete: 'off',
        maxlength: 200,
        value: form[part],
        ...props,
        oninput: () => (form[part] = input.value),
      });
      return field(label, input);
    };
    const kind = selectInput(
      {
        id: fieldId('kind'),
        onchange: () => {
          form.kind = /** @type {AttributeForm['kind']} */ (kind.value);
          form.start = '';
          show();
          /** @type {HTMLElement|null} */ (list.querySelector(`#${fieldId('kind')}`))?.focus();
        },
      },
      KINDS,
      form.kind,
    );
    const mutable = choiceInput(
      'checkbox',
      { checked: form.mutable, onchange: () => (form.mutable = mutable.input.checked) },
      'May change from frame to frame',
    );
    const values = h('textarea.textarea', {
      id: fieldId('values'),
      rows: 3,
      value: form.values,
      oninput: () => (form.values = values.value),
    });
    const defaultSelect = selectInput({ id: fieldId('start'), onchange: () => (form.start = defaultSelect.value) }, DEFAULTS, form.start);
    return h(
      'fieldset.label-attribute',
      h('legend.visually-hidden', form.name || 'New attribute'),
      h(
        'div.run-fields',
        textField('name', 'Name'),
        field('Type', kind),
        form.kind === 'number' && textField('low', 'Least', { inputmode: 'decimal' }),
        form.kind === 'number' && textField('high', 'Largest', { inputmode: 'decimal' }),
        form.kind === 'checkbox' ? field('Default', defaultSelect) : textField('start', 'Default'),
      ),
      form.kind === 'select' && field('Values, one per line', values),
      h(
        'div.row',
        mutable.element,
        h('span.grow'),
        h(
          'button.btn.btn-small',
          {
            'aria-label': `Remove attribute ${form.name}`,
            onclick: () => {
              attributeForms = attributeForms.filter((other) => other !== form);
              show();
              addButton.focus();
            },
          },
          icon('delete'),
          'Remove',
        ),
      ),
    );
  }

  show();
  return { element, read: () => attributeForms };
}
