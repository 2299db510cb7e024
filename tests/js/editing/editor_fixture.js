// @ts-check
/** A store on the review screen, a server in memory, and an editor between them. */
import { ApiError } from '../../../static/js/api/errors.js';
import { createBackgroundSender } from '../../../static/js/editing/background_sender.js';
import { createEditor } from '../../../static/js/editing/editor.js';
import { createMemoryOutbox } from '../../../static/js/editing/outbox.js';
import { applyCommand, touchedKeys } from '../../../static/js/model/commands.js';
import { emptyDoc } from '../../../static/js/model/documents.js';
import { changeReview, openReview } from '../../../static/js/store/actions/review.js';
import { initialState } from '../../../static/js/store/initial.js';
import { createStore } from '../../../static/js/store/store.js';

/** @typedef {import('../../../static/js/types.js').TrackDoc} TrackDoc */

export const RUN = 'r'.repeat(32);

/** A server that knows revisions, op_ids and one author's undo and redo. */
export function createServer() {
  const spans = { m1: { track: 1, first: 0, last: 99 }, m2: { track: 2, first: 50, last: 150 } };
  /** @type {Record<string, TrackDoc>} */
  const docs = {};
  /** @type {Map<string, any>} */
  const answers = new Map();
  /** @type {{op_id: string, name: string, frame: number, keys: string[], before: Record<string, TrackDoc>, after: Record<string, TrackDoc>}[]} */
  const done = [];
  /** @type {typeof done} */
  const undone = [];
  /** @param {string} key */
  const currentDoc = (key) => docs[key] ?? (key in spans ? emptyDoc(Reflect.get(spans, key)) : undefined);
  /** @param {any} command @returns {Record<string, any>} */
  const docsOf = (command) => Object.fromEntries(touchedKeys(command).flatMap((key) => (currentDoc(key) ? [[key, currentDoc(key)]] : [])));
  const target = (list = done) => {
    const one = list.at(-1);
    return one ? { op_id: one.op_id, name: one.name, frame: one.frame, keys: one.keys } : null;
  };
  const server = {
    docs,
    /** @type {string[]} */
    log: [],
    /** @type {(op_id: string) => void} */
    before: () => {},
    /** @type {(op_id: string) => void} */
    after: () => {},
    /** Somebody else's work. @param {any} command */
    editAsOther(command) {
      const { docs: made, changed } = applyCommand(docsOf(command), command, { author: 'b', time: '' });
      for (const key of changed) docs[key] = { ...made[key], revision: (docs[key]?.revision ?? 0) + 1 };
      return changed.map((key) => docs[key]);
    },
    annotation: async () => ({ seq: server.log.length, docs: Object.values(docs), undo: target(), redo: target(undone) }),
    /** @param {string} run @param {any} edit @param {Record<string, number>} revisions */
    async edit(run, { op_id, command }, revisions) {
      await Promise.resolve();
      server.before(op_id);
      if (!answers.has(op_id)) {
        /** @type {string[]} */
        let changed;
        if (command.name === 'undo' || command.name === 'redo') {
          const [from, to] = command.name === 'undo' ? [done, undone] : [undone, done];
          const last = from.at(-1);
          if (last === undefined || last.op_id !== command.op_id) throw new ApiError(409, 'not_next', 'That is not next.');
          from.pop();
          to.push(last);
          const goal = command.name === 'undo' ? last.before : last.after;
          changed = Object.keys(goal);
          for (const key of changed) docs[key] = { ...goal[key], revision: docs[key].revision + 1 };
        } else {
          for (const key of touchedKeys(command)) {
            const now = currentDoc(key)?.revision ?? 0;
            if (currentDoc(key) && revisions[key] === undefined) throw new ApiError(428, 'precondition_required', 'If-Match is missing.');
            if ((revisions[key] ?? 0) !== now)
              throw new ApiError(409, 'stale', 'Changed since.', { details: { current: [docs[key]], yours: [] } });
          }
          const made = applyCommand(docsOf(command), command, { author: 'a', time: '' });
          changed = made.changed;
          done.push({
            op_id,
            name: command.name,
            frame: command.frame,
            keys: changed,
            before: Object.fromEntries(changed.map((key) => [key, currentDoc(key) ?? { ...made.docs[key], gone: true }])),
            after: Object.fromEntries(changed.map((key) => [key, made.docs[key]])),
          });
          undone.length = 0;
          for (const key of changed) docs[key] = { ...made.docs[key], revision: (docs[key]?.revision ?? 0) + 1 };
        }
        server.log.push(command.name);
        answers.set(op_id, { op_id, seq: server.log.length, docs: changed.map((key) => docs[key]), undo: target(), redo: target(undone) });
      }
      server.after(op_id);
      return answers.get(op_id);
    },
  };
  return server;
}

/**
 * @param {ReturnType<typeof createServer>} [server]
 * @param {import('../../../static/js/editing/outbox.js').Outbox} [outbox]
 * @param {string|null} [open]   the run that is opened
 */
export async function createEditorFixture(server = createServer(), outbox = createMemoryOutbox(), open = RUN) {
  const store = createStore(initialState());
  const video = /** @type {any} */ ({ id: 'v', frames: 200, width: 100, height: 100 });
  const columns = { id: [1, 2], first: [0, 50], last: [99, 150], class_id: [14, 2] };
  store.dispatch((state) =>
    changeReview(openReview(state, video), {
      tracks: /** @type {any} */ (columns),
      run: /** @type {any} */ ({ id: RUN, state: 'complete' }),
    }),
  );
  /** @type {string[]} */
  const toasts = [];
  const aborter = new AbortController();
  let count = 0;
  const parts = {
    store,
    api: /** @type {any} */ (server),
    outbox,
    signal: aborter.signal,
    toast: (/** @type {string} */ text) => toasts.push(text),
    sleep: () => new Promise((/** @type {(value: void) => void} */ resolve) => void setTimeout(resolve, 1)),
  };
  const backgroundSender = createBackgroundSender(parts);
  const editor = createEditor({
    ...parts,
    backgroundSender,
    author: () => 'a',
    newId: () => `op-${Math.random()}-${count++}`,
  });
  if (open !== null) await editor.open(open);
  return {
    server,
    outbox,
    store,
    editor,
    backgroundSender,
    toasts,
    end: () => aborter.abort(),
    review: () => /** @type {import('../../../static/js/state-types.js').ReviewState} */ (store.get().review),
  };
}

/** A server that does not answer, as `server.before` or `server.after`. @returns {never} */
export function failOffline() {
  throw new ApiError(0, 'offline', 'Gone.');
}

/** @param {string} key @param {number} frame @param {number} at @returns {any} */
export const setBox = (key, frame, at) => ({ name: 'set_box', key, frame, box: [at, at, at + 10, at + 10] });
