// @ts-check
/** One label of a set: names, picture, attributes, and its use in training. */

import { errorMessage } from '../../api/errors.js';
import { CATEGORIES, SHAPES, changeOf, formOf } from '../../model/label_form.js';
import { h, selectInput, setText } from '../dom.js';
import { icon } from '../icons.js';
import { toPngBase64 } from '../label_picture.js';
import { imageWithPlaceholder, setImageSource } from '../images.js';
import { toast } from '../../core/toast.js';
import { field, group, textInput } from './fields.js';
import { createAttributeRows } from './label_attributes.js';

/** @typedef {import('../../types.js').Label} Label */

const TEACH_OPTIONS = /** @type {const} */ ([
  ['sign', 'a sign to detect and classify'],
  ['background', 'background'],
  ['ignore', 'not used: neither sign nor background'],
]);

/** @type {import('./index.js').CreateDialog<'label'>} */
export function labelDialog({ app, data, close, signal }) {
  const label = data.label ?? null;
  const initial = formOf(label);
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const saveButton = h('button.btn.btn-primary', { type: 'submit' }, label ? 'Save' : 'Add');
  /** @param {string} id @param {string} value @param {Record<string, unknown>} [props] */
  const labelInput = (id, value, props = {}) => textInput(`label-${id}`, { spellcheck: 'false', maxlength: 200, value, ...props });
  const name = labelInput('name', initial.name, { dir: 'auto' });
  const key = labelInput('key', initial.key, { maxlength: 100, readOnly: label !== null, placeholder: 'made from the name' });
  const short = labelInput('short', initial.short, { maxlength: 12, dir: 'auto', placeholder: 'the start of the name' });
  const aliases = h('textarea.textarea', { id: 'label-aliases', rows: 4, spellcheck: 'false', dir: 'auto', value: initial.aliases });
  const shape = selectInput(
    { id: 'label-shape' },
    SHAPES.map((option) => [option, option]),
    initial.shape,
  );
  const category = selectInput(
    { id: 'label-category' },
    CATEGORIES.map((option) => [option, option]),
    initial.category,
  );
  const teach = selectInput({ id: 'label-teach' }, TEACH_OPTIONS, initial.teach);
  const pinned = selectInput(
    { id: 'label-pinned' },
    [
      ['', 'no digit'],
      ...[1, 2, 3, 4, 5, 6, 7, 8, 9].map((digit) => {
        const other = data.labels.find((one) => one.pinned === digit && one.id !== label?.id);
        return /** @type {const} */ ([String(digit), other ? `Ctrl+${digit}, now ${other.name}` : `Ctrl+${digit}`]);
      }),
    ],
    initial.pinned,
  );
  const size = labelInput('size', initial.size_mm, { inputmode: 'decimal', placeholder: 'not known' });
  const mirror = labelInput('mirror', initial.mirror, { placeholder: 'none', list: 'label-keys' });
  const keys = h('datalist', { id: 'label-keys' }, ...data.labels.map((one) => h('option', { value: one.key }, one.name)));
  const colour = labelInput('colour', initial.colour, { placeholder: 'chosen by the tool', maxlength: 7 });
  const attributes = createAttributeRows(initial.attributes);
  const picture = imageWithPlaceholder({
    class: 'label-shown',
    width: 64,
    height: 64,
    hidden: label?.picture == null,
    src: label?.picture,
  });
  const file = h('input.visually-hidden', {
    type: 'file',
    accept: 'image/*',
    tabIndex: -1,
    'aria-label': 'Picture of the label',
    onchange: () => void setPicture(),
  });

  async function setPicture() {
    const chosenFile = file.files?.[0];
    if (!chosenFile || !label) return;
    setText(errorText, '');
    try {
      const { sentence: message } = await app.labels.change(
        { type: 'picture', id: label.id, png: await toPngBase64(chosenFile) },
        data.set,
      );
      setImageSource(picture, URL.createObjectURL(chosenFile));
      picture.hidden = false;
      toast(message, { tone: 'good' });
    } catch (thrown) {
      if (!signal.aborted)
        setText(errorText, thrown instanceof DOMException ? 'The browser cannot read this file as a picture.' : errorMessage(thrown));
    }
    file.value = '';
  }

  async function submit() {
    const result = changeOf(label, {
      key: key.value,
      name: name.value,
      short: short.value,
      aliases: aliases.value,
      shape: shape.value,
      category: category.value,
      teach: /** @type {Label['teach']} */ (teach.value),
      colour: colour.value,
      pinned: pinned.value,
      size_mm: size.value,
      mirror: mirror.value,
      attributes: attributes.read(),
    });
    if ('error' in result) {
      setText(errorText, result.error);
      return;
    }
    if (result.change === null) {
      close();
      return;
    }
    saveButton.disabled = true;
    setText(errorText, '');
    try {
      const { sentence: message } = await app.labels.change(result.change, data.set);
      close();
      toast(message, { tone: 'good' });
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    } finally {
      saveButton.disabled = false;
    }
  }

  return {
    title: label ? `Label ${label.name}` : 'Add a label',
    size: 'wide',
    submit: () => void submit(),
    focus: name,
    body: h(
      'div.run-dialog',
      keys,
      h(
        'section.run-column',
        { 'aria-label': 'Names' },
        field('Name', name),
        field(
          'Aliases, one per line',
          aliases,
          'Names and codes from other tools and countries. Dialogs, imports and comparisons accept them.',
        ),
        h(
          'div.run-fields',
          field(
            'Key',
            key,
            label
              ? 'It never changes: files and models refer to the label by it.'
              : 'Files and models refer to the label by it; it never changes.',
          ),
          field('Short name', short),
        ),
        label &&
          group(
            'Picture',
            h(
              'div.row',
              picture,
              h('button.btn.btn-small', { onclick: () => file.click() }, icon('upload'), 'Choose a picture file'),
              file,
            ),
            h('p.field-hint', 'You can also cut a picture from an accepted track, with the button in its inspector.'),
          ),
      ),
      h(
        'section.run-column',
        { 'aria-label': 'Properties' },
        h('div.run-fields', field('Shape', shape), field('Category', category)),
        field('Use in training', teach),
        h(
          'div.run-fields',
          field('Digit key', pinned),
          field('Typical width, mm', size),
          field('Mirror image', mirror),
          field('Colour', colour),
        ),
        group('Attributes', attributes.element),
      ),
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Cancel'), saveButton],
  };
}
