// @ts-check
/** Takes signs of a ground truth over into the corrections of a run, and undoes that. */

import { errorMessage } from '../api/errors.js';
import { plural } from '../model/format.js';
import { authorName } from '../core/preferences.js';
import { toast } from '../core/toast.js';
import { randomId } from '../core/random_id.js';

/** The outcome as a message. @param {import('../api/compare-types.js').TakenOver} found */
function takeOverMessage({ changed, made, same, skipped }) {
  const parts = [
    made && plural(made, 'new track'),
    changed && `${plural(changed, 'track')} corrected`,
    same && `${plural(same, 'track')} already as in the ground truth`,
  ].filter(Boolean);
  return [`Taken over: ${parts.join(', ') || 'nothing'}.`, ...skipped].join(' ');
}

/**
 * Take signs over, and report the outcome with a button for undo.
 *
 * @param {import('../page-types.js').App} app
 * @param {string} run                  the run to correct
 * @param {{truth: string, signs?: number[], label?: number}} request
 * @param {() => void} [onChange]        called after each change of the corrections, including the undo
 */
export async function takeOver(app, run, request, onChange = () => {}) {
  const name = authorName(app.store.get().session);
  const author = name || app.store.get().session?.author || 'someone';
  try {
    const found = await app.api.takeOver(run, { ...request, author: name }, { signal: app.signal });
    const { op_id } = found;
    const undo = op_id === null ? undefined : { label: 'Undo', run: () => void undoTakeOver(op_id) };
    onChange();
    toast(takeOverMessage(found), { tone: 'good', topic: 'take-over', stays: true, action: undo });
  } catch (thrown) {
    if (!app.signal.aborted) toast(errorMessage(thrown), { tone: 'bad', topic: 'take-over' });
  }

  /** @param {string} op_id */
  async function undoTakeOver(op_id) {
    try {
      await app.api.edit(run, { op_id: randomId(), author, command: { name: 'undo', op_id } }, {}, { signal: app.signal });
      onChange();
      toast('The ground truth is no longer taken over.', { topic: 'take-over' });
    } catch (thrown) {
      if (!app.signal.aborted) toast(errorMessage(thrown), { tone: 'bad', topic: 'take-over' });
    }
  }
}
