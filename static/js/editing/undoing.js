// @ts-check
/**
 * Undo and redo are operations like others and keep their place among them. The target is decided when the key is
 * pressed, and its effect is shown at once if this page knows it; otherwise the server names the target when the
 * operation's turn comes.
 *
 * @typedef {import('./outbox.js').Pending} Pending
 * @typedef {import('../types.js').UndoTarget} UndoTarget
 */
import { ApiError } from '../api/errors.js';
import { subjectOf } from '../model/effective.js';
import { isOpening } from '../model/review_notice.js';
import { trackName } from '../model/track_name.js';
import { seek, select } from '../store/actions/review.js';
import { UNKNOWN, nextOf } from './line.js';
import { describe, describeUndone, named, OPENING } from './words.js';

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {import('./work.js').Work} parts.work
 * @param {(text: string, options?: import('../core/toast.js').ToastOptions) => void} parts.toast
 * @param {(command: {name: 'undo'|'redo', op_id: string}, about: UndoTarget, gesture?: undefined, op_id?: string) => string} parts.enqueue   returns its op_id
 * @param {() => Promise<void>} parts.refresh
 */
export function createUndoing({ store, work, toast, enqueue, refresh }) {
  /** Ids of operations whose result the user waits for. @type {Set<string>} */
  const awaited = new Set();

  /** @param {'undo'|'redo'} what @param {UndoTarget} about @param {readonly import('../types.js').TrackDoc[]} docs */
  function announce(what, about, docs) {
    const subject = subjectOf(docs, about.frame);
    // show the frame and the track: an undo must not change something out of sight
    store.dispatch((state) => select(about.frame === null ? state : seek(state, about.frame), subject?.key ?? null));
    const doc = subject ?? docs[0];
    toast(
      `${what === 'undo' ? 'Undone' : 'Done again'}: ${describeUndone(about.name, about.frame, doc && trackName(doc.key, doc), docs.length)}`,
      { topic: 'undo' },
    );
  }

  /** Whether this page knows the effect on the tracks. @param {UndoTarget} about */
  const isKnown = ({ op_id }) => work.steps.has(op_id) || [...work.pending, ...work.early].some((one) => one.op_id === op_id);

  /** @param {'undo'|'redo'} what @param {string} [as]   its op_id, if it has one already @returns {boolean} whether there is something to undo or redo */
  function press(what, as) {
    const about = work.run === null ? null : work.next(what);
    if (about === null) {
      toast(
        work.run === null && isOpening(store.get()) ? `${describe(what)} was not possible: ${OPENING}.` : `There is nothing to ${what}.`,
        { topic: 'undo' },
      );
      return false;
    }
    const known = isKnown(about);
    const op_id = enqueue({ name: what, op_id: about.op_id }, about, undefined, as);
    const docs = store.get().review?.docs ?? {};
    if (known) {
      announce(
        what,
        about,
        about.keys.flatMap((key) => docs[key] ?? []),
      );
    } else {
      awaited.add(op_id);
      const which = about === UNKNOWN ? '' : ` (${describeUndone(about.name, about.frame)})`;
      const why = store.get().connection === 'offline' ? 'The server cannot be reached' : 'Waiting for the server';
      toast(`${why}: ${what}${which} follows its answer.`, { topic: 'undo' });
    }
    return true;
  }

  /**
   * The next undo or redo to send, with its target; null: there is none.
   * @param {Pending} next
   * @returns {Promise<Pending|null>}
   * @throws {ApiError} the server did not name the target
   */
  async function resolved(next) {
    const { name, op_id } = /** @type {{name: 'undo'|'redo', op_id: string}} */ (next.command);
    if (op_id !== '') return next;
    if (nextOf(work.line, name) === UNKNOWN) await refresh();
    const about = nextOf(work.line, name);
    if (about === UNKNOWN) throw new ApiError(0, 'offline', 'The server did not say what comes next.');
    return about && { ...next, command: { name, op_id: about.op_id }, about };
  }

  /** Handle an undo or redo that the server has stored. @param {Pending} done @param {readonly import('../types.js').TrackDoc[]} docs */
  function stored({ op_id, command, about }, docs) {
    if (awaited.delete(op_id) && about) announce(/** @type {'undo'|'redo'} */ (command.name), about, docs);
  }

  /** @param {Pending} next @param {unknown} thrown */
  function refused(next, thrown) {
    const docs = store.get().review?.docs ?? {};
    const why =
      thrown instanceof ApiError && thrown.code === 'not_next'
        ? 'You have made other changes in another page since. This page is up to date now; press the key again to undo or redo those.'
        : thrown instanceof ApiError
          ? named(thrown.message, docs)
          : 'Something in the page went wrong.';
    toast(`${describe(next.command.name)} was not possible. ${why}`, { tone: 'bad', topic: 'undo' });
  }

  return { press, resolved, stored, refused };
}
