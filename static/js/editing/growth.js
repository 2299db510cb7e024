// @ts-check
/**
 * Moving a box by keys: presses without a pause form one operation, like a drag by mouse. It is kept with each press
 * and sent when the keys rest.
 *
 * @typedef {import('../types.js').Command} Command
 */

/** Pause that ends the operation, ms. Longer than the delay after which a keyboard repeats a held key. */
export const REST = 1000;

/** @param {import('./work.js').Work} work */
export function createGrowth(work) {
  /** @type {{op_id: string, gesture: string, over: Promise<void>, end: () => void}|null} */
  let growing = null;
  /** @type {ReturnType<typeof setTimeout>|undefined} */
  let timer;

  function end() {
    clearTimeout(timer);
    const ended = growing;
    growing = null;
    const grown = work.pending.find(({ op_id }) => op_id === ended?.op_id);
    if (grown) {
      const { growing: _no_more, ...made } = grown;
      work.replace(made);
    }
    ended?.end();
  }

  function restart() {
    clearTimeout(timer);
    timer = setTimeout(end, REST);
  }

  return {
    /** Begin an operation that may grow. @param {string} op_id @param {string} gesture */
    begin(op_id, gesture) {
      let finish = () => {};
      /** @type {Promise<void>} */
      const over = new Promise((resolve) => (finish = resolve));
      growing = { op_id, gesture, over, end: finish };
      restart();
    },

    /** Whether the command continues the growing operation; if so, it becomes part of it. @param {Command} command @param {string} gesture */
    goOn(command, gesture) {
      const last = work.pending.at(-1);
      const before = /** @type {Command|undefined} */ (last?.command);
      if (growing === null || last?.op_id !== growing.op_id || growing.gesture !== gesture) return false;
      if (before?.name !== command.name || before.key !== command.key || before.frame !== command.frame) return false;
      work.replace({ ...last, command });
      work.show();
      restart();
      return true;
    },

    /** End the growth, because something else is done or requested. */
    end,

    /** Resolves when an operation no longer grows. @param {string} op_id @returns {Promise<void>|undefined} */
    over: (op_id) => (growing?.op_id === op_id ? growing.over : undefined),
  };
}
