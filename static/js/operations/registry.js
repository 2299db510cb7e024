// @ts-check
/** All operations: the source of toolbar, menu, keyboard, palette and help. */

import { attributes } from './attributes.js';
import { boxes } from './boxes.js';
import { exchange } from './exchange.js';
import { following } from './follow.js';
import { groundTruth } from './ground_truth.js';
import { library } from './library.js';
import { navigation } from './navigate.js';
import { page } from './page.js';
import { nextVideo } from './next_video.js';
import { team } from './team.js';
import { verdicts } from './verdicts.js';
import { view } from './view.js';

/** Operations on proposals come first, so that Enter and Escape apply to proposals while there are any. @returns {import('../page-types.js').Operation[]} */
export const allOperations = () => [
  ...following,
  ...navigation,
  ...nextVideo,
  ...boxes,
  ...verdicts,
  ...attributes,
  ...groundTruth,
  ...exchange,
  ...view,
  ...team,
  ...library,
  ...page,
];

/**
 * Run an operation if it is enabled.
 * @param {import('../page-types.js').App} app
 * @param {import('../page-types.js').Operation} operation
 * @param {(reason: string, options: {action?: {label: string, run: () => void}}) => void} [onDisabled]   called with the reason if it is disabled, and with an action that helps
 * @param {string} [key]   the pressed key, as in its `keys`
 * @returns {boolean} whether it ran
 */
export function runOperation(app, operation, onDisabled, key) {
  const state = app.store.get();
  if (!operation.available(state)) return false;
  const reason = operation.disabled(state);
  if (reason !== null) {
    onDisabled?.(reason, { action: operation.remedy?.(app) ?? undefined });
    return false;
  }
  operation.run(app, key);
  return true;
}
