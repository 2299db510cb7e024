// @ts-check
/**
 * The operations that can be undone and redone, in the order in which a person sees them: first those on the server,
 * then those on their way to it. An undo therefore takes back what was done last when its key is pressed. Pure
 * functions.
 *
 * @typedef {import('../types.js').UndoTarget} UndoTarget
 * @typedef {import('./outbox.js').Pending} Pending
 *
 * @typedef {object} Line
 * @property {UndoTarget[]} done     can be undone, the next one last
 * @property {UndoTarget[]} undone   can be redone, the next one last
 * @property {boolean} earlier       there may be more before the first of `done`, which only the server knows
 * @property {boolean} later         the same of `undone`
 */
import { touchedKeys } from '../model/commands.js';
import { asCommand } from './pending.js';

/** A target that only the server knows. The server names it when all operations before it are stored. @type {UndoTarget} */
export const UNKNOWN = Object.freeze({ op_id: '', name: '', frame: null, keys: [] });

/** Nothing is known yet. @type {Line} */
export const UNASKED = Object.freeze({ done: [], undone: [], earlier: true, later: true });

/**
 * The next target; null: none.
 * @param {Line} line
 * @param {'undo'|'redo'} what
 * @returns {UndoTarget|null}
 */
export function nextOf(line, what) {
  const [list, more] = what === 'undo' ? [line.done, line.earlier] : [line.undone, line.later];
  return list.at(-1) ?? (more ? UNKNOWN : null);
}

/**
 * The line after some operations.
 * @param {Line} line
 * @param {readonly Pick<Pending, 'op_id'|'command'|'about'>[]} operations   in order
 * @returns {Line}
 */
export function after(line, operations) {
  return operations.reduce((at, { op_id, command, about = UNKNOWN }) => {
    const own = asCommand(command);
    if (own !== null)
      return { ...at, done: moved(at.done, { op_id, name: own.name, frame: own.frame, keys: touchedKeys(own) }), undone: [], later: false };
    return command.name === 'undo'
      ? { ...at, done: taken(at.done, about), undone: moved(at.undone, about) }
      : { ...at, undone: taken(at.undone, about), done: moved(at.done, about) };
  }, line);
}

/** The list without an operation. If an answer was lost, the server may have named the operation already. @param {UndoTarget[]} list @param {UndoTarget} about */
const taken = (list, about) => (about.op_id === '' ? list.slice(0, -1) : list.filter(({ op_id }) => op_id !== about.op_id));
/** The list with the operation at its end. @param {UndoTarget[]} list @param {UndoTarget} about */
const moved = (list, about) => [...list.filter(({ op_id }) => about.op_id === '' || op_id !== about.op_id), about];

/**
 * The line as the server has it. If the next targets agree, the known targets behind them are kept.
 * @param {Line} line
 * @param {{undo: UndoTarget|null, redo: UndoTarget|null}} answer
 * @returns {Line}
 */
export function agreed(line, { undo, redo }) {
  /** @param {UndoTarget[]} list @param {boolean} more @param {UndoTarget|null} next @returns {[UndoTarget[], boolean]} */
  const side = (list, more, next) => {
    if (next === null) return [[], false];
    return list.at(-1)?.op_id === next.op_id ? [[...list.slice(0, -1), next], more] : [[next], true];
  };
  const [done, earlier] = side(line.done, line.earlier, undo);
  const [undone, later] = side(line.undone, line.later, redo);
  return { done, undone, earlier, later };
}
