// @ts-check
/**
 * The operations that can be undone and redone, in the order in which a person sees them: first those on the server,
 * then those on their way to it. An undo therefore takes back what was done last when its key is pressed. Pure
 * functions.
 *
 * @typedef {import('../types.js').UndoTarget} UndoTarget
 * @typedef {import('./outbox.js').Pending} Pending
 *
 * @typedef {object} UndoHistory
 * @property {UndoTarget[]} done     can be undone, the next one last
 * @property {UndoTarget[]} undone   can be redone, the next one last
 * @property {boolean} hasEarlier    there may be more before the first of `done`, which only the server knows
 * @property {boolean} hasLater      the same of `undone`
 */
import { touchedKeys } from '../model/commands.js';
import { asCommand } from './pending.js';

/** A target that only the server knows. The server names it when all operations before it are stored. @type {UndoTarget} */
export const UNKNOWN_TARGET = Object.freeze({ op_id: '', name: '', frame: null, keys: [] });

/** The history before the server has answered. @type {UndoHistory} */
export const UNKNOWN_HISTORY = Object.freeze({ done: [], undone: [], hasEarlier: true, hasLater: true });

/** The next target; null: none. @param {UndoHistory} history @param {'undo'|'redo'} what @returns {UndoTarget|null} */
export function nextTarget(history, what) {
  const [list, more] = what === 'undo' ? [history.done, history.hasEarlier] : [history.undone, history.hasLater];
  return list.at(-1) ?? (more ? UNKNOWN_TARGET : null);
}

/**
 * The history after some operations.
 * @param {UndoHistory} history
 * @param {readonly Pick<Pending, 'op_id'|'command'|'about'>[]} operations   in order
 * @returns {UndoHistory}
 */
export function afterOperations(history, operations) {
  return operations.reduce((at, { op_id, command, about = UNKNOWN_TARGET }) => {
    const edit = asCommand(command);
    if (edit !== null)
      return {
        ...at,
        done: appended(at.done, { op_id, name: edit.name, frame: edit.frame, keys: touchedKeys(edit) }),
        undone: [],
        hasLater: false,
      };
    return command.name === 'undo'
      ? { ...at, done: without(at.done, about), undone: appended(at.undone, about) }
      : { ...at, undone: without(at.undone, about), done: appended(at.done, about) };
  }, history);
}

/** The list without an operation. If an answer was lost, the server may have named the operation already. @param {UndoTarget[]} list @param {UndoTarget} about */
const without = (list, about) => (about.op_id === '' ? list.slice(0, -1) : list.filter(({ op_id }) => op_id !== about.op_id));
/** The list with the operation at its end. @param {UndoTarget[]} list @param {UndoTarget} about */
const appended = (list, about) => [...list.filter(({ op_id }) => about.op_id === '' || op_id !== about.op_id), about];

/**
 * The history as the server has it. If the next targets agree, the known targets behind them are kept.
 * @param {UndoHistory} history
 * @param {{undo: UndoTarget|null, redo: UndoTarget|null}} answer
 * @returns {UndoHistory}
 */
export function reconcile(history, { undo, redo }) {
  /** @param {UndoTarget[]} list @param {boolean} more @param {UndoTarget|null} next @returns {[UndoTarget[], boolean]} */
  const reconcileList = (list, more, next) => {
    if (next === null) return [[], false];
    return list.at(-1)?.op_id === next.op_id ? [[...list.slice(0, -1), next], more] : [[next], true];
  };
  const [done, hasEarlier] = reconcileList(history.done, history.hasEarlier, undo);
  const [undone, hasLater] = reconcileList(history.undone, history.hasLater, redo);
  return { done, undone, hasEarlier, hasLater };
}
