// @ts-check
/** The part of the export dialog that splits signs or videos into training, validation and test. */

import { parseNumber } from '../../model/exchange.js';
import { h, selectInput } from '../dom.js';
import { choiceInput, field, numberInput } from './fields.js';

const HELP =
  'Shares count boxes. The same sign in thirty frames gives thirty near copies, so signs that share a frame stay together in one part. The leakage check proves that no sign and no picture is in two parts; otherwise nothing is written.';
const SPLIT_BY = /** @type {const} */ ([
  ['sign', 'by sign'],
  ['video', 'by video'],
]);
const SHARE = { name: 'The share', low: 0, high: 1000, empty: 0 };

/**
 * @param {ReturnType<typeof import('../../model/exchange.js').restoreChoice>} initial   the remembered choice
 * @param {() => void} onChange
 */
export function createExportSplit(initial, onChange) {
  const enabled = choiceInput('checkbox', { checked: initial.split, onchange: onChange }, 'Split into training, validation and test');
  const shares = /** @type {const} */ (['Train', 'Validation', 'Test']).map((label, at) => ({
    label,
    input: numberInput(`export-share-${at}`, initial.shares[at], onChange),
  }));
  const splitBySelect = selectInput({ id: 'export-by', onchange: onChange }, SPLIT_BY, initial.split_by);
  const seed = numberInput('export-seed', initial.seed, onChange, { inputmode: 'numeric' });
  const balanceLabels = choiceInput(
    'checkbox',
    { checked: initial.balance, onchange: onChange },
    'Give each part every label that has enough signs',
  );
  const fields = h(
    'div.stack.export-split',
    h('div.export-shares', ...shares.map(({ label, input }) => field(label, input)), field('Split by', splitBySelect), field('Seed', seed)),
    balanceLabels.element,
    h('p.field-hint', HELP),
  );
  const isOn = () => enabled.input.checked;
  return {
    element: h('div.stack', enabled.element, fields),
    isOn,
    isBalanced: () => balanceLabels.input.checked,
    by: () => /** @type {'sign'|'video'} */ (splitBySelect.value),
    /** The parsed numbers of the fields; empty without a split. @returns {Record<string, ReturnType<typeof parseNumber>>} */
    numbers() {
      if (!isOn()) return {};
      const [train, val, test] = shares.map(({ input }) => parseNumber(input.value, SHARE));
      return { train, val, test, seed: parseNumber(seed.value, { name: 'The seed', low: 0, high: 2 ** 31 - 1, whole: true }) };
    },
    /** The choice to remember for the next export. */
    choice: () => ({
      split: isOn(),
      shares: shares.map(({ input }) => input.value),
      split_by: splitBySelect.value,
      seed: seed.value,
      balance: balanceLabels.input.checked,
    }),
    show() {
      fields.hidden = !isOn();
    },
  };
}
