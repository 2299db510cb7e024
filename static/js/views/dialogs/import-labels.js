// @ts-check
/** A table that maps names in a file without a matching label, before anything is stored. */

import { ANSWERS, mappingOf, initialAnswer } from '../../model/label_mapping.js';
import { offeredLabels } from '../../model/labels.js';
import { h } from '../dom.js';
import { plural } from '../../model/format.js';
import { tableHead } from '../heads.js';

/** @typedef {import('../../types.js').UnknownLabel} UnknownLabel */

/** Side of an example, px. */
const SIDE = 64;
/** Maximum number of examples: each needs a frame of the video. */
const MOST_EXAMPLES = 60;

/**
 * @param {object} setup
 * @param {import('../../api/client.js').Api} setup.api
 * @param {string} setup.video
 * @param {readonly UnknownLabel[]} setup.unknown
 * @param {readonly import('../../types.js').Label[]} setup.labels
 * @param {() => void} setup.changed
 * @param {AbortSignal} setup.signal
 */
export function createMapping({ api, video, unknown, labels, changed, signal }) {
  const names = h('datalist', { id: 'mapping-labels' }, ...offeredLabels(labels).map(({ name, key }) => h('option', { value: name }, key)));
  const rows = unknown.map((one, at) => {
    const first = initialAnswer(one);
    const word = h('input.input', {
      type: 'text',
      list: 'mapping-labels',
      id: `mapping-${at}`,
      value: first.word,
      autocomplete: 'off',
      placeholder: 'Type a label',
      dir: 'auto',
      'aria-label': `Label of ${one.name}`,
      oninput: changed,
    });
    const kind = h(
      'select.select',
      {
        'aria-label': `How to import ${one.name}`,
        onchange: () => {
          word.hidden = kind.value !== 'label';
          if (!word.hidden) word.focus();
          changed();
        },
      },
      ...ANSWERS.map(([value, text]) => h('option', { value }, text)),
    );
    kind.value = first.kind;
    word.hidden = first.kind !== 'label';
    const picture = h('canvas.mapping-example', {
      width: SIDE,
      height: SIDE,
      hidden: one.example === null,
      role: 'img',
      'aria-label': `Example of ${one.name}`,
    });
    const others = one.suggestions
      .slice(first.kind === 'label' ? 1 : 0)
      .map(({ name }) => name)
      .join(', ');
    const element = h(
      'tr',
      h('th', { scope: 'row', dir: 'auto', title: one.name }, h('span.mapping-name', one.name)),
      h('td.muted.small.mapping-holds', h('span', plural(one.boxes, 'box', 'boxes')), h('span', plural(one.tracks, 'track'))),
      h('td', picture),
      h(
        'td',
        h(
          'div.stack',
          h('div.row', kind, word),
          others && h('span.muted.small', `${one.similar ? 'Also similar' : 'With this word'}: ${others}`),
        ),
      ),
    );
    return { element, kind, word, picture, example: one.example };
  });
  const element = h(
    'div.stack',
    h(
      'p',
      `The file has ${unknown.length === 1 ? 'a name that is' : `${unknown.length} names that are`} not a label of the set. Nothing is stored yet. Your choices are remembered for the next file.`,
    ),
    names,
    h(
      'div.mapping-frame',
      { role: 'region', 'aria-label': 'Names of the file', tabIndex: 0 },
      h(
        'table.mapping',
        tableHead(['Name in the file', 'Contains', 'Example', 'Import as']),
        h('tbody', ...rows.map((row) => row.element)),
      ),
    ),
  );

  async function showExamples() {
    for (const { picture, example } of rows.filter((row) => row.example).slice(0, MOST_EXAMPLES)) {
      if (example === null || signal.aborted) continue;
      try {
        const { blob } = await api.frame(video, example.frame, { signal });
        const [x1, y1, x2, y2] = example.box;
        const side = 1.4 * Math.max(x2 - x1, y2 - y1, 8);
        const [left, top] = [(x1 + x2 - side) / 2, (y1 + y2 - side) / 2];
        const whole = await createImageBitmap(blob);
        picture.getContext('2d')?.drawImage(whole, left, top, side, side, 0, 0, SIDE, SIDE);
        whole.close();
      } catch {
        picture.hidden = true; // name and numbers are enough
      }
    }
  }

  void showExamples();
  return {
    element,
    read: () =>
      mappingOf(
        unknown,
        rows.map(({ kind, word }) => ({
          kind: /** @type {import('../../model/label_mapping.js').Answer['kind']} */ (kind.value),
          word: word.value,
        })),
        labels,
      ),
    /** Focus a row with an error. @param {number} at */
    point: (at) => rows[at]?.word.focus(),
  };
}
