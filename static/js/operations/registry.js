// @ts-check
/** Everything a person can do: the one source of toolbar, menu, keyboard, palette and help. */

import { attributes } from './attributes.js';
import { boxes } from './boxes.js';
import { exchange } from './exchange.js';
import { following } from './follow.js';
import { groundTruth } from './ground_truth.js';
import { navigation } from './navigate.js';
import { page } from './page.js';
import { library } from './next_video.js';
import { team } from './team.js';
import { verdicts } from './verdicts.js';
import { view } from './view.js';

/** Those of proposals come first: while there are any, Enter and Escape are about them. @returns {import('../page-types.js').Operation[]} */
export const allOperations = () => [
  ...following,
  ...navigation,
  ...library,
  ...boxes,
  ...verdicts,
  ...attributes,
  ...groundTruth,
  ...exchange,
  ...view,
  ...team,
  ...page,
];

/**
 * Run an operation if it can be run now.
 * @param {import('../page-types.js').App} app
 * @param {import('../page-types.js').Operation} operation
 * @param {(reason: string, options: {action?: {label: string, run: () => void}}) => void} [refuse]   told why not, with what helps
 * @param {string} [key]   that was pressed, as in its `keys`
 * @returns {boolean} whether it ran
 */
export function runOperation(app, operation, refuse, key) {
  const state = app.store.get();
  if (!operation.available(state)) return false;
  const reason = operation.disabled(state);
  if (reason !== null) {
    refuse?.(reason, { action: operation.remedy?.(app) ?? undefined });
    return false;
  }
  operation.run(app, key);
  return true;
}
