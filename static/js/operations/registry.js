// @ts-check
/** Everything a person can do: the one source of toolbar, keyboard and help. */

import { attributes } from './attributes.js';
import { boxes } from './boxes.js';
import { exchange } from './exchange.js';
import { following } from './follow.js';
import { navigation } from './navigate.js';
import { team } from './team.js';
import { verdicts } from './verdicts.js';
import { view } from './view.js';

/** Those of proposals come first: while there are any, Enter and Escape are about them. @returns {import('../page-types.js').Operation[]} */
export const allOperations = () => [...following, ...navigation, ...boxes, ...verdicts, ...attributes, ...exchange, ...view, ...team];

/**
 * Run an operation if it can be run now.
 * @param {import('../page-types.js').App} app
 * @param {import('../page-types.js').Operation} operation
 * @param {(reason: string) => void} [refuse]   told why not
 * @param {string} [key]   that was pressed, as in its `keys`
 * @returns {boolean} whether it ran
 */
export function runOperation(app, operation, refuse, key) {
  const state = app.store.get();
  if (!operation.available(state)) return false;
  const reason = operation.disabled(state);
  if (reason !== null) {
    refuse?.(reason);
    return false;
  }
  operation.run(app, key);
  return true;
}
