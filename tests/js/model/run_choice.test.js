// @ts-check
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { keptChoice, restoredChoice } from '../../../static/js/model/run_choice.js';

const PRESETS = ['default', 'paper'];
const PARAMETERS = /** @type {any[]} */ ([{ name: 'tau' }, { name: 'n' }]);

test('the next run begins with preset and parameters of the last one', () => {
  const choice = { preset: 'paper', parameters: { tau: 25 } };
  assert.deepEqual(restoredChoice(keptChoice(choice), PRESETS, PARAMETERS), choice);
});

test('what another version has remembered is taken as far as it is known', () => {
  const usual = { preset: 'default', parameters: {} };
  for (const text of [null, '', 'nonsense', '3', 'null', '{"preset": "gone", "parameters": {"tau": 3}}', '{"parameters": {"tau": 3}}'])
    assert.deepEqual(restoredChoice(text, PRESETS, PARAMETERS), usual);
  assert.deepEqual(restoredChoice('{"preset": "paper", "parameters": {"tau": 3, "gone": 1}}', PRESETS, PARAMETERS), {
    preset: 'paper',
    parameters: { tau: 3 },
  });
  assert.deepEqual(restoredChoice('{"preset": "paper", "parameters": null}', PRESETS, PARAMETERS), { preset: 'paper', parameters: {} });
});
