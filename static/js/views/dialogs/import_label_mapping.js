// @ts-check
/** A table that maps names in a file without a matching label, before anything is stored. */

import { ANSWERS, mappingOf, initialAnswer } from '../../model/label_mapping.js';
import { offeredLabels } from '../../model/labels.js';
import { h, selectInput } from '../dom.js';
import { plural } from '../../model/format.js';
import { tableHeading } from '../headings.js';

/** @typedef {import('../../types.js').UnknownLabel} UnknownLabel */

/** Side of an example, px. */
const EXAMPLE_SIZE_PX = 64;
/** Maximum number of examples: each needs a frame of the video. */
const MAX_EXAMPLES = 60;

/**
 * @param {object} setup
 * @param {import('../../api/client.js').Api} setup.api
 * @param {string} setup.video
 * @param {readonly UnknownLabel[]} setup.unknown
 * @param {readonly import('../../types.js').Label[]} setup.labels
 * @param {() => void} setup.onChange
 * @param {AbortSignal} setup.signal
 */
export function createLabelMapping({ api, video, unknown, labels, onChange, signal }) {
  const names = h('datalist', { id: 'mapping-labels' }, ...offeredLabels(labels).map(({ name, key }) => h('option', { value: name }, key)));
  const rows = unknown.map((unknownLabel, index) => {
    const proposal = initialAnswer(unknownLabel);
    const labelInput = h('input.input', {
      type: 'text',
      list: 'mapping-labels',
      id: `mapping-${index}`,
      value: proposal.word,
      autocomplete: 'off',
      placeholder: 'Type a label',
      dir: 'auto',
      'aria-label': `Label of ${unknownLabel.name}`,
      oninput: onChange,
    });
    const kindSelect = selectInput(
      {
        'aria-label': `How to import ${unknownLabel.name}`,
        onchange: () => {
          labelInput.hidden = kindSelect.value !== 'label';
          if (!labelInput.hidden) labelInput.focus();
          onChange();
        },
      },
      ANSWERS,
      proposal.kind,
    );
    labelInput.hidden = proposal.kind !== 'label';
    const picture = h('canvas.mapping-example', {
      width: EXAMPLE_SIZE_PX,
      height: EXAMPLE_SIZE_PX,
      hidden: unknownLabel.example === null,
      role: 'img',
      'aria-label': `Example of ${unknownLabel.name}`,
    });
    const otherSuggestions = unknownLabel.suggestions
      .slice(proposal.kind === 'label' ? 1 : 0)
      .map(({ name }) => name)
      .join(', ');
    const element = h(
      'tr',
      h('th', { scope: 'row', dir: 'auto', title: unknownLabel.name }, h('span.mapping-name', unknownLabel.name)),
      h(
        'td.muted.small.mapping-holds',
        h('span', plural(unknownLabel.boxes, 'box', 'boxes')),
        h('span', plural(unknownLabel.tracks, 'track')),
      ),
      h('td', picture),
      h(
        'td',
        h(
          'div.stack',
          h('div.row', kindSelect, labelInput),
          otherSuggestions && h('span.muted.small', `${unknownLabel.similar ? 'Also similar' : 'With this word'}: ${otherSuggestions}`),
        ),
      ),
    );
    return { element, kindSelect, labelInput, picture, example: unknownLabel.example };
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
        tableHeading(['Name in the file', 'Contains', 'Example', 'Import as']),
        h('tbody', ...rows.map((row) => row.element)),
      ),
    ),
  );

  async function showExamples() {
    for (const { picture, example } of rows.filter((row) => row.example).slice(0, MAX_EXAMPLES)) {
      if (example === null || signal.aborted) continue;
      try {
        const { blob } = await api.frame(video, example.frame, { signal });
        const [x1, y1, x2, y2] = example.box;
        const size = 1.4 * Math.max(x2 - x1, y2 - y1, 8);
        const [left, top] = [(x1 + x2 - size) / 2, (y1 + y2 - size) / 2];
        const image = await createImageBitmap(blob);
        picture.getContext('2d')?.drawImage(image, left, top, size, size, 0, 0, EXAMPLE_SIZE_PX, EXAMPLE_SIZE_PX);
        image.close();
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
        rows.map(({ kindSelect, labelInput }) => ({
          kind: /** @type {import('../../model/label_mapping.js').Answer['kind']} */ (kindSelect.value),
          word: labelInput.value,
        })),
        labels,
      ),
  };
}
