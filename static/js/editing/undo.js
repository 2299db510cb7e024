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
import { UNKNOWN_TARGET, nextTarget } from './undo_history.js';
import { commandName, describeUndone, withTrackNames, STILL_OPENING } from './command_names.js';

/**
 * @param {object} parts
 * @param {import('../state-types.js').Store} parts.store
 * @param {import('./editor_state.js').EditorState} parts.edits
 * @param {import('../core/toast.js').Notify} parts.toast
 * @param {(command: {name: 'undo'|'redo', op_id: string}, about: UndoTarget, gesture?: undefined, op_id?: string) => string} parts.enqueue   returns its op_id
 * @param {() => Promise<void>} parts.refresh
 */
export function createUndo({ store, edits, toast, enqueue, refresh }) {
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
  const isKnown = ({ op_id }) => edits.steps.has(op_id) || [...edits.pending, ...edits.early].some((one) => one.op_id === op_id);

  /** @param {'undo'|'redo'} what @param {string} [opId]   its op_id, if it has one already @returns {boolean} whether there is something to undo or redo */
  function revert(what, opId) {
    const about = edits.run === null ? null : edits.nextTarget(what);
    if (about === null) {
      toast(
        edits.run === null && isOpening(store.get())
          ? `${commandName(what)} was not possible: ${STILL_OPENING}.`
          : `There is nothing to ${what}.`,
        { topic: 'undo' },
      );
      return false;
    }
    const known = isKnown(about);
    const op_id = enqueue({ name: what, op_id: about.op_id }, about, undefined, opId);
    const docs = store.get().review?.docs ?? {};
    if (known) {
      announce(
        what,
        about,
        about.keys.flatMap((key) => docs[key] ?? []),
      );
    } else {
      awaited.add(op_id);
      const which = about === UNKNOWN_TARGET ? '' : ` (${describeUndone(about.name, about.frame)})`;
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
  async function resolveTarget(next) {
    const { name, op_id } = /** @type {{name: 'undo'|'redo', op_id: string}} */ (next.command);
    if (op_id !== '') return next;
    if (nextTarget(edits.history, name) === UNKNOWN_TARGET) await refresh();
    const about = nextTarget(edits.history, name);
    if (about === UNKNOWN_TARGET) throw new ApiError(0, 'offline', 'The server did not say what comes next.');
    return about && { ...next, command: { name, op_id: about.op_id }, about };
  }

  /** Handle an undo or redo that the server has stored. @param {Pending} done @param {readonly import('../types.js').TrackDoc[]} docs */
  function onStored({ op_id, command, about }, docs) {
    if (awaited.delete(op_id) && about) announce(/** @type {'undo'|'redo'} */ (command.name), about, docs);
  }

  /** @param {Pending} next @param {unknown} thrown */
  function onRefused(next, thrown) {
    const docs = store.get().review?.docs ?? {};
    const why =
      thrown instanceof ApiError && thrown.code === 'not_next'
        ? 'You have made other changes in another page since. This page is up to date now; press the key again to undo or redo those.'
        : thrown instanceof ApiError
          ? withTrackNames(thrown.message, docs)
          : 'Something in the page went wrong.';
    toast(`${commandName(next.command.name)} was not possible. ${why}`, { tone: 'bad', topic: 'undo' });
  }

  return { revert, resolveTarget, onStored, onRefused };
}
