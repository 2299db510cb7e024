// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { formatRunChoice, parseRunChoice } from '../../../static/js/model/run_choice.js';

const PRESETS = ['default', 'paper'];
const PARAMETERS = /** @type {any[]} */ ([{ name: 'tau' }, { name: 'n' }]);

test('the next run begins with preset and parameters of the last one', () => {
  const choice = { preset: 'paper', parameters: { tau: 25 } };
  assert.deepEqual(parseRunChoice(formatRunChoice(choice), PRESETS, PARAMETERS), choice);
});

test('a choice stored by another version is used as far as its fields are known', () => {
  const usual = { preset: 'default', parameters: {} };
  for (const text of [null, '', 'nonsense', '3', 'null', '{"preset": "gone", "parameters": {"tau": 3}}', '{"parameters": {"tau": 3}}'])
    assert.deepEqual(parseRunChoice(text, PRESETS, PARAMETERS), usual);
  assert.deepEqual(parseRunChoice('{"preset": "paper", "parameters": {"tau": 3, "gone": 1}}', PRESETS, PARAMETERS), {
    preset: 'paper',
    parameters: { tau: 3 },
  });
  assert.deepEqual(parseRunChoice('{"preset": "paper", "parameters": null}', PRESETS, PARAMETERS), { preset: 'paper', parameters: {} });
});
