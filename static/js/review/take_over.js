// @ts-check
/** Taking signs of a ground truth over into the corrections of a run, and undoing that. */

import { sentence } from '../api/errors.js';
import { plural } from '../model/format.js';
import { signature } from '../core/preferences.js';
import { toast } from '../core/toast.js';

/**
 * The outcome in words.
 * @param {import('../api/compare-types.js').TakenOver} found
 */
function takenWords({ changed, made, same, skipped }) {
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
 * @param {{truth: string, signs?: number[], label?: number}} wanted
 * @param {() => void} [changed]        called after each change of the corrections, including the undo
 */
export async function takeOver(app, run, wanted, changed = () => {}) {
  const name = signature(app.store.get().session);
  const author = name || app.store.get().session?.author || 'someone';
  try {
    const found = await app.api.takeOver(run, { ...wanted, author: name }, { signal: app.signal });
    const { op_id } = found;
    const undo = op_id === null ? undefined : { label: 'Undo', run: () => void back(op_id) };
    changed();
    toast(takenWords(found), { tone: 'good', topic: 'take-over', stays: true, action: undo });
  } catch (thrown) {
    if (!app.signal.aborted) toast(sentence(thrown), { tone: 'bad', topic: 'take-over' });
  }

  /** @param {string} op_id */
  async function back(op_id) {
    try {
      await app.api.edit(run, { op_id: crypto.randomUUID(), author, command: { name: 'undo', op_id } }, {}, { signal: app.signal });
      changed();
      toast('The ground truth is no longer taken over.', { topic: 'take-over' });
    } catch (thrown) {
      if (!app.signal.aborted) toast(sentence(thrown), { tone: 'bad', topic: 'take-over' });
    }
  }
}
