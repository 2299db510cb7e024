// @ts-check
/** The attributes of a label, as rows that can be changed, added and removed. */

import { KINDS, NEW_ATTRIBUTE } from '../../model/label_form.js';
import { fill, h } from '../dom.js';
import { icon } from '../icons.js';
import { field, choiceInput } from './fields.js';

/** @typedef {import('../../model/label_form.js').AttributeForm} AttributeForm */

/** @param {readonly AttributeForm[]} first */
export function createAttributes(first) {
  /** @type {AttributeForm[]} */
  let forms = first.map((one) => ({ ...one }));
  const list = h('div.stack');
  const add = h(
    'button.btn.btn-small',
    {
      onclick: () => {
        forms = [...forms, { ...NEW_ATTRIBUTE }];
        show();
        list.querySelector(`#attribute-${forms.length - 1}-name`)?.scrollIntoView({ block: 'nearest' });
        /** @type {HTMLElement|null} */ (list.querySelector(`#attribute-${forms.length - 1}-name`))?.focus();
      },
    },
    icon('add'),
    'Add an attribute',
  );
  const element = h('div.stack', list, h('div.row', add));

  function show() {
    fill(list, ...forms.map((form, at) => row(form, at)));
  }

  /** @param {AttributeForm} form @param {number} at */
  function row(form, at) {
    const id = (/** @type {string} */ part) => `attribute-${at}-${part}`;
    /** @param {'name'|'low'|'high'|'start'} part @param {string} label @param {Record<string, unknown>} [more] */
    const text = (part, label, more = {}) => {
      const input = h('input.input', {
        type: 'text',
        id: id(part),
        autocomplete: 'off',
        maxlength: 200,
        value: form[part],
        ...more,
        oninput: () => {
          form[part] = input.value;
        },
      });
      return field(label, input);
    };
    const kind = h(
      'select.select',
      {
        id: id('kind'),
        onchange: () => {
          form.kind = /** @type {AttributeForm['kind']} */ (kind.value);
          form.start = '';
          show();
          /** @type {HTMLElement|null} */ (list.querySelector(`#${id('kind')}`))?.focus();
        },
      },
      ...KINDS.map(([value, words]) => h('option', { value }, words)),
    );
    kind.value = form.kind;
    const mutable = choiceInput(
      'checkbox',
      {
        checked: form.mutable,
        onchange: () => {
          form.mutable = mutable.input.checked;
        },
      },
      'May change from frame to frame',
    );
    const values = h('textarea.textarea', {
      id: id('values'),
      rows: 3,
      value: form.values,
      oninput: () => {
        form.values = values.value;
      },
    });
    const start = h(
      'select.select',
      {
        id: id('start'),
        onchange: () => {
          form.start = start.value;
        },
      },
      ...[
        ['', 'none'],
        ['true', 'yes'],
        ['false', 'no'],
      ].map(([value, words]) => h('option', { value }, words)),
    );
    start.value = form.start;
    const usual = 'Default';
    return h(
      'fieldset.label-attribute',
      h('legend.visually-hidden', form.name || 'New attribute'),
      h(
        'div.run-fields',
        text('name', 'Name'),
        field('Type', kind),
        form.kind === 'number' && text('low', 'Least', { inputmode: 'decimal' }),
        form.kind === 'number' && text('high', 'Largest', { inputmode: 'decimal' }),
        form.kind === 'checkbox' ? field(usual, start) : text('start', usual),
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
              forms = forms.filter((other) => other !== form);
              show();
              add.focus();
            },
          },
          icon('delete'),
          'Remove',
        ),
      ),
    );
  }

  show();
  return { element, read: () => forms };
}
