// @ts-check
/** Import labels from another set or a file of another tool, and save this set as a file. */

import { errorMessage } from '../../api/errors.js';
import { fill, h, selectInput, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createDropField } from './drop_field.js';
import { field, textInput } from './fields.js';

const FORMATS = /** @type {const} */ ([
  ['tsr', 'JSON of tsr', 'All data of each label.'],
  ['cvat', 'Labels of CVAT', 'For the Raw tab of a CVAT task: names, colours, attributes.'],
  ['names', 'obj.names', 'One name per line.'],
  ['yaml', 'data.yaml', 'Names by number, as Ultralytics reads them.'],
  ['coco', 'COCO categories', 'Ids, names and supercategories.'],
  ['label-studio', 'Label Studio’s XML', 'The labelling interface of a video project.'],
]);

/** @type {import('./index.js').CreateDialog<'label-files'>} */
export function labelFilesDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const errorText = h('p.field-error.grow', { role: 'alert' });
  const resultElement = h('div.stack', { role: 'status' });
  const otherSets = (store.get().labelSets ?? []).filter(({ key }) => key !== data.set);
  const sourceSelect = selectInput(
    { id: 'labels-from' },
    otherSets.map(({ key, name, labels }) => [key, `${name} (${plural(labels, 'label')})`]),
  );
  const addMissingButton = h(
    'button.btn',
    {
      disabled: otherSets.length === 0,
      onclick: () =>
        void runAction(async () => {
          const { sentence: message } = await app.labels.change({ type: 'adopt', set: sourceSelect.value }, data.set);
          fill(resultElement, h('p', message));
        }),
    },
    icon('add'),
    'Add what is missing',
  );
  const fileField = createDropField({
    id: 'labels-file',
    label: 'File',
    hint: 'A set of this tool, CVAT’s labels, obj.names, data.yaml, COCO or Label Studio’s XML; the format is detected.',
    onChange: () => {
      importButton.disabled = fileField.file() === null;
      setText(errorText, '');
    },
  });
  const newKeyInput = textInput('labels-new', { maxlength: 64, spellcheck: 'false', placeholder: 'no: add to this set' });
  const importButton = h(
    'button.btn',
    {
      disabled: true,
      onclick: () =>
        void runAction(async () => {
          const file = fileField.file();
          if (!file) return;
          const key = newKeyInput.value.trim();
          const { sentence: message, known, refused, reported: notes } = await app.labels.importFile(key || data.set, file, key !== '');
          fill(
            resultElement,
            h('p', message, known.length > 0 && ` ${plural(known.length, 'label')} already known.`),
            refused.length + notes.length > 0 &&
              h(
                'ul.skipped-list.small',
                ...refused.map(({ name, reason }) => h('li', `${name}: ${reason}`)),
                ...notes.map((text) => h('li', text)),
              ),
          );
        }),
    },
    icon('import'),
    'Import',
  );

  /** @param {() => Promise<void>} action */
  async function runAction(action) {
    addMissingButton.disabled = importButton.disabled = true;
    setText(errorText, '');
    fill(resultElement);
    try {
      await action();
    } catch (thrown) {
      if (!signal.aborted) setText(errorText, errorMessage(thrown));
    } finally {
      addMissingButton.disabled = otherSets.length === 0;
      importButton.disabled = fileField.file() === null;
    }
  }

  return {
    title: 'Import and export labels',
    size: 'wide',
    body: h(
      'div.stack',
      h(
        'div.run-dialog',
        h(
          'section.run-column',
          { 'aria-labelledby': 'labels-in' },
          h('h3', { id: 'labels-in' }, 'Import labels'),
          h(
            'p.muted',
            'Labels that the set lacks are added with new numbers. Labels that it already has, by key, name or alias, do not change.',
          ),
          field('From another set', sourceSelect),
          h('div.row', addMissingButton),
          fileField.element,
          field(
            'As a new set with the key',
            newKeyInput,
            'Letters, digits and hyphens, such as slovenia. Choose the set on the Labels page afterwards.',
          ),
          h('div.row', importButton),
        ),
        h(
          'section.run-column',
          { 'aria-labelledby': 'labels-out' },
          h('h3', { id: 'labels-out' }, 'Export this set'),
          h(
            'ul.made-list',
            ...FORMATS.map(([format, name, text]) =>
              h(
                'li.made',
                h('div.stack.made-text', h('strong', name), h('span.muted.small', text)),
                h(
                  'a.btn.btn-small',
                  { href: api.labelFileUrl(data.set, format), download: '', 'aria-label': `Save as ${name}` },
                  icon('export'),
                  'Save',
                ),
              ),
            ),
          ),
        ),
      ),
      resultElement,
    ),
    footer: [errorText, h('button.btn', { onclick: close }, 'Close')],
  };
}
