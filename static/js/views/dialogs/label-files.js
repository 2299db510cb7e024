// @ts-check
/** Import labels from another set or a file of another tool, and save this set as a file. */

import { sentence } from '../../api/errors.js';
import { fill, h, setText } from '../dom.js';
import { plural } from '../../model/format.js';
import { icon } from '../icons.js';
import { createDropField } from './drop-field.js';
import { field } from './fields.js';

const FORMATS = /** @type {const} */ ([
  ['tsr', 'JSON of tsr', 'All data of each label.'],
  ['cvat', 'Labels of CVAT', 'For the Raw tab of a CVAT task: names, colours, attributes.'],
  ['names', 'obj.names', 'One name per line.'],
  ['yaml', 'data.yaml', 'Names by number, as Ultralytics reads them.'],
  ['coco', 'COCO categories', 'Ids, names and supercategories.'],
  ['label-studio', 'Label Studio’s XML', 'The labelling interface of a video project.'],
]);

/**
 * @param {import('./layer.js').Setup<'label-files'>} setup
 * @returns {import('./layer.js').Content}
 */
export function labelFilesDialog({ app, data, close, signal }) {
  const { store, api } = app;
  const error = h('p.field-error.grow', { role: 'alert' });
  const reported = h('div.stack', { role: 'status' });
  const others = (store.get().labelSets ?? []).filter(({ key }) => key !== data.set);
  const from = h(
    'select.select',
    { id: 'labels-from' },
    ...others.map(({ key, name, labels }) => h('option', { value: key }, `${name} (${plural(labels, 'label')})`)),
  );
  const adopt = h(
    'button.btn',
    {
      disabled: others.length === 0,
      onclick: () =>
        void act(async () => {
          const { sentence: said } = await app.labels.change({ type: 'adopt', set: from.value }, data.set);
          fill(reported, h('p', said));
        }),
    },
    icon('add'),
    'Add what is missing',
  );
  const drop = createDropField({
    id: 'labels-file',
    label: 'File',
    hint: 'A set of this tool, CVAT’s labels, obj.names, data.yaml, COCO or Label Studio’s XML; the format is detected.',
    onChange: () => {
      bring.disabled = drop.file() === null;
      setText(error, '');
    },
  });
  const fresh = h('input.input', {
    type: 'text',
    id: 'labels-new',
    maxlength: 64,
    autocomplete: 'off',
    spellcheck: 'false',
    placeholder: 'no: add to this set',
  });
  const bring = h(
    'button.btn',
    {
      disabled: true,
      onclick: () =>
        void act(async () => {
          const file = drop.file();
          if (!file) return;
          const key = fresh.value.trim();
          const { sentence: said, known, refused, reported: notes } = await app.labels.importFile(key || data.set, file, key !== '');
          fill(
            reported,
            h('p', said, known.length > 0 && ` ${plural(known.length, 'label')} already known.`),
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

  /** @param {() => Promise<void>} what */
  async function act(what) {
    adopt.disabled = bring.disabled = true;
    setText(error, '');
    fill(reported);
    try {
      await what();
    } catch (thrown) {
      if (!signal.aborted) setText(error, sentence(thrown));
    } finally {
      adopt.disabled = others.length === 0;
      bring.disabled = drop.file() === null;
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
          field('From another set', from),
          h('div.row', adopt),
          drop.element,
          field(
            'As a new set with the key',
            fresh,
            'Letters, digits and hyphens, such as slovenia. Choose the set on the Labels page afterwards.',
          ),
          h('div.row', bring),
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
      reported,
    ),
    footer: [error, h('button.btn', { onclick: close }, 'Close')],
  };
}
