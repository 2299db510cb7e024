// @ts-check
/**
 * Moving a box by keys: presses without a pause form one operation, like a drag by mouse. It is kept with each press
 * and sent when no key is pressed for a while.
 *
 * @typedef {import('../types.js').Command} Command
 */

/** Pause that ends the operation, ms. Longer than the delay after which a keyboard repeats a held key. */
export const MAX_PRESS_INTERVAL_MS = 1000;

/** @param {import('./editor_state.js').EditorState} edits */
export function createKeyMoves(edits) {
  /** @type {{op_id: string, gesture: string, finished: Promise<void>, end: () => void}|null} */
  let current = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;

  function end() {
    clearTimeout(timer);
    const ended = current;
    current = null;
    const grown = edits.pending.find(({ op_id }) => op_id === ended?.op_id);
    if (grown) {
      const { growing: _no_more, ...made } = grown;
      edits.replace(made);
    }
    ended?.end();
  }

  function restartTimer() {
    clearTimeout(timer);
    timer = setTimeout(end, MAX_PRESS_INTERVAL_MS);
  }

  return {
    /** Begin an operation that later presses may extend. @param {string} op_id @param {string} gesture */
    begin(op_id, gesture) {
      let finish = () => {};
      /** @type {Promise<void>} */
      const finished = new Promise((resolve) => (finish = resolve));
      current = { op_id, gesture, finished, end: finish };
      restartTimer();
    },

    /** Make the command part of the current operation, if it continues it; returns whether it does. @param {Command} command @param {string} gesture */
    extend(command, gesture) {
      const last = edits.pending.at(-1);
      const before = /** @type {Command|undefined} */ (last?.command);
      if (current === null || last?.op_id !== current.op_id || current.gesture !== gesture) return false;
      if (before?.name !== command.name || before.key !== command.key || before.frame !== command.frame) return false;
      edits.replace({ ...last, command });
      edits.show();
      restartTimer();
      return true;
    },

    /** End the current operation, because something else is done or requested. */
    end,

    /** Resolves when an operation is no longer extended. @param {string} op_id @returns {Promise<void>|undefined} */
    finished: (op_id) => (current?.op_id === op_id ? current.finished : undefined),
  };
}
