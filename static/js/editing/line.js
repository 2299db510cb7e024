// @ts-check
/**
 * What can be taken back and brought back, in order, as a person has it before them: the server's word on what it has, and
 * then what is on its way to it. So an undo is about what was done last when its key is pressed. Pure.
 *
 * @typedef {import('../types.js').UndoTarget} UndoTarget
 * @typedef {import('./outbox.js').Pending} Pending
 *
 * @typedef {object} Line
 * @property {UndoTarget[]} done     what can be taken back, the next one last
 * @property {UndoTarget[]} undone   what can be brought back, the next one last
 * @property {boolean} earlier       before the first of `done` there may be more, which only the server knows
 * @property {boolean} later         the same of `undone`
 */
import { touchedKeys } from '../model/commands.js';
import { asCommand } from './pending.js';

/** What only the server knows: it says so when everything before is stored. @type {UndoTarget} */
export const UNKNOWN = Object.freeze({ op_id: '', name: '', frame: null, keys: [] });

/** Nothing is known yet. @type {Line} */
export const UNASKED = Object.freeze({ done: [], undone: [], earlier: true, later: true });

/**
 * What is next; null: nothing.
 * @param {Line} line
 * @param {'undo'|'redo'} what
 * @returns {UndoTarget|null}
 */
export function nextOf(line, what) {
  const [list, more] = what === 'undo' ? [line.done, line.earlier] : [line.undone, line.later];
  return list.at(-1) ?? (more ? UNKNOWN : null);
}

/**
 * The line after operations.
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

/** Without an operation. The server may have told of it already, where an answer was lost. @param {UndoTarget[]} list @param {UndoTarget} about */
const taken = (list, about) => (about.op_id === '' ? list.slice(0, -1) : list.filter(({ op_id }) => op_id !== about.op_id));
/** With it at the end. @param {UndoTarget[]} list @param {UndoTarget} about */
const moved = (list, about) => [...list.filter(({ op_id }) => about.op_id === '' || op_id !== about.op_id), about];

/**
 * The line as the server has it; what lies behind the next ones is kept where those agree.
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
